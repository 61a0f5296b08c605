"""Long lives and many of them, without growth."""

import gc
import random
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from host import OK, random_inputs, resident, run_checks, wrong


def run(it):
    """Everything that is seen in twenty steps."""
    rng, seen = random.Random(2), []
    for k in range(20):
        assert it.set(random_inputs(it.fmu, rng)) == OK
        assert it.step(k * 0.2, 0.2) == OK, it.messages
        seen.append(it.observe())
    return seen


def check_fifty_lives(fmu):
    """Instantiate, run, free, fifty times, then as often with a failure: the same result, no growth."""
    first = run(fmu.ready(fmu.start))
    path = list(sys.path)
    for failing in (False, True):
        sizes = []
        for k in range(50):
            it = fmu.ready(fmu.start, f"life {k}")
            if failing:
                assert it.set(wrong(fmu)) == fmu.refusal
            elif k % 10 == 0:
                assert run(it) == first
            it.free()
            gc.collect()
            sizes.append(resident())
        # 30 lives later: a leaked instance is some 10 kB, a leaked script 1 kB; the allocator moves in steps of 256 kB
        assert sizes[-1] - sizes[19] <= 30 * 10_000, sizes
    assert sys.path == path


def check_ten_thousand_steps_and_states(fmu):
    """Memory stays where it is."""
    it = fmu.ready(fmu.start)
    values = random_inputs(fmu, random.Random(4))
    sizes = []
    for k in range(10_000):
        assert it.set(values) == OK
        state = it.get_state()
        assert it.step(k * 0.01, 0.01) == OK, it.messages
        assert it.set_state(state) == OK
        assert it.step(k * 0.01, 0.01) == OK, it.messages
        it.free_state(state)
        assert it.get()[0] == OK
        if k % 1000 == 999:
            sizes.append(resident())
    # 8000 steps, a leaked float each would be 200 kB
    assert sizes[-1] - sizes[1] <= 150_000, sizes
    it.free()


run_checks(globals())
