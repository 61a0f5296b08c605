"""Models joined into one, without an interface and so without its error."""
