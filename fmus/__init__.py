"""Units: the physics of `models` declared and packaged as FMI co-simulation units. Nothing here knows physics."""

UNITS = ("ship", "spring_line", "cradle", "cradle_on_line")
"""Names of the units shipped, each a module of this package with a ``UNIT``."""
