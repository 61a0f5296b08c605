"""What a stored result was computed with: the text of the modules that take part.

They are found by the imports in their text, and by the places that a registry names as "towage.module:attribute". A cache
whose key contains `code_digest` of the computing module never holds what other code has made.
"""

from __future__ import annotations

import ast
import functools
import hashlib
import re
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT.name
_PLACE = re.compile(rf"({PACKAGE}(?:\.\w+)+):\w+")
LIBRARIES = ("numpy", "scipy")
"""Packages whose version may change the last digits of a result."""


@functools.cache
def code_digest(module: str) -> str:
    """Of the text of ``module`` ("towage.x.y") and of every module of towage that it imports, inside functions too, and of
    the versions of `LIBRARIES`."""
    digest = hashlib.sha256("\0".join(f"{name} {metadata.version(name)}" for name in LIBRARIES).encode())
    for name, text in sorted(modules(module).items()):
        digest.update(name.encode() + b"\0" + text + b"\0")
    return digest.hexdigest()


def brought() -> list[str]:
    """The installed packages that bring units, schemes, checks or writers by entry points (`towage.registry`)."""
    points = metadata.entry_points()
    groups = (group for group in points.groups if group.startswith(f"{PACKAGE}."))
    return sorted({point.dist.name for group in groups for point in points.select(group=group) if point.dist})


def modules(start: str) -> dict[str, bytes]:
    """The text of ``start``, of the modules of towage that it imports, of those that these import, and of their packages,
    by name."""
    texts: dict[str, bytes] = {}
    left = [start]
    while left:
        name = left.pop()
        file = _file(name)
        if name in texts or file is None:
            continue
        texts[name] = text = file.read_bytes()
        package = name if file.name == "__init__.py" else name.rpartition(".")[0]
        left.append(name.rpartition(".")[0] or name)
        for node in _references(ast.parse(text)):
            if isinstance(node, ast.Import):
                left += [alias.name for alias in node.names]
                continue
            if isinstance(node, str):
                left.append(node)
                continue
            above = package.split(".")[: package.count(".") + 2 - node.level] if node.level else []
            base = ".".join([*above, *filter(None, [node.module])])
            left += [base, *(f"{base}.{alias.name}" for alias in node.names)]
    return texts


def _references(tree: ast.AST) -> Iterator[ast.Import | ast.ImportFrom | str]:
    """The imports of a module, without those for type checkers alone, and the modules that its texts name."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            yield node
        elif isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
            yield from (reference for other in node.orelse for reference in _references(other))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and (place := _PLACE.fullmatch(node.value)):
            yield place[1]
        else:
            yield from _references(node)


def _file(name: str) -> Path | None:
    """The file of a module or package of towage; None for anything else."""
    first, *rest = name.split(".")
    if first != PACKAGE:
        return None
    place = ROOT.joinpath(*rest)
    if place.is_dir():
        return place / "__init__.py"
    file = place.with_suffix(".py")
    return file if file.is_file() else None
