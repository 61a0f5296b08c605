"""Full disks and damaged caches: what was there is kept, what can be made again is made again."""

from __future__ import annotations

import contextlib
import os
import resource
import shutil
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from towage.cli import main
from towage.units import store

from .survival import STOP, Case, scene
from .unit_cases import misbehaving

SMALL = 64 << 10
"""Size of a full disk, bytes."""
LARGEST_FILE = 512
"""Less than any result, bytes."""
SOUND = misbehaving("none")


def shipped(directory: Path) -> Path:
    """A scene whose unit is built into the cache."""
    store._python.cache_clear()
    return scene(directory, {"ship": Path("ship")}, [])


def _run_before(directory: Path) -> None:
    code = main(
        ["run", str(directory / "scene.toml"), "--out", str(directory / "out"), "--no-report", "--progress", "none"]
    )
    assert code == 0


@contextlib.contextmanager
def _disk(place: Path) -> Iterator[None]:
    """A small disk at ``place``; needs the right to mount one."""
    place.mkdir(exist_ok=True)
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={SMALL}", "tmpfs", str(place)], capture_output=True)
    if done.returncode:
        pytest.skip("may not mount a small disk")
    try:
        yield
    finally:
        subprocess.run(["umount", "-l", str(place)], check=True)


def _fill(place: Path) -> None:
    with contextlib.suppress(OSError), open(place / "filler", "wb", buffering=0) as file:
        while file.write(bytes(512)):
            pass


@contextlib.contextmanager
def _cache(place: Path) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TOWAGE_CACHE", str(place))
        yield


@contextlib.contextmanager
def full_results(directory: Path) -> Iterator[None]:
    """No room beside the results of an earlier run."""
    with _disk(directory / "out"):
        _run_before(directory)
        _fill(directory / "out")
        yield


@contextlib.contextmanager
def short_files(directory: Path) -> Iterator[None]:
    """After an earlier run no file may grow beyond `LARGEST_FILE`."""
    _run_before(directory)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (LARGEST_FILE, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@contextlib.contextmanager
def full_cache(directory: Path) -> Iterator[None]:
    """No room to build or unpack."""
    with _disk(directory / "cache"), _cache(directory / "cache"):
        _fill(directory / "cache")
        yield


@contextlib.contextmanager
def full_temporary(directory: Path) -> Iterator[None]:
    """No room for temporary files, of which a run with an output directory needs none."""
    with _disk(directory / "temporary"), pytest.MonkeyPatch.context() as patch:
        patch.setattr(tempfile, "tempdir", str(directory / "temporary"))
        _fill(directory / "temporary")
        yield


@contextlib.contextmanager
def removed_results(directory: Path) -> Iterator[None]:
    """The output directory goes as soon as a run has begun."""
    ended = threading.Event()

    def remove() -> None:
        """Wait for the journal, and take its directory away."""
        journal = directory / "out" / "scene.unfinished" / "journal"
        while not ended.is_set() and not (journal.exists() and journal.stat().st_size):
            time.sleep(0.001)
        shutil.rmtree(directory / "out", ignore_errors=True)

    thread = threading.Thread(target=remove)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def damaged(pattern: str) -> Callable[[Path], contextlib.AbstractContextManager[None]]:
    """Files of the cache lose their second half after a first run, as in a power failure."""

    @contextlib.contextmanager
    def during(directory: Path) -> Iterator[None]:
        with _cache(directory / "cache"):
            _run_before(directory)
            files = list((directory / "cache").rglob(pattern))
            assert files
            store._python.cache_clear()  # as in another process
            for file in files:
                os.truncate(file, file.stat().st_size // 2)
            yield

    return during


CASES = [
    Case(
        "disk", "full where the results go", SOUND, 3, "the disk is full; the earlier file is kept", STOP, full_results
    ),
    Case("disk", "files are limited to 512 bytes", shipped, 3, "exceeds the largest file size", STOP, short_files),
    Case("disk", "full where FMUs are unpacked", SOUND, 2, "unpacked: .*No space left", None, full_cache),
    Case(
        "disk", "full where shipped FMUs are built", shipped, 2, "cannot be built: the disk is full", None, full_cache
    ),
    Case("disk", "full where temporary files go", SOUND, 0, "", STOP, full_temporary),
    Case("disk", "the folder of the results removed during the run", SOUND, 0, "made again", STOP, removed_results),
    Case("disk", "unpacked library cut in half", SOUND, 0, "", STOP, damaged("hostile.so")),
    Case("disk", "built FMU cut in half", shipped, 0, "", STOP, damaged("ship.fmu")),
]
