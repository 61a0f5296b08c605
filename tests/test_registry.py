"""What other packages bring: a unit, a scheme, a check and a writer run; what is faulty is told with its package."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.third_party.install import install, install_buoys
from towage.errors import TowageError
from towage.master.schemes import HERMITE, Scheme
from towage.registry import SCHEMES, UNITS, Registry
from towage.result.result import Result

SCENE = """title = "A buoy on a line"
stop_time = "4 s"
connections = [
    "buoy.heave -> line.heave_top", "cradle.heave -> line.heave_bottom", "line.tension -> cradle.line_tension",
]
[units.buoy]
fmu = "buoy"
parameters = { heave_amplitude = "1 m", heave_period = "4 s" }
[units.line]
fmu = "spring_line"
[units.cradle]
fmu = "cradle"
[coupling]
scheme = "newest"
step = "0.1 s"
[checks.sinkage]
motion = "buoy.heave"
lowest = -0.5
"""


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder from which packages are imported, here and in processes started."""
    folder = tmp_path / "site"
    folder.mkdir()
    monkeypatch.syspath_prepend(folder)
    return folder


def towage(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """The command in a process that sees what this one sees."""
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(path or os.getcwd() for path in sys.path),
        "TOWAGE_CACHE": str(folder / "cache"),
    }
    command = [sys.executable, "-m", "towage", *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300)


def schemes(**own: str) -> Registry:
    """A registry that has read no entry points yet."""
    return Registry("towage.schemes", "scheme", "towage.master.schemes:Scheme", own)


def test_own_names_need_no_entry_points(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(**options: object) -> None:
        raise AssertionError("the metadata of all packages were read")

    monkeypatch.setattr("importlib.metadata.entry_points", fail)
    own = schemes(hermite="towage.master.schemes:HERMITE")
    assert own.get("hermite") is HERMITE
    assert "hermite" in own
    with pytest.raises(AssertionError, match="metadata"):
        own.names()


@pytest.mark.parametrize("registry", [SCHEMES, UNITS], ids=lambda registry: registry.what)
def test_own_values_have_the_names_they_stand_under(registry: Registry) -> None:
    assert [registry.get(name).name for name in registry.own] == list(registry.own)


def test_unknown_name_is_told_with_the_known_ones(site: Path) -> None:
    install_buoys(site)
    known = schemes(hermite="towage.master.schemes:HERMITE")
    with pytest.raises(TowageError, match="unknown scheme 'newst'; did you mean 'newest'.*: hermite, newest"):
        known.get("newst")


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("lost = nowhere.at_all:IT", "cannot be loaded .ModuleNotFoundError: No module named 'nowhere'"),
        ("lost = towage.errors:NOTHING", "cannot be loaded .AttributeError"),
        ("lost = towage.errors:suggest", "which is a function: expected a Scheme"),
    ],
)
def test_faulty_entry_is_told_with_its_package(site: Path, line: str, says: str) -> None:
    install(site, "towage-junk", {"towage.schemes": line})
    junk = schemes()
    assert junk.names() == ("lost",)
    with pytest.raises(TowageError, match=f"package 'towage-junk' .entry point {line} of towage.schemes.*{says}"):
        junk.get("lost")


def test_name_of_towage_cannot_be_taken(site: Path) -> None:
    install(site, "towage-junk", {"towage.schemes": "hermite = towage.master.schemes:JACOBI"})
    own = schemes(hermite="towage.master.schemes:HERMITE")
    assert own.get("hermite") is HERMITE
    with pytest.raises(TowageError, match="'towage-junk'.* brings the scheme 'hermite', a name that towage uses itself"):
        own.names()


def test_two_packages_with_one_name_are_told(site: Path) -> None:
    install(site, "towage-junk", {"towage.schemes": "lost = towage.master.schemes:JACOBI"})
    install(site, "towage-scrap", {"towage.schemes": "lost = towage.master.schemes:HERMITE"})
    with pytest.raises(TowageError, match="'towage-junk'.*'towage-scrap'|'towage-scrap'.*'towage-junk'"):
        schemes().names()


@pytest.mark.parametrize(
    ("masses", "limit"), [(1, 2.4), (2, 1.2)], ids=["one mass", "two"]
)
def test_a_scheme_knows_its_limits(masses: int, limit: float) -> None:
    assert HERMITE.limit(masses) == limit
    unlimited: Callable[..., float] = Scheme("free", "", 1, 1, lambda *given: 0.0).limit
    assert unlimited(masses) == float("inf")


def test_a_scene_runs_with_all_that_a_package_brings(site: Path, tmp_path: Path) -> None:
    install_buoys(site)
    (tmp_path / "buoy.toml").write_text(SCENE)
    done = towage(
        tmp_path, "run", "buoy.toml", "--out", "out", "--write", "npz,count", "--no-report", "--progress", "none"
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "buoy.count").read_text() == "41\n"
    result = Result.load_npz(tmp_path / "out" / "buoy.npz")
    assert result.scheme == "newest"
    assert result["buoy.heave"].min() == pytest.approx(-1.0, rel=1e-2)
    (finding,) = [finding for finding in result.checks if finding.name == "sinkage"]
    assert (finding.level, finding.message) == ("warning", "buoy.heave goes down to -1 m")
    again = towage(tmp_path, "check", "buoy.toml")
    assert again.returncode == 0, again.stderr
    assert "newest" in again.stdout
    listed = towage(tmp_path, "list")
    assert "A buoy that heaves as it is told" in listed.stdout


def test_the_fmu_of_a_package_stands_alone(site: Path, tmp_path: Path) -> None:
    """Where neither the package nor towage can be imported it carries both, under a name of its own."""
    install_buoys(site)
    (tmp_path / "buoy.toml").write_text(SCENE)
    assert towage(tmp_path, "validate", "buoy.toml").returncode == 0
    fmu = tmp_path / "cache" / "fmus" / "buoy.fmu"
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(tmp_path / "unpacked")
    resources = tmp_path / "unpacked" / "resources"
    script = (resources / "slavemodule.txt").read_text().strip()
    program = f"import {script}; print({script}.buoy.unit.description); print(type({script}.buoy.unit).__module__)"
    done = subprocess.run(
        [sys.executable, "-I", "-c", f"import sys; sys.path.insert(0, {str(resources)!r}); {HIDDEN}; {program}"],
        capture_output=True, text=True, timeout=60, check=True,
    )  # fmt: skip
    description, module = done.stdout.splitlines()
    assert description == "A buoy that heaves as it is told"
    assert module == script.removesuffix("_fmu") + ".fmus.declare.unit"


HIDDEN = "sys.modules.update(dict.fromkeys(('towage', 'towage_buoys'), None))"
"""Whoever imports these now gets an ImportError."""
