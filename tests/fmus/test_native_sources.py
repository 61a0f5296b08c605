"""The C sources as text: who uses whom, sizes, format, and nothing typed twice."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

import pytest

from towage.fmus.native.build import RUNTIME, runtime_sources
from towage.fmus.native.constants import COUNTS, LISTS, NUMBERS

ROOT = Path(__file__).parents[2]
STANDARD = re.compile(r"fmi[23](Functions|FunctionTypes|TypesPlatform|PlatformTypes)\.h")
"""Headers that the standard publishes, which stay as they are."""
FOLDERS = ("core", "kernel", "linear", "chain", "instance", "fmi2", "fmi3")
"""Each may use those before it, but neither version of FMI the other."""
OWN = [file for file in sorted(RUNTIME.rglob("*.[ch]")) if not STANDARD.fullmatch(file.name)]
ENSEMBLE = sorted((RUNTIME.parent / "ensemble").glob("*.[ch]"))
OTHERS = sorted((Path(__file__).parent / "host").glob("*.[ch]")) + sorted((ROOT / "benchmarks").glob("*.c"))
FUNCTION = re.compile(
    r"^(?=\w)(?!typedef|struct|enum|static const)(static )?[\w *]*?\b(\w+)\([^;{}]*\)\s*\{", re.MULTILINE
)

Graph = dict[str, set[str]]


def without_comments(text: str) -> str:
    """C text without comments, strings and directives."""
    text = re.sub(r"/\*.*?\*/", lambda comment: "\n" * comment[0].count("\n"), text, flags=re.DOTALL)
    text = re.sub(r'"(\\.|[^"\\])*"', '""', text)
    return re.sub(r"^#.*?(?<!\\)$", "", text, flags=re.MULTILINE | re.DOTALL)


def circle(graph: Mapping[str, Iterable[str]]) -> list[str]:
    """A circle of the graph, empty if there is none."""
    done: set[str] = set()

    def search(node: str, path: list[str]) -> list[str]:
        if node in path:
            return [*path[path.index(node) :], node]
        if node in done:
            return []
        for target in sorted(graph.get(node, ())):
            if way := search(target, [*path, node]):
                return way
        done.add(node)
        return []

    return next((way for node in sorted(graph) if (way := search(node, []))), [])


def includes(files: Iterable[Path]) -> Graph:
    """File names by those that they include."""
    return {file.name: set(re.findall(r'^#include "(.+)"', file.read_text(), re.MULTILINE)) for file in files}


def calls(files: Iterable[Path]) -> Graph:
    """C files by those whose functions they use."""
    texts = {file.name: without_comments(file.read_text()) for file in files if file.suffix == ".c"}
    home = {name: file for file, text in texts.items() for static, name in FUNCTION.findall(text) if not static}
    return {
        file: {home[word] for word in set(re.findall(r"(?<![.\w])(?<!->)\w+", text)) & set(home) if home[word] != file}
        for file, text in texts.items()
    }


def bodies(text: str) -> dict[str, int]:
    """Lines of every function, from its name to its closing brace."""
    lines: dict[str, int] = {}
    for start in FUNCTION.finditer(text):
        one_line = re.compile(r"[^\n]*\}$", re.MULTILINE).match(text, start.end())
        end = one_line or re.compile(r"^\}", re.MULTILINE).search(text, start.end())
        assert end, start[0]
        lines[start[2]] = text[start.start() : end.end()].count("\n") + 1
    return lines


def test_circles_are_seen() -> None:
    assert circle({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == ["b", "c", "b"]
    assert circle({"a": {"b", "c"}, "b": {"c"}}) == []


def test_no_file_includes_itself_by_others() -> None:
    graph = includes(OWN)
    assert sum(map(len, graph.values())) > 100
    assert circle(graph) == []


def test_no_files_call_each_other() -> None:
    graph = calls(OWN)
    assert {"parameters.c", "transition.c"} <= graph["observe.c"] and len(graph) > 25
    assert circle(graph) == []


def test_folders_use_those_below() -> None:
    home = {file.name: FOLDERS.index(file.parent.name) for file in OWN}
    for graph in (includes(OWN), calls(OWN)):
        for file, targets in graph.items():
            for target in targets & set(home):
                assert home[target] <= home[file], f"{file} uses {target}"
                assert (FOLDERS[home[file]], FOLDERS[home[target]]) != ("fmi3", "fmi2")


@pytest.mark.parametrize("file", OWN + ENSEMBLE + OTHERS, ids=lambda file: file.name)
def test_files_and_functions_are_short(file: Path) -> None:
    assert file.read_text().count("\n") <= 300
    lines = bodies(without_comments(file.read_text()))
    assert {name: count for name, count in lines.items() if count > 60} == {}


@pytest.mark.parametrize("file", OWN + ENSEMBLE, ids=lambda file: file.name)
def test_files_say_what_they_are_for(file: Path) -> None:
    """At the top of a header, and of a C file that has none of its name; it includes that one before all others."""
    text, header = file.read_text(), file.with_suffix(".h")
    if file.suffix == ".h" or not header.is_file():
        assert text.startswith("/* ")
    else:
        assert re.findall(r'#include ["<](.+)[">]', text)[0] == header.name


def test_functions_are_measured() -> None:
    """Against a count by hand."""
    text = "static int f(int a,\n  int b)\n{\n    if (a) {\n        b++;\n    }\n    return b;\n}\n\nint g(void) { return 1; }\n"
    assert bodies(text) == {"f": 8, "g": 1}
    names = {name for file in OWN for name in bodies(without_comments(file.read_text()))}
    assert {"schur", "integrate", "fmi2DoStep", "fmi3GetFloat64", "is_finite", "instance_new"} <= names


def test_one_format() -> None:
    """That of ``.clang-format``."""
    command = [str(Path(sys.executable).with_name("clang-format")), "--dry-run", "-Werror", "--ferror-limit=5"]
    files = [str(file) for file in OWN + ENSEMBLE + OTHERS]
    done = subprocess.run([*command, *files], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr[:3000]


def test_what_python_defines_is_not_typed_again() -> None:
    """Neither a name of ``constants.h`` nor one of its numbers, but for those that stand for themselves."""
    generated = {**NUMBERS, **COUNTS, **LISTS}
    plain = {0.1, 0.2, 3, 4, 5.0, 40}  # also a share, a place, a number of sweeps
    values = {value for value, _ in (*NUMBERS.values(), *COUNTS.values())} - plain
    strings = {text for texts in LISTS.values() for text in texts if text != text.lower()}
    assert len(values) > 12
    for file in OWN:
        text = re.sub(r"/\*.*?\*/", "", file.read_text(), flags=re.DOTALL)
        for name in generated:
            assert not re.search(rf"#define {name}\b|\b{name} *=[^=]", text), f"{file.name} defines {name}"
        quoted = set(re.findall(r'"([^"]*)"', text))
        assert not quoted & strings, f"{file.name} spells {quoted & strings}"
        literals = re.findall(r"(?<![\w.])\d+\.?\d*(?:[eE][-+]?\d+)?(?![\w.])", without_comments(text))
        again = {number for number in literals if float(number) in values}
        assert not again, f"{file.name} has {again}, which Python defines"


def test_generated_headers_are_part_of_the_sources() -> None:
    for fmi in (2, 3):
        sources = runtime_sources(fmi)
        assert b"#define TIME_TOLERANCE 1e-09 " in sources["constants.h"]
        assert b"k[6]" in sources["stages.h"]
        assert set(sources) >= {file.name for file in OWN if file.parent.name not in (f"fmi{5 - fmi}", "chain", "kernel")}
