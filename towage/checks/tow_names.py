"""The names that the check of tows and its numbers share."""

UNITS = ("tow_system", "tow_cable", "tow_cable_nonlinear")
"""The units that tow."""
SPRING = "spring EA/L"
"""The finding on the simplest model of a tow."""
