"""Parameters of a ship in a sea: hull, waves, the point that holds the line, and what files say."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from ..heave import ship
from ..numeric.ops import Value
from ..protocol.variables import parameter
from .response_table import ResponseTable
from .seas import SeaTable, Shape

STRUCTURE = Shape._fields
"""Parameters from which the table of components is made."""


@dataclass(frozen=True)
class HullAndWaves:
    """Box of the hull and components of the sea, SI."""

    length: Annotated[Value, parameter("m", 40.0, "Length of the ship", display="ft", min=1e-3)]
    breadth: Annotated[Value, parameter("m", 10.0, "Breadth", display="ft", min=1e-3)]
    draught: Annotated[Value, parameter("m", 2.5, "Draught", display="ft", min=1e-3)]
    block_coefficient: Annotated[Value, parameter("1", 0.7, "Block coefficient", min=0.1, max=1.0)]
    smith_oblique: Annotated[
        Value, parameter("1", 0.0, "Smith factor: 0 exp(-k T), 1 exp(-k |cos beta| T)", min=0.0, max=1.0)
    ]
    peakedness: Annotated[
        Value, parameter("1", 1.0, "gamma of JONSWAP; 1: Bretschneider and Pierson-Moskowitz", min=1.0, max=10.0)
    ]
    components: Annotated[Value, parameter("1", 100.0, "Number of wave components", min=1.0, max=300.0)]
    spreading: Annotated[
        Value,
        parameter("1", -1.0, "s of the directional distribution cos^2s; negative: long-crested", min=-1.0, max=40.0),
    ]
    directions: Annotated[Value, parameter("1", 8.0, "Number of wave directions, more than s + 2", min=1.0, max=48.0)]
    order: Annotated[
        Value, parameter("1", 1.0, "lambda of the peak after Ochi and Hubble; 1: Pierson-Moskowitz", min=0.3, max=20.0)
    ]
    second_share: Annotated[
        Value, parameter("1", 0.0, "Share of the energy (of Hs squared) in a second peak", min=0.0, max=0.999)
    ]
    second_frequency: Annotated[
        Value, parameter("1", 0.5, "Peak frequency of the second peak over that of the first", min=0.1, max=10.0)
    ]
    second_peakedness: Annotated[Value, parameter("1", 1.0, "gamma of the second peak", min=1.0, max=10.0)]
    second_order: Annotated[Value, parameter("1", 1.0, "lambda of the second peak", min=0.3, max=20.0)]
    second_direction: Annotated[
        Value, parameter("rad", 0.0, "Direction of the second peak less that of the first", display="deg")
    ]
    seed: Annotated[Value, parameter("1", 1964.0, "Seed of the phases, a whole number", min=0.0, max=9e15)]
    update_interval: Annotated[
        Value, parameter("s", 10.0, "Time between looks at the sea, which it then follows smoothly", min=1e-3)
    ]
    point_x: Annotated[
        Value, parameter("m", 0.0, "Point that holds the line, ahead of where the responses are given", display="ft")
    ]
    point_y: Annotated[
        Value, parameter("m", 0.0, "To port; needs a table of responses, as the closed form has no roll", display="ft")
    ]
    point_z: Annotated[Value, parameter("m", 0.0, "Up", display="ft")]


@dataclass(frozen=True)
class Parameters(ship.Oscillator, HullAndWaves):
    """Hull and waves first, then the oscillator of `ship`. A unit that was given files has a table of ``responses`` in place of
    the closed form, a measured ``spectrum`` in place of peaks."""

    responses: ClassVar[ResponseTable | None] = None
    spectrum: ClassVar[SeaTable | None] = None
