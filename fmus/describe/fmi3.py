"""``modelDescription.xml`` (FMI 3.0) of a unit's native flavour: model exchange and co-simulation.

The variables are those of the FMI 2 description with the same value references, but the elements of an array have one
variable, with the reference of the first. Two follow that only FMI 3 has: the independent variable ``time`` and the event
indicators. ``native/runtime/fmi3.c`` reads references the same way.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from xml.etree.ElementTree import Element, SubElement

from ..declare.arrays import array_name, array_of, lengths
from ..declare.interface import Interface
from ..declare.unit import Variable
from .fmi2 import GENERATION_TOOL, annotate, document, number, preamble, root_element

BOTH = {
    "needsExecutionTool": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canGetAndSetFMUState": "true",
    "canSerializeFMUState": "true",
    "providesDirectionalDerivatives": "true",
    "providesAdjointDerivatives": "true",
    "providesPerElementDependencies": "false",
}
MODEL_EXCHANGE = BOTH | {"needsCompletedIntegratorStep": "false", "providesEvaluateDiscreteStates": "false"}
CO_SIMULATION = BOTH | {
    "canHandleVariableCommunicationStepSize": "true",
    "maxOutputDerivativeOrder": "1",
    "providesIntermediateUpdate": "false",
    "canReturnEarlyAfterIntermediateUpdate": "false",
}
"""What the units can do; those with events have event mode, too, and return early at an event."""
TIME = Variable(name="time", unit="s", description="Simulation time", causality="independent", variability="continuous")


def model_description3(interface: Interface, identifier: str, token: str) -> bytes:
    """The XML document."""
    unit, variables = interface.unit, interface.variables
    root = root_element(unit, "3.0", instantiationToken=token)
    if interface.exchange:
        SubElement(root, "ModelExchange", {"modelIdentifier": identifier, **MODEL_EXCHANGE})
    events = str(interface.has_events).lower()
    SubElement(
        root, "CoSimulation",
        {"modelIdentifier": identifier, **CO_SIMULATION, "mightReturnEarlyFromDoStep": events, "hasEventMode": events},
    )  # fmt: skip
    preamble(root, (*variables, TIME))
    node, counts, layout = SubElement(root, "ModelVariables"), lengths(variables), interface.layout
    for reference, count in enumerate(counts):
        if count:
            element = _variable(node, reference, variables[reference : reference + count])
            if reference in layout.states:
                state = layout.states.index(reference)
                if any(interface.reinit[state : state + count]):
                    element.set("reinit", "true")
            if reference in layout.state_derivatives:
                element.set("derivative", str(layout.states[layout.state_derivatives.index(reference)]))
    time = len(variables)
    SubElement(
        node, "Float64", name=TIME.name, valueReference=str(time), description=TIME.description, causality=TIME.causality,
        variability=TIME.variability, unit=TIME.unit,
    )  # fmt: skip
    if interface.indicators:
        indicators = SubElement(
            node, "Float64", name="event_indicator", valueReference=str(time + 1), causality="local",
            variability="continuous", initial="calculated", description="Changes sign where a branch of the model changes",
        )  # fmt: skip
        _dimension(indicators, interface.indicators)
    _structure(SubElement(root, "ModelStructure"), interface, counts)
    annotate(SubElement(SubElement(root, "Annotations"), "Annotation", type=GENERATION_TOOL), unit)
    return document(root)


def _variable(parent: Element, reference: int, elements: Sequence[Variable]) -> Element:
    """A scalar, or an array of which only what all ``elements`` share is said."""
    v = elements[0]
    attributes = {"name": v.name if len(elements) == 1 else array_name(v.name), "valueReference": str(reference)}
    for key in ("description", "causality", "variability", "unit", "display", "min", "max", "nominal", "start"):
        value = getattr(v, key)
        if value is not None and all(getattr(each, key) == value for each in elements):
            attributes["displayUnit" if key == "display" else key] = value if isinstance(value, str) else number(value)
    if "description" not in attributes:
        attributes["description"] = f"{v.description}, and so on"
    if v.causality != "input":
        attributes["initial"] = "exact" if v.causality == "parameter" else "calculated"
    element = SubElement(parent, "Float64", attributes)
    _dimension(element, len(elements))
    return element


def _dimension(element: Element, count: int) -> None:
    if count > 1:
        SubElement(element, "Dimension", start=str(count))


def _structure(node: Element, interface: Interface, counts: Sequence[int]) -> None:
    layout = interface.layout
    outputs = [i for i in layout.observed if counts[i] and interface.variables[i].causality == "output"]
    calculated, states, derivatives = (
        [i for i in part if counts[i]] for part in (layout.calculated, layout.states, layout.state_derivatives)
    )
    time = len(interface.variables)

    def known(elements: Iterable[int]) -> str:
        """On what any of the elements depends; on time, as far as is known, each may."""
        references = {array_of(counts, k) for i in elements for k in interface.depends(i)}
        return " ".join(map(str, [*sorted(references), time]))

    for title, references in (("Output", outputs), ("ContinuousStateDerivative", derivatives)):
        for i in references:
            SubElement(node, title, valueReference=str(i), dependencies=known(range(i, i + counts[i])))
    # no dependencies: on all that is known, parameters too
    for i in sorted([*outputs, *calculated, *states, *derivatives]):
        SubElement(node, "InitialUnknown", valueReference=str(i))
    if interface.indicators:
        SubElement(node, "EventIndicator", valueReference=str(time + 1))
