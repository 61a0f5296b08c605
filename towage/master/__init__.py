"""The coupling: system, schemes, simulation, record."""
