"""Operability: how much of the time a scene's criteria hold in the seas of a place."""
