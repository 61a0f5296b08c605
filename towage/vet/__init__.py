"""An FMU of another make, tried in processes of its own before it is coupled."""
