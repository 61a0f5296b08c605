"""Hosts a user has: fmpy's simulate_fmu and libcosim."""

import csv
import io
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import fmpy
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
        assert np.max(np.abs(result[name] - expected)) < 1e-9 * scale, name
    assert any(np.ptp(result[name]) > 0.0 for name in names)


def check_reference_result_reproduces(fmu):
    """The page and the table inside the FMU; the table is what the FMU computes."""
    page = (fmu.directory / "documentation" / "index.html").read_text()
    assert all(f"<code>{n}</code>" in page for n, v in fmu.variables.items() if v.variability != "tunable")
    table = (fmu.directory / "documentation" / f"{fmu.name}_ref.csv").read_text()
    rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(io.StringIO(table))]
    assert len(rows) == 101 and set(rows[0]) >= {n for n, v in fmu.variables.items() if v.causality == "output"}
    start, _, signals = page.partition("a reference result: ")[2].partition("; ")
    # the flavours choose how many states to leave out by errors that one measures and the other estimates: their outputs
    # agree as the parameter ``tolerance`` promises, the margin that shows the error does not
    estimates = fmu.native and {"tolerance", "reduced"} <= set(fmu.variables)
    unlike = {"time"} | ({"margin_resolution"} if estimates else set())
    it = fmu.ready({k: float(v) for k, v in (item.split(" = ") for item in start.split(", ") if item)})
    share = it.value("tolerance") if estimates else 0.0
    signals = signals.partition(", set with its")[0]
    sines = {}
    for item in filter(None, signals.split(", ")):
        name, _, law = item.partition("(t) = ")
        amplitude, _, omega = law.partition(" sin(")
        sines[name] = float(amplitude), float(omega.removesuffix(" t)"))
    for k, row in enumerate(rows):
        t = row["time"]
        for name, (a, w) in sines.items():
            s, c = a * np.sin(w * t), a * np.cos(w * t)
            derivatives = {"": s, "_d1": w * c, "_d2": -w * w * s, "_d3": -w * w * w * c}
            assert it.set({name + suffix: float(v) for suffix, v in derivatives.items()}) == OK
        for name, value in row.items():
            if name not in unlike:
                # the same numbers again; numpy's sine may differ in the last bit from the one that made the table
                allowed = share * max(abs(each[name]) for each in rows) or 1e-9 * (1.0 + abs(value))
                assert abs(it.value(name) - value) <= allowed, (k, name)
        assert it.step(t, 0.1) == OK
    assert any(abs(rows[0][n] - rows[50][n]) > 1e-3 for n in rows[0] if n != "time")
    it.free()


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
        assert abs(a - b) <= 1e-9 * (1.0 + abs(b)), (name, a, b)
    it.free()


run_checks(globals())
