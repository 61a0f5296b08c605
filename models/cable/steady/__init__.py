"""The tow over frequency: steady shape, its perturbation, the response along the cable."""
