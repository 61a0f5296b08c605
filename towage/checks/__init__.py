"""What is said of a run: checks before it and after it, and the verdict."""
