"""Many members of a scene computed at once."""
