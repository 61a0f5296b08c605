"""Systems of other formats (SSP, OSP) as the tables of a scene."""
