"""A spring in two directions by component-model: vectors, as variables "end[0]" and "end[1]", in its own units."""

from component_model.model import Model
from component_model.variable import Variable


class ComponentSpring(Model):
    def __init__(self, **kwargs):
        super().__init__("ComponentSpring", "A spring to the origin", "nobody", **kwargs)
        self._stiffness = Variable(
            self, "stiffness", "Stiffness", causality="parameter", variability="fixed", start="1.0 N/m"
        )
        self._end = Variable(
            self, "end", "Position of the end", causality="input", variability="continuous", start=("0.0 m", "0.0 m")
        )
        self._pull = Variable(
            self, "pull", "Force at the end", causality="output", variability="continuous", initial="exact",
            start=("0.0 N", "0.0 N"),
        )  # fmt: skip

    def do_step(self, current_time, step_size):
        super().do_step(current_time, step_size)
        self.pull = -self.stiffness * self.end
        return True
