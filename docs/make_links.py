"""What the site changes in the pages of the repository (a hook of MkDocs): the table of scenes links to the scenes' pages,
which are made and not committed, and links to files outside ``docs/`` become the names of these files."""

import re
from pathlib import Path
from typing import Any

SCENES = Path(__file__).with_name("scenes")


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """The text of a page as the site has it."""
    text = re.sub(r"\[([^\]]+)\]\(\.\./([^)#]+)\)", r"\1 (`\2`)", markdown)
    return linked(text) if page.file.src_uri == "scenes.md" else text


def linked(markdown: str) -> str:
    """A name in the first column leads to the scene's page, if there is one."""

    def link(found: re.Match[str]) -> str:
        name = found[1]
        return f"| [`{name}`](scenes/{name}.md) |" if (SCENES / f"{name}.md").is_file() else found[0]

    return re.sub(r"^\| `(\w+)` \|", link, markdown, flags=re.MULTILINE)
