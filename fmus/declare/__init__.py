"""What a unit declares: its variables, their units of measure, scenes as units."""
