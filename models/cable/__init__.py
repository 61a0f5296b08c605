"""Tow cable with body or float by small perturbation and without it (US Navy programs OMWAY and OMFLO)."""
