"""Tools without physics: kinds of values, integration, exact steps, what a function depends on."""
