"""Files that describe a unit: XML of FMI 2 and 3, documentation, the archive."""
