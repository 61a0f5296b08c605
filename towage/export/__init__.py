"""Scenes for other programs: OSP and SSP."""
