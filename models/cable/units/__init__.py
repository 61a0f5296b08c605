"""The models of the towing units."""
