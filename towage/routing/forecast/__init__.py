"""Forecasts of waves, wind and currents from files onto the plane of a route."""
