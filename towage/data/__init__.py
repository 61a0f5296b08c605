"""Files that people give to units: responses of ships, spectra, measured series."""
