"""Hosts a user has: fmpy's simulate_fmu and libcosim."""

import csv
import io
import sys
from pathlib import Path
from xml.etree import ElementTree

sys.path.insert(0, str(Path(__file__).parent))
import fmpy
import fmpy.ssp.ssd
import numpy as np
from host import OK, run_checks


def check_simulate_fmu(fmu):
    """Start values and input arrays reach the unit; zero-order hold makes it equal to stepping by hand."""
    step, names = 0.1, [n for n in fmu.observed if fmu.variables[n].causality == "output"]
    times = step * np.arange(31)
    signal = np.array(
        [(t, *(centre + 0.3 * size * np.sin(t) for centre, size in fmu.cases.values())) for t in times],
        dtype=[("time", float), *((n, float) for n in fmu.inputs)],
    )
    assert list(fmu.cases) == fmu.inputs
    result = fmpy.simulate_fmu(
        str(fmu.path), stop_time=3.0, step_size=step, output_interval=step, start_values=fmu.start,
        input=signal if fmu.inputs else None, output=names, fmi_type="CoSimulation",
    )  # fmt: skip
    it, rows = fmu.ready(fmu.start), []
    assert it.set({n: float(signal[n][0]) for n in fmu.inputs}) == OK
    rows.append(it.get(names)[1])
    for k in range(30):
        assert it.set({n: float(signal[n][k]) for n in fmu.inputs}) == OK
        assert it.step(k * step, step) == OK, it.messages
        rows.append(it.get(names)[1])
    it.free()
    assert np.max(np.abs(result["time"] - times)) < 1e-9
    for column, name in enumerate(names):
        expected = np.array([row[column] for row in rows])
        scale = np.max(np.abs(expected)) or 1.0
        # fmpy accumulates time and interpolates the input array: some 1e-15 relative, amplified by the motion
        assert np.max(np.abs(result[name] - expected)) < repeats_to(fmu) * scale, name
    assert any(np.ptp(result[name]) > 0.0 for name in names)


def repeats_to(fmu):
    """To what share a unit repeats a step whose length differs by rounding: one that iterates and halves its steps may take
    another number of them, so that its own tolerance, m/s of motions of some m/s, is what it promises."""
    return fmu.start.get("velocity_tolerance", 1e-9)


def check_reference_result_reproduces(fmu):
    """What the manifest of FMI-LS-REF names is enough for a program to make the reference result again."""
    page = (fmu.directory / "documentation" / "index.html").read_text()
    assert all(f"<code>{n}</code>" in page for n, v in fmu.variables.items() if v.variability != "tunable")
    start, given, options, expected = related_files(fmu.directory)
    assert float(options["StopTime"]) == 10.0 and len(expected) == len(given) == 101
    assert set(expected[0]) == {"time"} | {n for n, v in fmu.variables.items() if v.causality == "output"}
    # the flavours choose how many states to leave out by errors that one measures and the other estimates: their outputs
    # agree as the parameter ``tolerance`` promises, the margin that shows the error does not
    estimates = fmu.native and {"tolerance", "reduced"} <= set(fmu.variables)
    unlike = {"time"} | ({"margin_resolution"} if estimates else set())
    it = fmu.ready(start)
    share = it.value("tolerance") if estimates else 0.0
    for k, row in enumerate(expected):
        assert it.set({name: value for name, value in given[k].items() if name != "time"}) == OK
        for name, value in row.items():
            if name not in unlike:
                # the same numbers again; the flavours may differ in the last bits
                allowed = share * max(abs(each[name]) for each in expected) or 1e-9 * (1.0 + abs(value))
                assert abs(it.value(name) - value) <= allowed, (k, name)
        assert it.step(row["time"], float(options["StepSize"])) == OK
    assert any(abs(expected[0][n] - expected[50][n]) > 1e-3 for n in expected[0] if n != "time")
    it.free()


def related_files(directory):
    """(start values, what is set before each step, options, outputs) of the manifest's files, each by its role."""
    place = directory / "extra" / "org.fmi-standard.fmi-ls-ref" / "fmi-ls-manifest.xml"
    files = {node.get("role"): place.parent / node.get("source") for node in ElementTree.parse(place).getroot()}
    tables = [
        [{k: float(v) for k, v in row.items()} for row in csv.DictReader(io.StringIO(files[role].read_text()))]
        for role in ("testcase", "result")
    ]
    options = dict(line.split(", ") for line in files["experiment/smoke-test"].read_text().splitlines())
    start = {p.name: float(p.value) for p in fmpy.ssp.ssd.read_ssv(str(files["parameter"])).parameters}
    return start, tables[0], options, tables[1]


def check_libcosim_loads_and_steps(fmu):
    from libcosimpy.CosimEnums import CosimExecutionState
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.WARNING)
    execution = CosimExecution.from_step_size(step_size=int(1e8))
    index = execution.add_local_slave(CosimLocalSlave(fmu_path=str(fmu.path), instance_name="it"))
    for name, value in fmu.start.items():
        assert execution.real_initial_value(index, fmu.reference[name], value)
    manipulator, observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
    execution.add_manipulator(manipulator)
    execution.add_observer(observer)
    values = {name: centre + 0.5 * size for name, (centre, size) in fmu.cases.items()}
    if values:
        manipulator.slave_real_values(index, [fmu.reference[name] for name in values], list(values.values()))
    assert execution.step(step_count=10)
    assert execution.status().state != CosimExecutionState.ERROR
    outputs = [n for n in fmu.observed if fmu.variables[n].causality == "output"]
    seen = observer.last_real_values(index, [fmu.reference[n] for n in outputs])
    it = fmu.ready(fmu.start)
    assert it.set(values) == OK
    for k in range(10):
        assert it.step(0.1 * k, 0.1) == OK
    expected = it.get(outputs)[1]
    for name, a, b in zip(outputs, seen, expected):
        # times in whole nanoseconds there, k*h here
        assert abs(a - b) <= repeats_to(fmu) * (1.0 + abs(b)), (name, a, b)
    it.free()


run_checks(globals())
