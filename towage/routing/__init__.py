"""Files of voyages: ships and seas in, routes out."""
