"""Many instances, whose code they run, and what they leave behind in the host."""

import gc
import random
import sys
import zipfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from host import FATAL, OK, only, random_inputs, run_checks


def run(it, seed, steps=20):
    rng, seen = random.Random(seed), []
    for k in range(steps):
        assert it.set(random_inputs(it.fmu, rng)) == OK
        assert it.step(k * 0.2, 0.2) == OK, it.messages
        seen.append(it.observe())
    return seen


@only(flavour="python")
def check_runs_the_code_it_carries(fmu):
    """Every module of the unit lies in the unpacked FMU and is as packed; the work tree is not even importable."""
    path = list(sys.path)
    it = fmu.ready(fmu.start)
    assert run(it, 1)
    script = (fmu.directory / "resources" / "slavemodule.txt").read_text().strip()
    package = script.removesuffix("_fmu")
    files = {m.__file__ for n, m in sys.modules.items() if n.split(".")[0] in (package, script) and m.__file__}
    resources = fmu.directory / "resources"
    with zipfile.ZipFile(fmu.path) as archive:
        packed = {n for n in archive.namelist() if n.startswith("resources/") and n.endswith(".py")}
        imported = {str(Path(f).relative_to(fmu.directory)) for f in files}
        assert packed == imported, sorted(packed ^ imported)
        for name in packed:
            assert (fmu.directory / name).read_bytes() == archive.read(name)
    assert str(resources / package / "fmus" / f"{fmu.name}.py") in files
    assert not {"towage", "models", "fmus"} & set(sys.modules)
    assert sys.path == path, "the path of the host was changed"
    it.free()


@only(flavour="python")
def check_a_freed_instance_is_gone(fmu):
    """No reference is left behind, with and without a failure."""
    for failing in (False, True):
        it = fmu.ready(fmu.start)
        if failing:
            for _ in range(5):
                assert it.get_references([9999])[0] == FATAL
        alive = [type(o).__name__ for o in gc.get_objects() if type(o).__name__ == fmu.name]
        it.free()
        gc.collect()
        left = [type(o).__name__ for o in gc.get_objects() if type(o).__name__ == fmu.name]
        assert len(left) == len(alive) - 1, (alive, left)


def check_instances_do_not_touch_each_other(fmu):
    """Four at once, one step each in turn, equal four alone."""
    alone = [run(fmu.ready(fmu.start), seed) for seed in range(4)]
    together = [fmu.ready(fmu.start, f"number {seed}") for seed in range(4)]
    rngs, seen = [random.Random(seed) for seed in range(4)], [[] for _ in range(4)]
    for k in range(20):
        for it, rng, results in zip(together, rngs, seen):
            assert it.set(random_inputs(fmu, rng)) == OK
            assert it.step(k * 0.2, 0.2) == OK
            results.append(it.observe())
    assert seen == alone
    for it in together:
        it.free()


def check_reset_is_a_new_instance(fmu):
    it = fmu.ready(fmu.start)
    expected = run(it, 3)
    for _ in range(5):
        assert it.call("Reset") == OK
        parameter = next(n for n, v in fmu.start.items() if v != float(fmu.variables[n].start))
        assert it.value(parameter) == float(fmu.variables[parameter].start)
        assert it.initialize(fmu.start) == OK
        assert run(it, 3) == expected
    it.free()


run_checks(globals())
