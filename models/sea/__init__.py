"""Irregular waves, heave response of a hull, a ship in the sea."""
