"""What another package may bring to towage: a unit, a scheme, a check and a writer."""
