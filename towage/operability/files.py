"""What a study leaves behind beside its report: a row a cell, a row a limit, and a document with the shares of the time."""

from __future__ import annotations

import codecs
import csv
import json
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from towage.files import atomic_write
from towage.operability.outcome import Cell, Limit, Outcome, Uptime
from towage.operability.study import Done


def write(done: Done, out: Path) -> list[Path]:
    """Writes ``cells.csv``, ``limits.csv`` and ``study.json`` to ``out``. Raises `TowageError`."""
    files = [out / name for name in ("cells.csv", "limits.csv", "study.json")]
    _rows(files[0], _cell_rows(done))
    _rows(files[1], _limit_rows(done))
    with atomic_write(files[2]) as stream:
        stream.write(json.dumps(document(done), indent=2, allow_nan=False).encode())
    return files


def _rows(path: Path, rows: Iterable[Sequence[object]]) -> None:
    with atomic_write(path) as stream:
        writer = csv.writer(codecs.getwriter("utf-8")(stream, "backslashreplace"), lineterminator="\n")
        writer.writerows([["" if value != value else value for value in row] for row in rows])


def _cell_rows(done: Done) -> Iterable[Sequence[object]]:
    """Places and words, then of each criterion what the fit says, and the linear response beside it."""
    one, plan = done.outcome, done.outcome.plan
    parts = ("most probable", f"quantile {one.probability:g}", "low", "high", "exceedance", "exceedance low", "exceedance high",
             "fit", "kind")  # fmt: skip
    heads = [f"{c.text}: {part}" for c in one.criteria for part in parts]
    linear = done.screening.outcome
    known = linear.criteria if linear else ()
    yield (
        "heading [deg]", "Hs [m]", "Tp [s]", f"{plan.scatter.kind} of the diagram [s]", "share", "word", "sure", "reason",
        "smallest margin", "margin of", *heads,
        *(f"{c.text}: linear {part}" for c in known for part in ("most probable", "quantile")),
    )  # fmt: skip
    none = [math.nan] * len(heads)
    for cell in one.cells:
        numbers = [value for e in cell.extremes for value in vars(e).values()]
        beside = linear.by_place[cell.heading, cell.height, cell.period].extremes if linear else ()
        yield (
            plan.headings.degrees[cell.heading], float(plan.scatter.heights[cell.height]), float(plan.peaks[cell.period]),
            float(plan.scatter.periods[cell.period]), cell.share * plan.headings.shares[cell.heading], cell.word,
            "yes" if cell.sure else "no", cell.reason, cell.margin, cell.margin_of, *(numbers or none),
            *(value for e in beside for value in (e.probable, e.quantile)),
        )  # fmt: skip


def _limit_rows(done: Done) -> Iterable[Sequence[object]]:
    one = done.outcome
    linear = (
        {(lim.heading, lim.period): lim for lim in done.screening.outcome.limits()} if done.screening.outcome else {}
    )
    yield "heading [deg]", "Tp [s]", "limit of Hs [m]", "kind", "by", "linear limit of Hs [m]", "linear kind"
    for lim in one.limits():
        beside = linear.get((lim.heading, lim.period))
        yield (
            one.plan.headings.degrees[lim.heading], float(one.plan.peaks[lim.period]), lim.height, lim.kind, lim.criterion,
            *((beside.height, beside.kind) if beside else (math.nan, "")),
        )  # fmt: skip


def document(done: Done) -> dict[str, Any]:
    """Shares of the time and how they were found, for other programs; NaN is null."""
    one, plan = done.outcome, done.outcome.plan
    linear = done.screening.outcome
    found: dict[str, Any] = {
        "title": done.table.title,
        "criteria": [c.text for c in one.criteria],
        "probability": one.probability,
        "length_s": plan.length,
        "seeds": plan.seeds,
        "cells": len(one.cells),
        "runs": len(done.table.status),
        "runs_not_done": done.lost,
        "runs_spared": done.table.status.count("spared"),
        "simulated_hours": done.hours,
        "elapsed_s": done.elapsed,
        "hours_a_second": done.rate,
        "uptime": one.whole._asdict(),
        "by_heading": [
            {"heading_deg": degrees, "probability": share, **one.uptime(plan.scatter.share, k)._asdict()}
            for k, (degrees, share) in enumerate(zip(plan.headings.degrees, plan.headings.shares))
        ],
        "by_month": [{"month": name, **uptime._asdict()} for name, uptime in one.monthly()],
        "fits_rejected": fits_rejected(one),
        "screening": {
            "uptime": linear.whole.holds if linear else math.nan,
            "criteria": [c.text for c in linear.criteria] if linear else [],
            "left_out": list(done.screening.missing),
            "deficit": dict(zip(("mean", "largest"), done.screening.deficit)),
        },
        "notes": list(done.notes),
    }
    plain: dict[str, Any] = _plain(found)
    return plain


def fits_rejected(one: Outcome) -> dict[str, float]:
    """By criterion, the share of the cells with a fit that the test rejects at its level; NaN where nothing was fitted."""
    from towage.operability.extremes import REJECTED

    own = [cell for cell in one.cells if one.plan.run[cell.heading] == cell.heading and cell.extremes]
    shares = {}
    for k, criterion in enumerate(one.criteria):
        fits = [cell.extremes[k].fit for cell in own if cell.extremes[k].kind == "Gumbel"]
        shares[criterion.text] = sum(fit < REJECTED for fit in fits) / len(fits) if fits else math.nan
    return shares


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def nearest(one: Outcome, most: int) -> list[tuple[Cell, int]]:
    """Cells and criteria with the limit inside the confidence interval, those with most of the time first, then those whose
    quantile is nearest to the limit: where the answer hangs on the numbers."""
    near: list[tuple[float, float, int, Cell, int]] = []
    for cell in one.cells:
        if one.plan.run[cell.heading] != cell.heading:
            continue
        for k, (criterion, extreme) in enumerate(zip(one.criteria, cell.extremes)):
            inside = extreme.low <= criterion.limit <= extreme.high and cell.share > 0.0
            off = 0.0 if inside else abs(extreme.quantile - criterion.limit) / (abs(criterion.limit) or 1.0)
            near.append((off, -cell.share, len(near), cell, k))
    return [(cell, k) for *_, cell, k in sorted(near)[:most]]


def limit_text(lim: Limit) -> str:
    """The limit of a heading and period, as a table shows it."""
    number = f"{lim.height:.2f}"
    return {"crossing": number, "below": f"< {number}", "above": f"> {number}"}.get(
        lim.kind, "?" if lim.height != lim.height else f"{number} ?"
    )


def shares_text(uptime: Uptime) -> str:
    """Uptime and its range in words, %."""
    return f"{100.0 * uptime.holds:.1f} % (from {100.0 * uptime.sure:.1f} to {100.0 * uptime.most:.1f} %)"
