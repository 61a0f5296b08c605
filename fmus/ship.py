"""Unit `ship`: heave of the ship, reaction of the line in."""

from ..models.heave import ship
from .declare.unit import Unit, calculated, entry, local, margin, output, parameter, tunable

UNIT = Unit(
    name="ship",
    description="Ship in heave: prescribed free motion, plus the response of its heave oscillator to the line",
    model=ship,
    parameters=(
        parameter("heave_amplitude", "m", 1.0, "Amplitude of the free heave", display="ft"),
        parameter("heave_period", "s", 8.0, "Period of the free heave", min=1e-9),
        parameter("heave_phase", "rad", 0.0, "Phase of the free heave: a sin(2 pi t / period + phase)", display="deg"),
        parameter("ramp_time", "s", 0.0, "Duration of a smooth start; 0: none", min=0.0),
        tunable("mass", "kg", 1e6, "Mass with heave added mass", display="lb", min=1e-9),
        tunable("damping", "N.s/m", 0.0, "Linear heave damping", display="lbf.s/ft", min=0.0),
        tunable("stiffness", "N/m", 1e6, "Water-plane stiffness", display="lbf/ft", min=1e-12),
        parameter("sdof_tolerance", "1", 0.05, "Share of the free amplitude by which the line may move the ship",
                  min=1e-9),
    ),
    calculated=(
        calculated("port_mass", "kg", "Mass seen by the line", "tunable"),
        calculated("natural_frequency", "rad/s", "sqrt(K1/m1)", "tunable"),
        calculated("damping_ratio", "1", "c1 / (2 sqrt(K1 m1))", "tunable"),
    ),
    inputs=(entry("reaction", "N", 0.0, "Excess of the line's pull over its static value, down on the ship",
                  display="lbf"),),
    outputs=(
        output("heave", "m", "Heave of the point that holds the line, positive up", display="ft", rate=True),
        output("velocity", "m/s", "Heave velocity, positive up", display="ft/s", rate=True),
        output("free_heave", "m", "Heave without the line's reaction", display="ft", rate=True),
        margin("sdof", "1 - |z| / (sdof_tolerance a), z the response to the line and a the free amplitude"),
    ),
    states=(
        local("response", "m", "Response to the line's reaction"),
        local("response_rate", "m/s", "Its time derivative"),
    ),
    start={"mass": 8e5, "damping": 1e5, "stiffness": 2e6, "ramp_time": 4.0},
    reference_inputs={"reaction": (5.0e4, 0.9)},
)  # fmt: skip
