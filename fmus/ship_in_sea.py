"""Unit `ship_in_sea`: the ship in an irregular sea that may change along a voyage, reaction of the line in."""

from ..models.sea import ship_in_sea
from .declare.unit import Unit, entry, margin, output, parameter
from .ship import UNIT as SHIP

SHARED = {v.name: v for v in SHIP.parameters}

UNIT = Unit(
    name="ship_in_sea",
    description="Ship in an irregular sea: closed-form heave response, plus that of its oscillator to the line",
    model=ship_in_sea,
    parameters=(
        parameter("length", "m", 100.0, "Length of the ship", display="ft", min=1e-3),
        parameter("breadth", "m", 15.0, "Breadth", display="ft", min=1e-3),
        parameter("draught", "m", 5.0, "Draught", display="ft", min=1e-3),
        parameter("block_coefficient", "1", 0.7, "Block coefficient", min=0.1, max=1.0),
        parameter("smith_oblique", "1", 0.0, "Smith factor: 0 exp(-k T), 1 exp(-k |cos beta| T)", min=0.0, max=1.0),
        parameter("peakedness", "1", 1.0, "gamma of JONSWAP; 1: Bretschneider and Pierson-Moskowitz", min=1.0, max=10.0),
        parameter("components", "1", 100.0, "Number of wave components", min=1.0, max=300.0),
        parameter("spreading", "1", -1.0, "s of the directional distribution cos^2s; negative: long-crested", min=-1.0,
                  max=40.0),
        parameter("directions", "1", 8.0, "Number of wave directions, more than s + 2", min=1.0, max=48.0),
        parameter("seed", "1", 1964.0, "Seed of the phases, a whole number", min=0.0, max=9e15),
        parameter("update_interval", "s", 10.0, "Time between looks at the sea, which it then follows smoothly",
                  min=1e-3),
        SHARED["ramp_time"], SHARED["mass"], SHARED["damping"], SHARED["stiffness"], SHARED["sdof_tolerance"],
    ),
    calculated=SHIP.calculated,
    inputs=(
        *SHIP.inputs,
        entry("wave_height", "m", 2.0, "Significant wave height", display="ft"),
        entry("wave_period", "s", 0.0, "Peak period; 0: that of a Pierson-Moskowitz sea of this height"),
        entry("wave_direction", "rad", 3.141592653589793, "Angle between the course and the waves' travel; pi head sea",
              display="deg"),
        entry("speed", "m/s", 0.0, "Speed of the ship", display="kn"),
    ),
    outputs=(
        *(v for v in SHIP.outputs if v.name != "margin_sdof"),
        output("significant_heave", "m", "Significant heave (double amplitude) without the line", display="ft"),
        margin("sdof", "1 - |z| / (sdof_tolerance a), z the response to the line and a the significant amplitude"),
        margin("froude", "1 - V / (0.3 sqrt(g L))"),
        margin("slow_sea", "1 - change of the sea a wave period / 0.1, the worst of height, frequency and direction"),
    ),
    start={"mass": 8e5, "damping": 1e5, "stiffness": 2e6, "ramp_time": 4.0, "wave_height": 3.0, "speed": 5.0},
    reference_inputs={"reaction": (5.0e4, 0.9)},
    not_native="its components are tables made from the seed in integer arithmetic, and their number is a parameter",
)  # fmt: skip
