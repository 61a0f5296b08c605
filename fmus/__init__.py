"""Units: the physics of `models` declared and packaged as FMI co-simulation units. Nothing here knows physics."""

UNITS = ("ship", "spring_line", "cradle", "cradle_on_line", "slender_body", "sway_craft", "tow_system", "tow_cable", "towed_body",
         "wire", "turning_ship", "body_force", "ship_in_sea", "playback")
"""Names of the units shipped, each a module of this package with a ``UNIT``."""
