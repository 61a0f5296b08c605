"""The nonlinear wire: one elastic cable in the plane or in space, from hanging at rest to towing in a turn."""
