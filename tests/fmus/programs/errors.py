"""Calls and values that make no sense: the defined status, a message that names the place, and the host lives on."""

import math
import random
import sys
from ctypes import c_char_p, c_double, c_int, c_uint
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from host import DISCARD, FATAL, OK, only, random_inputs, run_checks, wrong

NAN, INFINITY = float("nan"), float("inf")


def refused(it, status, expected, *words):
    said = it.messages[-1][2] if it.messages else ""
    assert status == expected, (status, said)
    assert it.slave.instanceName in said and it.fmu.name in said, said
    assert all(word in said for word in words), said


def check_bad_steps_are_discarded_and_change_nothing(fmu):
    it = fmu.ready(fmu.start, stop_time=1.0)
    assert it.step(0.0, 0.25) == OK
    here = it.observe()
    for _ in range(3):
        for time, size, word in (
            (0.25, 0.0, "step size 0.0"), (0.25, -0.1, "step size -0.1"), (0.25, NAN, "step size nan"),
            (0.25, INFINITY, "step size inf"), (0.5, 0.1, "expected t = 0.25"), (0.0, 0.1, "expected t = 0.25"),
            (NAN, 0.1, "t = nan"), (-INFINITY, 0.1, "t = -inf"), (0.25, 0.8, "stop time 1.0"),
        ):  # fmt: skip
            refused(it, it.step(time, size), DISCARD, word)
            assert it.messages[-1][1] == "logStatusError"
            assert it.observe() == here
    last = c_double()
    assert it.call("GetRealStatus", 2, last) == OK and last.value in (0.25, 0.0)
    assert it.step(0.25, 0.75) == OK
    it.free()


def check_calls_out_of_order(fmu):
    start = fmu.start
    it = fmu.instantiate()
    refused(it, it.step(0.0, 0.1), DISCARD, "phase instantiated", "expected phase stepping")
    assert it.initialize(start) == OK
    for function in ("EnterInitializationMode", "ExitInitializationMode"):
        it = fmu.ready(start)
        refused(it, it.call(function), fmu.refusal, "phase stepping")
        it.free()
    it = fmu.ready(start)
    refused(it, it.call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0), fmu.refusal, "phase stepping")
    it.free()
    it = fmu.ready(start)
    assert it.call("Terminate") == OK
    assert it.get()[0] == OK
    refused(it, it.step(0.0, 0.1), DISCARD, "phase terminated")
    refused(it, it.set(random_inputs(fmu, random.Random(1)) or wrong(fmu)), fmu.refusal, "phase terminated")
    it.free()
    it = fmu.instantiate()
    refused(it, it.call("Terminate"), fmu.refusal, "phase instantiated")
    it.free()
    for begin, end in ((NAN, None), (INFINITY, None), (2.0, 1.0), (0.0, NAN)):
        it = fmu.instantiate()
        refused(it, it.initialize(start, begin, end), fmu.refusal, "start time")
        it.free()


def check_bad_values(fmu):
    fixed = next(n for n, v in fmu.variables.items() if (v.causality, v.variability) == ("parameter", "fixed"))
    results = [fmu.observed[0]]
    results += [n for n, v in fmu.variables.items() if v.causality == "calculatedParameter"][:1]
    while_stepping = [({fixed: 1.0}, f"{fixed} may not be set in phase stepping")]
    while_stepping += [({name: 1.0}, f"{name} may not be set") for name in results]
    for entry in fmu.inputs:
        while_stepping += [
            ({entry: NAN}, f"{entry} = nan"), ({entry: -INFINITY}, f"{entry} = -inf"), ({f"{entry}_d2": NAN}, f"{entry}_d2"),
        ]  # fmt: skip
    for values, word in while_stepping:
        it = fmu.ready(fmu.start)
        refused(it, it.set(values), fmu.refusal, word)
        it.free()
    for values in ({fixed: NAN}, *({name: 1.0} for name in results)):
        it = fmu.instantiate()
        refused(it, it.set(values), fmu.refusal, next(iter(values)))
        it.free()


def check_wrong_references(fmu):
    n = len(fmu.variables)
    # the last three look like small negative numbers to the bridge
    for reference in (n, 10**6, 2**31, 2**32 - 1, 2**32 - 20, 2**32 - n):
        it = fmu.ready(fmu.start)
        refused(it, it.get_references([0, reference])[0], fmu.refusal, f"reference {reference}")
        it.free()
        it = fmu.ready(fmu.start)
        refused(it, it.set_references([reference], [1.0]), fmu.refusal, f"reference {reference}")
        it.free()
    one = (c_uint * 1)(0)
    for function, values in (("GetInteger", (c_int * 1)()), ("GetBoolean", (c_int * 1)()),
                             ("GetString", (c_char_p * 1)()), ("SetString", (c_char_p * 1)(b"x"))):  # fmt: skip
        it = fmu.ready(fmu.start)
        assert it.call(function, one, 0, values) == OK
        refused(it, it.call(function, one, 1, values), fmu.refusal, "type Real")
        refused(it, it.call(function, one, 1, values), fmu.refusal, "type Real")
        it.free()


def check_parameters_out_of_range(fmu):
    """Every bound, one by one, is kept and named."""
    tried = 0
    for v in (v for v in fmu.variables.values() if v.causality == "parameter"):
        for bound, sign in ((v.min, -1.0), (v.max, 1.0)):
            if bound is None:
                continue
            bound = float(bound)
            it = fmu.instantiate()
            status = it.initialize(fmu.start | {v.name: bound + sign * (1e-12 + 0.01 * abs(bound))})
            refused(it, status, fmu.refusal, f"{v.name} = ", "expected ")
            it.free()
            tried += 1
    assert tried > 1


def check_inputs_out_of_range(fmu):
    """An input beyond a declared bound makes a step impossible, and the instance goes on with one within."""
    for v in (fmu.variables[n] for n in fmu.inputs):
        for bound, sign in ((v.min, -1.0), (v.max, 1.0)):
            if bound is not None:
                it, good = fmu.ready(fmu.start), random_inputs(fmu, random.Random(3))
                assert it.set(good) == OK
                here = it.observe()
                assert it.set({v.name: float(bound) + sign * (1.0 + abs(float(bound)))}) == OK
                refused(it, it.step(0.0, 0.1), DISCARD, "t = 0.0")
                assert it.set(good) == OK
                assert it.observe() == here
                assert it.step(0.0, 0.1) == OK
                it.free()


@only("cradle", "cradle_on_line")
def check_docking_without_submersible(fmu):
    it = fmu.instantiate()
    status = it.initialize(fmu.start | {"submersible_mass": 0.0})
    refused(it, status, fmu.refusal, "docking_time", "submersible_mass")
    it.free()


@only("spring_line", "cradle_on_line")
def check_line_without_stiffness(fmu):
    it = fmu.instantiate()
    refused(it, it.initialize(fmu.start | {"stiffness": 0.0, "length": 0.0}), fmu.refusal, "stiffness", "axial_stiffness")
    it.free()
    it = fmu.instantiate()
    assert it.initialize(fmu.start | {"stiffness": 0.0, "axial_stiffness": 3e5, "length": 30.0}) == OK
    assert it.value("port_stiffness") == 1e4
    it.free()


@only("cradle", "cradle_on_line", "spring_line")
def check_parameters_may_be_read_before_they_fit_together(fmu):
    it = fmu.instantiate()
    name, value = ("docking_time", 2.0) if "docking_time" in fmu.variables else ("stiffness", 0.0)
    assert it.set({name: value}) == OK
    assert it.call("EnterInitializationMode") == OK
    assert it.value(name) == value
    assert it.set(fmu.start) == OK
    assert it.get()[0] == OK
    assert it.call("ExitInitializationMode") == OK
    it.free()


def check_ten_errors_and_a_reset(fmu):
    """After the first Fatal every call is Fatal, after an Error the next call may be good; none crashes, and a reset makes
    the instance as new."""
    fresh = fmu.ready(fmu.start)
    expected = fresh.observe()
    it = fmu.ready(fmu.start, "wreck")
    for round in range(3):
        for _ in range(10):
            assert it.set(wrong(fmu)) == fmu.refusal
            if fmu.native:
                assert it.observe() == expected
            else:
                assert it.get()[0] == FATAL
                assert it.step(0.0, 0.1) == FATAL
                assert it.call("Terminate") == FATAL
            assert it.call("EnterInitializationMode") == fmu.refusal
            assert "wreck" in it.messages[-1][2]
        assert fresh.step(0.1 * round, 0.1) == OK  # the good one beside it goes on
        assert it.call("Reset") == OK
        assert it.initialize(fmu.start) == OK
        assert it.observe() == expected
    it.free()
    fresh.free()


def check_names_that_look_like_formats(fmu):
    """Hosts print messages through printf."""
    it = fmu.ready(fmu.start, "100%s%n%d")
    refused(it, it.step(5.0, 0.1), DISCARD, "100%s%n%d (")
    refused(it, it.set(wrong(fmu)), fmu.refusal, "100%s%n%d (")
    it.free()


def check_silent_without_logging(fmu):
    """The bridge passes messages on only to a host that asked for them; statuses stay."""
    it = fmu.instantiate(logging=False)
    assert it.step(0.0, 0.1) == DISCARD
    assert it.call("Terminate") == fmu.refusal
    assert it.messages == []
    it.free()


@only(flavour="python")
def check_what_the_bridge_keeps_to_itself(fmu):
    """Nothing of this reaches a unit (docstring of python_slave): if it changes, refuse it there."""
    it = fmu.instantiate(guid="{00000000-0000-0000-0000-000000000000}")
    assert it.component is not None
    assert it.initialize(fmu.start) == OK
    assert it.call("Reset") == OK  # at any time
    it.free()


@only(flavour="native")
def check_wrong_guid_is_refused(fmu):
    it = fmu.instantiate(guid="{00000000-0000-0000-0000-000000000000}")
    assert it.component is None
    assert "expected " + fmu.description.guid in it.messages[-1][2]


def check_numbers_that_go_bad_are_discarded(fmu):
    """Whatever input grows beyond all numbers, the unit says when and what, and is as it was."""
    for entry in fmu.inputs:
        if entry.startswith("lower_velocity") and not fmu.start.get("body_port"):
            continue  # of a wire with its body on board: it moves nothing
        it, twin = fmu.ready(fmu.start), fmu.ready(fmu.start)
        good = {n: v if n in fmu.inputs else 0.0 for n, v in random_inputs(fmu, random.Random(1)).items()}
        for each in (it, twin):
            assert each.set(good) == OK
            assert each.step(0.0, 0.5) == OK
            assert each.set(good) == OK
        here = it.observe()
        assert it.set({f"{entry}_d3": 1e308}) == OK
        refused(it, it.step(0.5, 100.0), DISCARD, "t = 0.5")
        assert it.messages[-1][1] == "logStatusDiscard"
        assert it.set(good) == OK
        assert it.observe() == here
        assert it.step(0.5, 0.5) == twin.step(0.5, 0.5) == OK
        assert it.observe() == twin.observe()
        it.free()
        twin.free()


@only("ship", "cradle", "cradle_on_line")
def check_the_variable_that_went_bad_is_named(fmu):
    it = fmu.ready(fmu.start | ({"drag_area": 1e3} if "drag_area" in fmu.variables else {"damping": 1e7}))
    assert it.set({f"{fmu.inputs[0]}_d3": 1e308}) == OK
    refused(it, it.step(0.0, 100.0), DISCARD, "t = 0.0", "heave" if fmu.name != "ship" else "velocity_rate")
    it.free()


def check_outputs_are_finite_or_refused(fmu):
    """Values on a port are never infinite: where an input leads to one, reading it is refused by name."""
    for entry in fmu.inputs:
        it = fmu.ready(fmu.start)
        assert it.set({entry: 1e308, f"{entry}_d1": 1e308}) == OK
        status, values = it.get()
        if status == OK:
            assert all(map(math.isfinite, values))
        else:
            refused(it, status, fmu.refusal, "t = 0.0")
        it.free()


MEANWHILE = {"ship": {"mass": 1e-9}, "spring_line": {"wave_speed": 0.0}}
"""What lets an extreme value be: a wire so stiff would be too heavy."""


@only("ship", "spring_line", "cradle", "cradle_on_line")
def check_what_became_infinite_is_named(fmu):
    extreme = {"stiffness": 1e300} if "stiffness" in fmu.variables else {"mass": 1e-9, "weight_in_water": 0.0}
    it = fmu.ready(fmu.start | extreme | MEANWHILE.get(fmu.name, {}))
    assert it.set({fmu.inputs[0]: 1e308}) == OK
    status, _ = it.get()
    refused(it, status, fmu.refusal, "t = 0.0", "became")
    it.free()


run_checks(globals())
