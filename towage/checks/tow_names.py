"""The names that the check of tows and its numbers share."""

LINEAR = ("tow_system", "tow_cable")
UNITS = (*LINEAR, "tow_cable_nonlinear")
"""The units that tow, and those of small perturbations."""
