"""Computes every table and figure of the source reports, for ``docs/reports/``: ``python docs/make_reports.py [REPORT ...]``.

The pages are not committed: what they say is what the program does now.
"""

import sys
from pathlib import Path

from towage.reproduce import gallery
from towage.reproduce.items import REPORTS, Reproduction, items, reproduce

PAGES = Path(__file__).with_name("reports")


def write(report: str) -> list[Reproduction]:
    """Computes a report, and writes its page, pictures and CSV files."""
    found = [reproduce(item) for item in items(report)]
    for one in found:
        gallery.write_files(one, PAGES)
        for fault in one.faults:
            print(f"{one.item.full_name}: {fault}", file=sys.stderr)
    (PAGES / f"{report}.md").write_text(gallery.page(report, found), encoding="utf-8")
    return found


if __name__ == "__main__":
    PAGES.mkdir(exist_ok=True)
    every = {report: write(report) for report in sys.argv[1:] or REPORTS}
    if not sys.argv[1:]:
        (PAGES / "index.md").write_text(gallery.index(every), encoding="utf-8")
    if any(one.faults for found in every.values() for one in found):
        raise SystemExit(1)
