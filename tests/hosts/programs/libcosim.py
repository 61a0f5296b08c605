"""A system of OSP or SSP in libcosim, with its fixed-step algorithm."""

from importlib.metadata import version

from job import Job, Series, answer
from libcosimpy.CosimEnums import CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver

TICKS = 1_000_000_000
"""Ticks of libcosim's clock a second."""


def run(job: Job) -> Series:
    """The values and the step come from the file."""
    log_output_level(CosimLogLevel.ERROR)
    make = CosimExecution.from_ssp_file if job["kind"] == "ssp" else CosimExecution.from_osp_config_file
    execution = make(job[job["kind"]])
    observer = CosimObserver.create_time_series()
    assert execution.add_observer(observer)
    watched = [(execution.slave_index_from_instance_name(unit), reference) for unit, _, reference in job["watch"]]
    for index, reference in watched:
        assert observer.start_time_series(index, reference, CosimVariableType.REAL)
    assert execution.step(job["steps"]), "libcosim refused a step"
    series = [observer.time_series_real_samples(index, reference, 1, job["steps"]) for index, reference in watched]
    assert list(series[0][0]) == [(k + 1) * round(job["step"] * TICKS) for k in range(job["steps"])]
    return {
        f"{unit}.{name}": list(values) for (unit, name, _), (_, _, values) in zip(job["watch"], series, strict=True)
    }


answer(run, version("libcosimpy"))
