"""An ensemble beside the FMU path, from one run: CPU and wall time of a member over one communication step, and work against
precision. Prints Markdown; ``python benchmarks/ensemble.py [SCENE ...]``.

The FMU path is `towage.Master` on the scene with Python FMUs, without the runs that only judge (error estimate, one-way run),
per communication step and scene. The ensemble is asked for the same outputs at the same times, of MEMBERS members whose heave
amplitudes are spread over half to one and a half of the scene's, in all threads where the master has one; compiling is told
apart. Its error is the largest difference of any output of the SAMPLES drawn members from the FMU path of the composed scene at
any time, relative to the output's largest value; that path runs at ``integration_tolerance`` 1e-11 and limits what can be seen.
Runs of both take turns and the best of RUNS counts, as on a shared machine times mean little: read the ratios.
"""

from __future__ import annotations

import os
import sys
import time

import numpy as np
from msgspec.structs import replace

from towage.ensemble.ensemble import Ensemble
from towage.master.master import Master
from towage.scene.scene import Scene

RUNS, MEMBERS, SAMPLES, SEED = 3, 1024, 2, 0
SCENES = ("sea_cliff", "slack", "docking")
ACCURACIES = (1e-4, 1e-6, 1e-8, 1e-10)
SHARES = (1, 8)
"""Outputs at every communication step, as the master has them, and at fewer, where the ensemble may choose its steps."""
VARIED = "ship.heave_amplitude"


def bare(name: str) -> Scene:
    """The scene's first case without the runs that only judge."""
    scene = Scene.load(name)
    scene = scene.case(scene.cases[0].name) if scene.cases else scene
    coupling = replace(scene.coupling, error_estimate=False)
    return replace(scene, cases=(), coupling=coupling, checks=scene.checks.without("sdof", "simpler"))


def main(chosen: list[str]) -> None:
    """One table a scene."""
    threads = os.cpu_count() or 1
    plan = [(share, accuracy) for share in SHARES for accuracy in ACCURACIES]
    for name in chosen:
        scene = bare(name)
        master = Master(scene, flavour="python")
        middle = float(master.resolved.units["ship"].parameters["heave_amplitude"])  # type: ignore[arg-type]
        begin = time.perf_counter()
        ensemble = Ensemble(scene, {VARIED: middle * np.linspace(0.5, 1.5, MEMBERS)})
        built = time.perf_counter() - begin
        costs = np.full((1 + len(plan), 2), np.inf)
        steps = np.empty(len(plan))
        for _ in range(RUNS):
            result = master.run()
            count = len(result.time) - 1
            once = np.array([result.statistics["cpu_s"], result.statistics["wall_s"]]) / count
            costs[0] = np.minimum(costs[0], once)
            for k, (share, accuracy) in enumerate(plan):
                cpu, wall = time.process_time(), time.perf_counter()
                members = ensemble.run(result.time[::share], accuracy=accuracy, samples=0, threads=threads)
                once = np.array([time.process_time() - cpu, time.perf_counter() - wall]) / (MEMBERS * count)
                costs[k + 1] = np.minimum(costs[k + 1], once)
                steps[k] = members.steps / count
                assert members.done.all()
        print(f"\n### {name}: {scene.stop_time:g} s in {count} steps, {MEMBERS} members, {threads} threads\n")
        print(f"Ready (traced, compiled or found in the cache) in {built:.1f} s.\n")
        print(
            "| what | outputs | accuracy | steps tried | error | CPU | wall | CPU, times faster | wall, times faster |"
        )
        print("|---|---|---|---|---|---|---|---|---|")
        (cpu, wall), *rest = costs.tolist()
        print(f"| FMU path | every step | | | | {1e6 * cpu:.0f} us | {1e6 * wall:.0f} us | 1 | 1 |")
        errors = [
            error
            for share in SHARES
            for error in ensemble.compare(result.time[::share], ACCURACIES, samples=SAMPLES, seed=SEED)
        ]
        for (share, accuracy), n, off, (own_cpu, own_wall) in zip(plan, steps, errors, rest):
            shown = "every step" if share == 1 else f"every {share} steps"
            times = f"{1e9 * own_cpu:.0f} ns | {1e9 * own_wall:.0f} ns | {cpu / own_cpu:.0f} | {wall / own_wall:.0f}"
            print(f"| ensemble | {shown} | {accuracy:.0e} | {n:.2f} | {off:.1e} | {times} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:] or list(SCENES))
