"""The Python flavour: an FMU around the model itself."""
