"""Many members of one composed scene in one compiled program."""
