"""``towage stability``: critical tow speeds of a scene's slender body, its modes over speed, a stability map."""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from towage.commands import common

if TYPE_CHECKING:
    from towage.tow_stability.stability import Row, Towed

HELP = "critical tow speeds of a scene's towed slender body"
MAPS = ("tail_cut", "rope_length", "slenderness")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of ``towage stability``."""
    parser.add_argument("scene", metavar="FILE", help="a scene file with a slender_body, or the name of a shipped scene")
    parser.add_argument("--case", metavar="NAME", help="with the values of this case")
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", type=common.setting, default=[],
                        help="a value in place of the scene's: unit.parameter (may be repeated)")  # fmt: skip
    common.add_fmus(parser)
    parser.add_argument("--map", choices=MAPS, help="a stability map over this parameter too")
    parser.add_argument("--points", metavar="N", type=_points, default=41, help="values of the map (default: 41)")
    parser.add_argument("--u-max", metavar="U", type=_speed, default=12.0,
                        help="largest dimensionless tow speed u, at most 14 (default: 12)")  # fmt: skip
    parser.add_argument("--out", metavar="DIR", type=Path, help="where the files go (default: out/<scene>)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument("--progress", choices=("auto", "json", "none"), default="auto", help="as of towage run")
    parser.epilog = (
        "Writes argand.svg, and for a map <parameter>.svg and <parameter>.csv. Rows of a map are kept in the cache.\n\n"
        "example:\n  towage stability slender_flutter --map tail_cut"
    )


def _points(text: str) -> int:
    if not text.isdecimal() or not 2 <= int(text) <= 1000:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a whole number from 2 to 1000")
    return int(text)


def _speed(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.5 <= value <= 14.0:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a number from 0.5 to 14")
    return value


def execute(arguments: argparse.Namespace) -> int:
    """0. Raises `SceneError` where the scene has no slender body or one that no theory holds for."""
    from towage.errors import SceneError, TowageError
    from towage.scene.scene import Scene
    from towage.tow_stability.stability import bodies, row

    scene = Scene.load(arguments.scene)
    if arguments.set:
        scene = common.override(scene, dict(arguments.set))
    if arguments.case:
        scene = scene.case(arguments.case)
    out = arguments.out or Path("out", scene.file.stem if scene.file else "scene")
    documents = []
    for towed in bodies(scene, arguments.fmus):
        try:
            limits = row(towed.body, u_max=arguments.u_max)
            out.mkdir(parents=True, exist_ok=True)
            files = _draw(towed, arguments, out)
        except ValueError as error:
            raise SceneError(str(error), file=scene.file, key=f"units.{towed.name}.parameters") from error
        except OSError as error:
            raise TowageError(f"cannot write to {out}: {error.strerror}") from error
        documents.append(_document(towed, limits, files))
        if not arguments.json:
            print(_text(towed, limits, arguments.u_max))
            print(f"written to {out}: {', '.join(file.name for file in files)}")
    if arguments.json:
        print(json.dumps({"bodies": documents}, indent=2))
    return 0


def _draw(towed: Towed, arguments: argparse.Namespace, out: Path) -> list[Path]:
    import numpy as np

    from towage.process.progress import progress
    from towage.tow_stability.plots import argand_plot, map_plot
    from towage.tow_stability.stability import argand, default_values, stability_map

    prefix = f"{towed.name}_"
    speeds = np.linspace(0.05, arguments.u_max, round(20 * arguments.u_max))
    files = [out / f"{prefix}argand.svg"]
    argand_plot(
        files[0], f"{towed.name}: modes from {speeds[0] * towed.speed_scale:.3g} to "
        f"{speeds[-1] * towed.speed_scale:.3g} m/s", speeds, argand(towed.body, speeds), towed.speed_scale,
    )  # fmt: skip
    if arguments.map:
        values = default_values(towed.body, arguments.map, arguments.points)
        with progress(1.0, f"map over {arguments.map}", arguments.progress) as bar:
            rows = stability_map(towed.body, arguments.map, values, arguments.u_max, bar.update)
        files += [out / f"{prefix}{arguments.map}.{suffix}" for suffix in ("svg", "csv")]
        map_plot(files[1], f"{towed.name}: stability over {arguments.map}", arguments.map, rows, arguments.u_max,
                 towed.speed_scale)  # fmt: skip
        _write_csv(files[2], arguments.map, rows, towed)
    return files


def _write_csv(path: Path, parameter: str, rows: list[Row], towed: Towed) -> None:
    from towage.process.files import atomic_write

    lines = [f"{parameter},kind,u,tow_speed_m_s,omega_rad_s,growth_above"]
    for r in rows:
        for u in r.yaw:
            lines.append(f"{r.value!r},yaw,{u!r},{u * towed.speed_scale!r},0.0,")
        for u, omega, grows in r.flutter:
            frequency = omega / towed.time_scale
            lines.append(f"{r.value!r},flutter,{u!r},{u * towed.speed_scale!r},{frequency!r},{int(grows)}")
    with atomic_write(path) as stream:
        stream.write(("\n".join(lines) + "\n").encode())


def _document(towed: Towed, limits: Row, files: list[Path]) -> dict[str, Any]:
    v = towed.speed_scale
    return {
        "unit": towed.name,
        "speed_scale_m_s": v,
        "time_scale_s": towed.time_scale,
        "yaw_m_s": [u * v for u in limits.yaw],
        "flutter": [
            {"tow_speed_m_s": u * v, "omega_rad_s": w / towed.time_scale, "growth_above": grows}
            for u, w, grows in limits.flutter
        ],
        "stable_m_s": [[a * v, b * v] for a, b in limits.stable],
        "files": [str(file) for file in files],
    }


def _text(towed: Towed, limits: Row, u_max: float) -> str:
    from towage.models.slender.rigid import neutral_tail_cut, yaw_criterion

    v = towed.speed_scale
    lines = [f"{towed.name}: speeds up to {u_max * v:.4g} m/s (u = {u_max:g}; u = 1 is {v:.4g} m/s)"]
    lines += [f"  yaw      {u * v:9.4f} m/s  (u = {u:.6f})" for u in limits.yaw]
    lines += [
        f"  flutter  {u * v:9.4f} m/s  (u = {u:.6f}), {w / towed.time_scale:.4g} rad/s, "
        + ("begins" if grows else "ends")
        for u, w, grows in sorted(limits.flutter)
    ]
    windows = ", ".join(f"{a * v:.4g} to {b * v:.4g} m/s" for a, b in limits.stable) or "at no speed"
    lines.append(f"  stable   {windows}")
    if towed.body.theory != "modified_old":
        neutral = neutral_tail_cut(towed.body)
        rigid = "does not yaw away" if yaw_criterion(towed.body) > 0.0 else "yaws away at every speed"
        at = "" if neutral is None else f"; it is neutral with the tail cut at {neutral:.6f}"
        lines.append(f"  a rigid body of this shape {rigid}{at}")
    return "\n".join(lines)
