"""Reference cases, recomputed."""
