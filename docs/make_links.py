"""What the site changes in the pages of the repository (a hook of MkDocs): the table of scenes links to the scenes' pages
and the navigation has the pages of the API, which are both made and not committed; links to files outside ``docs/`` become
the names of these files."""

import re
from pathlib import Path
from typing import Any

SCENES, API = (Path(__file__).with_name(name) for name in ("scenes", "api"))


def on_config(config: Any) -> Any:
    """The navigation with the pages of the API at its end, nested as the packages are."""
    config.nav.append({"API": tree(API, API.parent)})
    return config


def tree(folder: Path, root: Path) -> list[Any]:
    """Entries of the navigation for a folder: its pages, a package's own before those of the packages in it."""
    entries: list[Any] = []
    for page in sorted(folder.glob("*.md"), key=lambda page: (page.stem != "index", page.stem)):
        path = page.relative_to(root).as_posix()
        inner = page.with_suffix("")
        entries.append({inner.name: [path, *tree(inner, root)]} if inner.is_dir() else path)
    alone = (inner for inner in sorted(folder.iterdir()) if inner.is_dir() and not inner.with_suffix(".md").is_file())
    return entries + [{inner.name: tree(inner, root)} for inner in alone]


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """The text of a page as the site has it."""
    text = re.sub(r"\[([^\]]+)\]\(\.\./([^)#]+)\)", r"\1 (`\2`)", markdown)
    return linked(text) if page.file.src_uri == "scenes.md" else text


def linked(markdown: str) -> str:
    """A name in the first column leads to the scene's page, if there is one."""

    def link(cell: re.Match[str]) -> str:
        """The first cell of a row, as a link where it can be one."""
        name = cell[1]
        return f"| [`{name}`](scenes/{name}.md) |" if (SCENES / f"{name}.md").is_file() else cell[0]

    return re.sub(r"^\| `(\w+)` \|", link, markdown, flags=re.MULTILINE)
