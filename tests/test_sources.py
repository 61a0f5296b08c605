"""What the key of a cache is made of: the modules that take part in a computation, no more and no fewer."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from towage.registry import CHECKS, SCHEMES
from towage.units import sources
from towage.units.sources import code_digest, modules


def test_the_modules_of_a_computation_are_those_that_it_imports() -> None:
    name = "towage.models.slender.critical"
    code = f"import sys, {name}; print(*(name for name in sys.modules if name.split('.')[0] == 'towage'))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert set(modules(name)) == set(loaded.stdout.split())
    assert "towage.models.numeric.ops" in modules(name)


def test_what_a_registry_names_takes_part_in_a_sweep() -> None:
    reached = modules("towage.sweeps.workers")
    for registry in (CHECKS, SCHEMES):
        for place in registry.own.values():
            assert place.partition(":")[0] in reached


def test_a_changed_module_changes_the_key(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = {
        "__init__.py": "",
        "one.py": "from __future__ import annotations\nfrom typing import TYPE_CHECKING\n"
        "if TYPE_CHECKING:\n    from towage.other import Never\n"
        "def f():\n    from .inner.two import g\n    return g('towage.three:NAME')\n",
        "inner/__init__.py": "",
        "inner/two.py": "import towage.four\nfrom ..five import x\n",
        "three.py": "", "four.py": "", "five.py": "", "other.py": "",
    }  # fmt: skip
    (tmp_path / "inner").mkdir()
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(sources, "ROOT", tmp_path)
    assert sorted(modules("towage.one")) == [
        "towage", "towage.five", "towage.four", "towage.inner", "towage.inner.two", "towage.one", "towage.three"
    ]  # fmt: skip
    keys = set()
    for name in ("five.py", "other.py"):
        (tmp_path / name).write_text("changed = 1\n")
        code_digest.cache_clear()
        keys.add(code_digest("towage.one"))
    code_digest.cache_clear()
    assert len(keys) == 1, "only five.py takes part, and it was changed before the first"
    (tmp_path / "five.py").write_text("changed = 2\n")
    assert code_digest("towage.one") not in keys
    code_digest.cache_clear()
