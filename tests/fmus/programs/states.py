"""Full state: rollback and serialisation to the last bit, at random points."""

import math
import random
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from host import OK, Fmu, only, random_inputs, run_checks


def walk(it, fmu, rng, time, steps):
    """Random steps with random cubics; (time, everything that was seen)."""
    seen = []
    for _ in range(steps):
        assert it.set(random_inputs(fmu, rng)) == OK
        if rng.random() < 0.5:
            seen.append(it.observe())  # limits from the right
        size = rng.choice([0.003, 0.05, 0.3])
        assert it.step(time, size) == OK, it.messages
        time += size
        seen.append(it.observe())
    return time, seen


def starts(fmu):
    """Start values, with both settings of the branches."""
    start = fmu.start
    return [start | {"freeze_branches": f} for f in (0.0, 1.0)] if "freeze_branches" in fmu.variables else [start]


def changed(fmu):
    """Another value of the first parameter that the build left open, within its bounds."""
    for name, value in fmu.start.items():
        v = fmu.variables[name]
        high = math.inf if v.max is None else float(v.max)
        if v.causality == "parameter" and (v.min is None or v.min != v.max):
            return {name: 1.1 * value if 1.1 * value <= high else 0.9 * value}
    return {}


def points(fmu, start, seed):
    """An instance at ten random points of a run: (instance, time, generator)."""
    rng = random.Random(seed)
    it, time = fmu.ready(start), 0.0
    for _ in range(10):
        time, _ = walk(it, fmu, rng, time, rng.randint(1, 6))
        if rng.random() < 0.5:
            assert it.set(random_inputs(fmu, rng)) == OK  # touched, outputs not yet read
        yield it, time, rng
    it.free()


def check_rollback_is_bit_equal(fmu):
    branches = set()
    for start in starts(fmu):
        for it, time, rng in points(fmu, start, 1):
            state, here = it.get_state(), it.observe()
            if "taut" in fmu.variables:
                branches.add(("taut", it.value("taut")))
            if "docked" in fmu.variables:
                branches.add(("docked", it.value("docked")))
            for _ in range(2):
                seed = rng.random()
                _, first = walk(it, fmu, random.Random(seed), time, 4)
                assert it.set_state(state) == OK
                assert it.observe() == here
                assert it.set_state(state) == OK
                _, second = walk(it, fmu, random.Random(seed), time, 4)
                assert first == second
                assert it.set_state(state) == OK
            it.free_state(state)
    wanted = [n for n in ("taut", "docked") if n in fmu.variables]
    assert branches >= {(n, b) for n in wanted for b in (0.0, 1.0)}, "not all branches were met"


@only("cradle", "cradle_on_line")
def check_rollback_across_docking(fmu):
    """From just after the docking to just before it and back, and to the point itself."""
    it = fmu.ready(fmu.start)
    assert it.step(0.0, 3.0 - 1e-9) == OK
    before, seen_before = it.get_state(), it.observe()
    assert it.step(3.0 - 1e-9, 1e-9) == OK
    at, seen_left = it.get_state(), it.observe()
    assert it.value("docked") == 0.0 and it.value("next_event_time") == 3.0
    assert it.set({"submersible_velocity": -0.4}) == OK
    assert it.value("docked") == 1.0
    after, seen_right = it.get_state(), it.observe()
    assert it.step(3.0, 0.1) == OK
    beyond = it.observe()
    for state, seen in ((before, seen_before), (at, seen_left), (after, seen_right)):
        assert it.set_state(state) == OK
        assert it.observe() == seen
    assert it.step(3.0, 0.1) == OK
    assert it.observe() == beyond
    it.free()


def check_serialised_states_are_bit_equal_in_any_instance(fmu):
    for start in starts(fmu):
        other = fmu.ready(start | changed(fmu), "other")
        for it, time, rng in points(fmu, start, 2):
            text = it.serialize(it.get_state())
            assert it.serialize(it.get_state()) == text
            here, seed = it.observe(), rng.random()
            _, expected = walk(it, fmu, random.Random(seed), time, 3)
            new = fmu.instantiate("new")  # not even initialised
            for target in (it, other, new):
                state = target.deserialize(text)
                assert target.set_state(state) == OK, target.messages
                assert target.observe() == here
                assert target.set_state(state) == OK
                _, seen = walk(target, fmu, random.Random(seed), time, 3)
                assert seen == expected
                assert target.set_state(state) == OK
                target.free_state(state)
            new.free()


def check_states_of_all_phases(fmu):
    """A state taken before and during initialisation brings the instance back there."""
    it = fmu.instantiate()
    new = it.get_state()
    assert it.set(fmu.start) == OK
    given = it.get_state()
    assert it.initialize({}) == OK
    first = it.observe()
    assert it.set_state(given) == OK
    assert it.initialize({}) == OK
    assert it.observe() == first
    assert it.set_state(new) == OK
    values = it.get(list(fmu.start))[1]
    assert values == [float(fmu.variables[n].start) for n in fmu.start] != list(fmu.start.values())
    it.free()


def check_foreign_bytes_are_refused(fmu):
    other = Fmu(fmu.path.with_name("ship.fmu" if fmu.name != "ship" else "cradle.fmu"), fmu.directory.parent)
    it = other.ready(other.start)
    foreign = it.serialize(it.get_state())
    it.free()
    own = fmu.ready(fmu.start)
    good = own.serialize(own.get_state())
    flips = [(place, 1 << place % 8) for place in range(0, len(good), max(1, len(good) // 12))]
    changed = [good[:place] + bytes([good[place] ^ bit]) + good[place + 1 :] for place, bit in flips]
    for text in (foreign, b"", b"\xff\x00", b"[]", b"null", good[:-1], good + good, good[1:], *changed):
        it = fmu.ready(fmu.start)
        assert it.set_state_of(text) == fmu.refusal, text
        assert f"not a state of {fmu.name}" in it.messages[-1][2], it.messages
        it.free()
    assert own.step(0.0, 0.1) == OK
    own.free()


run_checks(globals())
