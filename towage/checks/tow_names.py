"""The names that the check of tows and its numbers share."""

WHOLE = "tow_system"
LINEAR = (WHOLE, "tow_cable")
"""The units of small perturbations: that with its body, and all."""
SMALL = "margin_small_perturbation"
"""The margin of linear tows that is a rough sign until a check has found the error: it decides nothing by itself."""
OWN = ("tension_top", "tension_body", "body_surge", "body_heave")
"""What the check compares of a linear tow with its body (`WHOLE`)."""
