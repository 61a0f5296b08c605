"""Many runs of a scene: designs, workers, journal, tables, report."""
