"""FMUs at work: archives, descriptions, calls, where they are kept, whether they are to be trusted."""
