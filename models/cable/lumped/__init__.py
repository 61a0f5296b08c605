"""The tow in time: lumped cable, linear models of it and their reduction, their error."""
