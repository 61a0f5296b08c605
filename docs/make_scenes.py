"""Runs the shipped scenes and writes a page for each into ``docs/scenes/``: ``python docs/make_scenes.py [SCENE ...]``.

The pages are not committed: what they say is what the scenes do now. A page shows the command that a reader would type.
``python docs/make_scenes.py --readme`` draws the picture of the README instead.
"""

import json
import sys
from pathlib import Path

import towage
from towage.checks.verdict import GRAVITY
from towage.report.format import moment, number, percent
from towage.report.plots import Plotter
from towage.report.shapes import shapes, wires
from towage.report.svg import STANDALONE
from towage.result.result import Result
from towage.scene.scene import Scene, available_scenes

PAGES = Path(__file__).with_name("scenes")
README = Path(__file__).with_name("sea_cliff.svg"), "sea_cliff", "ship resonance, 3.92 s"
"""The picture of the README, and the scene and case that it is a result of."""


def measured(name: str, directory: Path) -> list[str]:
    """What ``benchmarks/scenes.py`` measured of the scene: its ladder of models, its errors against step and scheme."""
    try:
        found = json.loads((directory / f"{name}.json").read_text("utf-8"))
    except OSError:
        missing = f"Not measured: `python benchmarks/scenes.py {name}`."
        found = {"ladder": missing, "error": missing}
    return [
        "", "## The simplest model that is enough", "", f"`towage simplest {name}`", "", found["ladder"].strip(),
        "", "## Speed against error", "", found["error"].strip(),
    ]  # fmt: skip


def page(scene: Scene, name: str, results: list[Result], directory: Path) -> tuple[str, dict[str, str]]:
    """(Markdown, SVGs of the gravest case by their file's name); ``directory`` has what was measured."""
    gravest = min(results, key=lambda result: GRAVITY.index(result.verdict.word))
    plot = Plotter(gravest, name, 800)
    picture = plot.motions() or plot.tension() or next(iter(plot.others()[0]), None)
    lines = [
        f"# {scene.title}", "", scene.description, "", "```", f"towage run {name}", "```", "",
        "| case | verdict | decided by | worst margin | coupling error |", "|---|---|---|---|---|",
    ]  # fmt: skip
    for result in results:
        verdict, margin, error = result.verdict, result.worst_margin(), result.worst_coupling_error()
        number_of = "" if verdict.number is None else f" ({number(verdict.number)}, limit {number(verdict.limit)})"
        worst = f"{number(margin.worst)} (`{margin.variable}` at {moment(margin.time)})" if margin else "none"
        estimate = percent(error[1], 2) if error else "not estimated"
        word = "failed" if result.status == "failed" else verdict.word
        lines.append(f"| {result.case or 'the scene'} | **{word}** | {verdict.reason}{number_of} | {worst} | {estimate} |")
    if picture:
        case = f", {gravest.case}" if gravest.case else ""
        lines += ["", f"![{scene.title}{case}]({name}.svg)", "", f"The gravest case{case}."]
    shown = {f"{name}.svg": picture} | {f"{name}_{w}.svg": shapes(gravest, w, f"{name}-{w}") for w in wires(gravest)}
    pictures = {file: svg.replace("<svg ", STANDALONE, 1) for file, svg in shown.items() if svg}
    lines += [
        line for file in pictures if file != f"{name}.svg"
        for line in ("", f"![Shape over time]({file})", "", "The shape, light to dark from start to end.")
    ]  # fmt: skip
    lines += measured(name, directory)
    lines += ["", "## The scene file", "", "```toml", scene.source.strip(), "```"]
    return "\n".join(lines) + "\n", pictures


def write(name: str, directory: Path) -> None:
    """Runs every case of the shipped scene and writes its page."""
    scene = Scene.load(name)
    results = [towage.run(name, case=case.name) for case in scene.cases] or [towage.run(name)]
    text, pictures = page(scene, name, results, directory)
    directory.mkdir(parents=True, exist_ok=True)
    (directory / f"{name}.md").write_text(text, encoding="utf-8")
    for file, svg in pictures.items():
        (directory / file).write_text(svg, encoding="utf-8")


def draw_readme(path: Path) -> None:
    """Runs the case of the README and draws its tension, with the one-way run beside it."""
    _, name, case = README
    picture = Plotter(towage.run(name, case=case), name, 100).tension()
    assert picture
    path.write_text(picture.replace("<svg ", STANDALONE, 1), encoding="utf-8")


if __name__ == "__main__":
    if sys.argv[1:] == ["--readme"]:
        draw_readme(README[0])
        sys.exit()
    for scene_name in sys.argv[1:] or [scene.name for scene in available_scenes()]:
        print(scene_name, file=sys.stderr, flush=True)
        write(scene_name, PAGES)
