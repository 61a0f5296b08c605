"""Unit `sway_craft`: towing craft with one degree of freedom, lateral force of the rope in, lateral motion out."""

from ..models.slender import sway_craft
from .declare.unit import Unit, calculated, entry, local, margin, output, parameter

UNIT = Unit(
    name="sway_craft",
    description="Towing craft in sway: prescribed lateral motion, plus the response of its sway oscillator to the rope",
    model=sway_craft,
    parameters=(
        parameter("sway_amplitude", "m", 0.1, "Amplitude of the free sway", display="ft"),
        parameter("sway_period", "s", 12.0, "Period of the free sway", min=1e-9),
        parameter("sway_phase", "rad", 0.0, "Phase of the free sway: a sin(2 pi t / period + phase)", display="deg"),
        parameter("ramp_time", "s", 0.0, "Duration of a smooth start of the sway; 0: none", min=0.0),
        parameter("mass", "kg", 1e5, "Mass with sway added mass", display="lb", min=1e-9),
        parameter("damping", "N.s/m", 0.0, "Linear sway damping", display="lbf.s/ft", min=0.0),
        parameter("stiffness", "N/m", 1e3, "Stiffness of course keeping", display="lbf/ft", min=1e-12),
        parameter("speed_start", "m/s", 1.0, "Tow speed at the start", display="kn", min=0.0),
        parameter("speed_end", "m/s", 1.0, "Tow speed after the change", display="kn", min=0.0),
        parameter("speed_change_start", "s", 0.0, "Time at which the speed begins to change"),
        parameter("speed_change_time", "s", 0.0, "Duration of the change of speed; 0: none", min=0.0),
        parameter("sdof_tolerance", "1", 0.05, "Share of the free amplitude by which the rope may move the craft",
                  min=1e-9),
    ),
    calculated=(
        calculated("port_mass", "kg", "Mass seen by the rope"),
        calculated("natural_frequency", "rad/s", "sqrt(k/m)"),
        calculated("damping_ratio", "1", "c / (2 sqrt(k m))"),
    ),
    inputs=(entry("lateral_force", "N", 0.0, "Lateral force of the rope, positive to port", display="lbf"),),
    outputs=(
        output("lateral", "m", "Lateral position of the point that holds the rope, positive to port", display="ft",
               rate=True),
        output("free_lateral", "m", "Lateral position without the rope", display="ft", rate=True),
        output("tow_speed", "m/s", "Tow speed", display="kn", rate=True),
        margin("sdof", "1 - |z| / (sdof_tolerance a), z the response to the rope and a the free amplitude"),
    ),
    states=(
        local("response", "m", "Response to the rope's force"),
        local("response_rate", "m/s", "Its time derivative"),
    ),
    start={"mass": 2e4, "damping": 1e3, "ramp_time": 4.0, "speed_end": 3.0, "speed_change_time": 15.0},
    reference_inputs={"lateral_force": (200.0, 0.9)},
)  # fmt: skip
