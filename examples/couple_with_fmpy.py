"""Ship, line and cradle coupled with nothing but fmpy: ``python couple_with_fmpy.py [DIRECTORY WITH THE FMUS]``.

Every communication step is done twice. The first pass extrapolates the pull of the line from its value and rate; the
units then go back to the start of the step, and the second pass uses the cubic through the values and rates at both
ends. Held inputs would be of order 1 and create energy; this is of order 4. At 60 s a submersible docks.
"""

import sys
from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

STEP, END = 0.125, 120.0


class Instance:
    """A running FMU whose variables are called by name."""

    def __init__(self, path, **parameters):
        description = read_model_description(str(path))
        self.reference = {v.name: v.valueReference for v in description.modelVariables}
        self.fmu = FMU2Slave(guid=description.guid, unzipDirectory=extract(str(path)), instanceName=path.stem,
                             modelIdentifier=description.coSimulation.modelIdentifier)  # fmt: skip
        self.fmu.instantiate()
        self.set(**parameters)
        self.fmu.setupExperiment()
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def set(self, **values):
        """Set variables, SI."""
        """Set variables by name, SI."""
        self.fmu.setReal([self.reference[n] for n in values], list(values.values()))

    def get(self, *names):
        """Values of variables, SI."""
        """Values of variables by name, SI."""
        return self.fmu.getReal([self.reference[n] for n in names])


def cubic(name, a, a_rate, b, b_rate):
    """An input over a step, from value and rate at its ends: the unit takes it as a Taylor series from the start."""
    d2 = (6.0 * (b - a) / STEP - 4.0 * a_rate - 2.0 * b_rate) / STEP
    d3 = (12.0 * (a - b) / STEP + 6.0 * (a_rate + b_rate)) / STEP**2
    return {name: a, f"{name}_d1": a_rate, f"{name}_d2": d2, f"{name}_d3": d3}


def main(directory):
    """Couple the FMUs of a directory."""
    ship = Instance(directory / "ship.fmu", heave_amplitude=0.6, heave_period=8.0, ramp_time=16.0, mass=9.1e5,
                stiffness=2.3e6, damping=1.5e5)  # fmt: skip
    line = Instance(directory / "spring_line.fmu", stiffness=3.3e4, static_tension=8e4)
    cradle = Instance(directory / "cradle.fmu", mass=3.6e4, added_mass=1.7e4, weight_in_water=8e4, drag_area=51.0,
                  docking_time=60.0, submersible_mass=2.6e4)  # fmt: skip

    def pull():
        """Both ends of the line as they are now; then tension and reaction with their rates."""
        top, top_rate = ship.get("heave", "heave_rate")
        bottom, bottom_rate = cradle.get("heave", "heave_rate")
        line.set(heave_top=top, heave_top_d1=top_rate, heave_bottom=bottom, heave_bottom_d1=bottom_rate)
        return line.get("tension", "tension_rate", "reaction", "reaction_rate")

    heaves = []
    for k in range(round(END / STEP)):
        tension, _, reaction, _ = pull()
        cradle.set(line_tension=tension)  # outputs are now those after an event, if there is one: the docking
        ship.set(reaction=reaction)
        tension, tension_rate, reaction, reaction_rate = pull()
        t_end, t_rate = tension + STEP * tension_rate, tension_rate
        r_end, r_rate = reaction + STEP * reaction_rate, reaction_rate
        states = [(unit, unit.fmu.getFMUstate()) for unit in (ship, cradle, line)]
        for correction in (False, True):
            for unit, state in states if correction else ():
                unit.fmu.setFMUstate(state)
            cradle.set(**cubic("line_tension", tension, tension_rate, t_end, t_rate))
            ship.set(**cubic("reaction", reaction, reaction_rate, r_end, r_rate))
            for unit, _ in states:
                unit.fmu.doStep(k * STEP, STEP)
            t_end, t_rate, r_end, r_rate = pull()
        for unit, state in states:
            unit.fmu.freeFMUstate(state)
        heaves.append(cradle.get("heave")[0])
    for unit, _ in states:
        unit.fmu.terminate()
        unit.fmu.freeInstance()
    alone, docked = (max(map(abs, heaves[int(a / STEP) : int(b / STEP)])) for a, b in ((44.0, 60.0), (104.0, 120.0)))
    print(f"cradle: largest heave {alone:.4f} m before docking, {docked:.4f} m with the submersible aboard")
    return heaves


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "dist"))
