"""Ship, spring line and cradle in heave, and the theory of one degree of freedom (MIT thesis, 1969)."""
