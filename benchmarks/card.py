"""What the verdict costs: processor time of a judged run over that of the coupled run alone, and what is left beyond the run
with longer steps and the one-way run: ``python benchmarks/card.py [SCENE ...]``.

The limit is 1.5 coupled runs. A twin of the one-way run is among it, which is made where the one-way motion does not repeat.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

from msgspec.structs import replace

import towage
from towage.scene.flavour import FLAVOURS, Flavour
from towage.scene.scene import Scene

VERDICT = Path(__file__).parents[1] / "tests" / "scenes" / "verdict"
SCENES: tuple[str | Path, ...] = ("slack", VERDICT / "taut_rms44.toml", VERDICT / "chaos_eps1e4.toml")
"""One that repeats, and two that get a twin, one of them chaotic."""
REPEATS = 3
LIMIT = 1.5


def bare(scene: Scene) -> Scene:
    """The scene without an error estimate and checks of its own."""
    return replace(scene.without_comparisons(), coupling=replace(scene.coupling, error_estimate=False))


def cost(scene: Scene, flavour: Flavour) -> float:
    """The least processor time of some runs of a scene, s."""
    times = []
    for _ in range(REPEATS):
        begin = time.process_time()
        towage.run(scene, flavour=flavour)
        times.append(time.process_time() - begin)
    return min(times)


def costs(scene: Scene, flavour: Flavour) -> tuple[float, float]:
    """(judged run, what it takes beyond the coupled run, that with longer steps and the one-way run), over the coupled run."""
    section, coupling = scene.checks.get("sdof"), scene.coupling
    step, tolerance = coupling.step, coupling.tolerance or 0.0
    longer = {"coupling.step": 2.0 * step} if step else {"coupling.tolerance": 10.0 * tolerance}
    known = [bare(scene), bare(scene).with_values(longer), *([bare(scene.without(section.cut))] if section else [])]
    judged = cost(scene, flavour)
    coupled, *others = (cost(each, flavour) for each in known)
    return judged / coupled, (judged - coupled - sum(others)) / coupled


def main(chosen: list[str]) -> int:
    """Print the table; 1 if the limit is exceeded."""
    print("| scene | flavour | judged run, over the coupled run | beyond longer steps and one-way run | limit | twin |")
    print("|---|---|---|---|---|---|")
    over = False
    for name in chosen or SCENES:
        scene = Scene.load(name)
        for flavour in FLAVOURS[1:]:
            comparison = towage.run(scene, flavour=flavour).comparison
            twin = "yes" if comparison and not comparison.periods else "no"
            whole, beyond = costs(scene, flavour)
            over |= beyond > LIMIT
            print(f"| {Path(name).stem} | {flavour} | {whole:.2f} | {beyond:.2f} | {LIMIT} | {twin} |", flush=True)
    return int(over)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
