"""A module of the package that its unit needs, so that the unit's FMU must carry it."""

DESCRIPTION = "A buoy that heaves as it is told"
