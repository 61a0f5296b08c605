"""Writes the pages of the API into ``docs/api/``, one a package, for mkdocstrings to fill: ``python docs/make_api.py``.

The pages are not committed: what they say stands in the docstrings.
"""

from __future__ import annotations

from pathlib import Path

import towage

PAGES = Path(__file__).with_name("api")
SOURCE = Path(towage.__file__).parent
INTRODUCTION = """# Functions and classes

What `import towage` gives. The pages beside this one have the modules behind it: the models (`towage.models`: physics
alone), the units and their FMUs (`towage.fmus`), and the master with its checks, reports and sweeps. Values are SI, angles
rad, time s, unless a docstring says otherwise; z and heave are positive up, tension is positive in tension.
"""


def pages() -> dict[str, str]:
    """Markdown by path below ``docs/api``: the top level, then a page for every package with modules of its own."""
    names = [name for name in towage.__all__ if not name.startswith("_")]
    texts = {"index.md": INTRODUCTION + "".join(f"\n::: towage.{name}\n" for name in names)}
    for folder in packages():
        package = ".".join(["towage", *folder.parts])
        modules = sorted(file.stem for file in (SOURCE / folder).glob("*.py") if file.stem not in ("__init__", "__main__"))
        if modules:
            body = "".join(f"\n::: {package}.{module}\n" for module in modules)
            texts[f"{'/'.join(folder.parts)}.md"] = f"# {package}\n\n::: {package}\n    options: {{members: false}}\n{body}"
    return texts


def packages() -> list[Path]:
    """Packages below towage, relative to it, those of the models and the units first."""
    roots = ("models", "fmus", *sorted(path.name for path in SOURCE.iterdir() if path.name not in ("models", "fmus")))
    every = [file.parent for root in roots for file in sorted((SOURCE / root).rglob("__init__.py"))]
    return [folder.relative_to(SOURCE) for folder in every]


def write(directory: Path) -> None:
    """Writes all pages below ``directory``, and removes those of packages that are gone."""
    texts = pages()
    for old in directory.rglob("*.md"):
        if old.relative_to(directory).as_posix() not in texts:
            old.unlink()
    for name, text in texts.items():
        path = directory / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write(PAGES)
