"""Bodies that cannot be: what the models of the shipped units require of their parameters, asked before anything runs.

An FMU asks the same when it is initialised (`towage.models.protocol.model.Model.requirements`), so that one whose model is
not known here is refused then.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from towage.fmus.declare.unit import Unit
from towage.models.numeric.ops import FLOATS
from towage.models.protocol.model import refusal_of
from towage.registry import UNITS
from towage.scene.files import declared
from towage.scene.values import Names
from towage.units.description import Value


def check_physical(names: Names, values: Mapping[str, Mapping[str, Value]]) -> None:
    """Refuses parameters that the model of a shipped unit does not take; ``values`` are those that the scene gives to each
    unit, SI. Raises `SceneError` with the numbers."""
    for unit, entry in names.scene.units.items():
        if entry.fmu in UNITS.own and (reason := _refused(declared(names.scene, unit), values[unit])):
            raise names.fault(reason, f"units.{unit}.parameters")


def _refused(unit: Unit, given: Mapping[str, Value]) -> str:
    """The first requirement of the model that these values do not meet, with the values that it names; empty if none."""
    model = unit.model
    if not model.requirements:
        return ""
    values = {v.name: float(given.get(v.name, v.start or 0.0)) for v in unit.parameters}
    reason = refusal_of(model.requirements(model.Parameters(**values), FLOATS))
    named = dict.fromkeys(re.findall(r"\w+", reason))
    numbers = ", ".join(f"{v.name} = {values[v.name]:g} {v.unit}" for v in unit.parameters if v.name in named)
    return f"{reason} ({numbers})" if numbers else reason
