"""A mass on rollers, by PythonFMU as its manual has it: the velocity is an attribute, no variable, so a saved state lacks it."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real, String


class HiddenMass(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.mass, self.force, self.position, self.steps, self.maker = 1.0, 0.0, 1.0, 0, "elsewhere"
        self.velocity = 0.0
        self.register_variable(
            Real("mass", start=1.0, causality=Fmi2Causality.parameter, variability=Fmi2Variability.fixed)
        )
        self.register_variable(String("maker", causality=Fmi2Causality.parameter, variability=Fmi2Variability.fixed))
        self.register_variable(Real("force", start=0.0, causality=Fmi2Causality.input))
        self.register_variable(Real("position", causality=Fmi2Causality.output))
        self.register_variable(Integer("steps", causality=Fmi2Causality.output, variability=Fmi2Variability.discrete))

    def do_step(self, t, h):
        acceleration = self.force / self.mass
        self.position += h * (self.velocity + 0.5 * h * acceleration)
        self.velocity += h * acceleration
        self.steps += 1
        return True
