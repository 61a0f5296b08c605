"""What a model is: the functions by which a unit, a composition and a trace know it."""
