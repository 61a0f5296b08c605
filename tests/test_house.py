"""House rules that a person forgets and a test does not: sizes, and words for everything public. Complexity is ruff's to
tell, who may import whom import-linter's; ``make test`` runs both."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("models", "fmus", "towage", "benchmarks", "docs", "examples")
FUNCTION, FILE = 60, 300
"""Lines at most."""
FROM_THE_STANDARD = ("fmi2Function", "fmi2Types", "fmi3Function", "fmi3Platform")
"""Headers of FMI, as published."""
Definition = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


def sources(*suffixes: str) -> list[Path]:
    """Files of the project but for its tests; the links ``towage/models`` and ``towage/fmus`` are not followed."""
    own = [ROOT / "build_fmus.py"] if ".py" in suffixes else []
    for folder in FOLDERS:
        own += [
            path for path in sorted((ROOT / folder).rglob("*")) if path.suffix in suffixes
            and not any(parent.is_symlink() for parent in path.parents) and not path.name.startswith(FROM_THE_STANDARD)
        ]  # fmt: skip
    assert len(own) > 20
    return own


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text("utf-8"))


def name(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def test_files_are_short() -> None:
    long = {name(path) for path in sources(".py", ".c", ".h") if len(path.read_text("utf-8").splitlines()) > FILE}
    assert long == set(), f"more than {FILE} lines"


def test_functions_are_short() -> None:
    long = {
        f"{name(path)}:{node.name}"
        for path in sources(".py")
        for node in ast.walk(parsed(path))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and (node.end_lineno or 0) - node.lineno >= FUNCTION
    }
    assert long == set(), f"more than {FUNCTION} lines"


def public(body: list[ast.stmt], prefix: str = "") -> Iterator[tuple[str, Definition]]:
    """Functions and classes by their dotted names, and the methods of classes. What a protocol asks for is said where the
    protocol is."""
    for node in body:
        if isinstance(node, Definition) and not node.name.startswith("_"):
            yield prefix + node.name, node
            if isinstance(node, ast.ClassDef) and "Protocol" not in {ast.unparse(base) for base in node.bases}:
                yield from public(node.body, f"{prefix}{node.name}.")


def test_everything_public_says_what_it_is() -> None:
    """Modules, functions, classes and their methods."""
    silent = set()
    for path in sources(".py"):
        if name(path).split("/")[0] not in ("models", "fmus", "towage"):
            continue
        tree = parsed(path)
        silent |= {name(path)} if not ast.get_docstring(tree) else set()
        silent |= {f"{name(path)}:{dotted}" for dotted, node in public(tree.body) if not ast.get_docstring(node)}
    assert silent == set(), "no docstring"
