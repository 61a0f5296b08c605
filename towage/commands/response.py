"""``towage response``: frequency response and steady shape of the tows of a scene."""

from __future__ import annotations

import argparse
import cmath
import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from towage.commands import common

if TYPE_CHECKING:
    from towage.checks.towing import Gain, SceneTow

HELP = "frequency response and steady shape of a scene's tow"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage response``."""
    parser.add_argument("scene", metavar="SCENE", help="a scene file with a tow, or the name of a shipped scene")
    parser.add_argument("--case", metavar="NAME", help="with the values of this case")
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", type=common.setting, default=[],
                        help="a value in place of the scene's: unit.parameter (may be repeated)")  # fmt: skip
    common.add_fmus(parser)
    parser.add_argument("--from", metavar="HZ", dest="first", type=_hertz, default=0.02, help="lowest frequency (0.02)")
    parser.add_argument("--to", metavar="HZ", dest="last", type=_hertz, default=1.0, help="highest frequency (1)")
    parser.add_argument("--points", metavar="N", type=_points, default=40, help="number of frequencies (default: 40)")
    parser.add_argument("--out", metavar="DIR", type=Path, help="where the files go (default: out/<scene>)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.epilog = (
        "Amplitudes are for 1 m of heave of the towpoint (Quadrant I) or 1 N of lift on the body (Quadrant II), phases as\n"
        "q = |q| cos(omega t - phase). Writes <unit>_response.svg, <unit>_cable.svg and <unit>_response.csv.\n\n"
        "example:\n  towage response tow_600ft --to 2"
    )


def _hertz(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < 1e4:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a frequency in Hz, above 0 and below 10000")
    return value


def _points(text: str) -> int:
    if not text.isdecimal() or not 2 <= int(text) <= 1000:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a whole number from 2 to 1000")
    return int(text)


def execute(arguments: argparse.Namespace) -> int:
    """0. Raises `SceneError` where the scene has no tow or one that the theory refuses."""
    import numpy as np

    from towage.checks.towing import gains, scene_tows, spring_check, tolerance_of
    from towage.errors import SceneError, TowageError
    from towage.frequency_response.plots import cable_plot, response_plot
    from towage.scene.scene import Scene

    if not arguments.first < arguments.last:
        raise SceneError(f"--from {arguments.first:g} --to {arguments.last:g}: expected a rising range of frequencies")
    scene = Scene.load(arguments.scene)
    if arguments.set:
        scene = common.override(scene, dict(arguments.set))
    if arguments.case:
        scene = scene.case(arguments.case)
    out = arguments.out or Path("out", scene.file.stem if scene.file else "scene")
    omegas = (2.0 * np.pi * np.geomspace(arguments.first, arguments.last, arguments.points)).tolist()
    documents: list[dict[str, Any]] = []
    try:
        for tow in scene_tows(scene, arguments.fmus):
            rows = gains(tow.tow, omegas)
            out.mkdir(parents=True, exist_ok=True)
            files = [out / f"{tow.name}_{kind}" for kind in ("response.svg", "cable.svg", "response.csv")]
            response_plot(files[0], tow, rows)
            cable_plot(files[1], tow, tow.drive[1] if tow.drive else omegas[len(omegas) // 2])
            _write_csv(files[2], rows)
            documents.append({"unit": tow.name, "quadrant": tow.tow.quadrant, "gains": [_row(r) for r in rows]})
            if not arguments.json:
                print(_text(tow, rows))
                if spring := spring_check(tow, tolerance_of(scene)):
                    print(f"{spring.name}: {spring.message}")
                print(f"written to {out}: {', '.join(file.name for file in files)}")
    except ValueError as error:
        raise SceneError(str(error), file=scene.file, key="units") from error
    except OSError as error:
        raise TowageError(f"cannot write to {out}: {error.strerror}") from error
    if not documents:
        raise SceneError(
            "no tow: expected a unit tow_system, tow_cable or tow_cable_nonlinear", file=scene.file, key="units"
        )
    if arguments.json:
        print(json.dumps({"tows": documents}, indent=2))
    return 0


def _row(g: Gain) -> dict[str, float | None]:
    row: dict[str, float | None] = {"frequency_hz": g.omega / (2.0 * math.pi)}
    for name in ("tension_top", "tension_body", "body_surge", "body_heave"):
        value = getattr(g, name)
        row[name], row[f"{name}_phase"] = abs(value), cmath.phase(value)
    row["spring_heave"] = g.spring if g.spring is None or math.isfinite(g.spring) else None
    return row


def _write_csv(path: Path, rows: list[Gain]) -> None:
    from towage.process.files import atomic_write

    table = [_row(r) for r in rows]
    lines = [",".join(table[0])] + [",".join("" if v is None else repr(v) for v in row.values()) for row in table]
    with atomic_write(path) as stream:
        stream.write(("\n".join(lines) + "\n").encode())


def _text(tow: SceneTow, rows: list[Gain]) -> str:
    t = tow.tow
    one = "m of heave of the towpoint" if t.quadrant == 1 else "N of lift on the body"
    lines = [
        f"{tow.name}: Quadrant {'I' * t.quadrant}, {t.cable.length:.4g} m at {t.speed:.4g} m/s; per {one}",
        "      Hz    top tension, N, rad   body tension, N, rad     body heave, m, rad     body surge, m, rad    spring",
    ]
    for g in rows[:: max(1, len(rows) // 12)]:
        cells = "".join(
            f"{abs(v):14.5g}{cmath.phase(v):9.4f}" for v in (g.tension_top, g.tension_body, g.body_heave, g.body_surge)
        )
        spring = "" if g.spring is None else f"{g.spring:10.4g}"
        lines.append(f"{g.omega / (2.0 * math.pi):8.4g}{cells}{spring}")
    return "\n".join(lines)
