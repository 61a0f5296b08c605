"""Compiles C sources to the library of an FMU: with the host's compiler, or for every platform with the ziglang wheel.

Sources are compiled in a directory of their own under relative names, without debugging information, so that no path
of this machine is in the library and two builds on one machine are the same to the byte.
"""

from __future__ import annotations

import importlib.util
import os
import platform
import shlex
import shutil
import struct
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from ..declare.unit import BuildError
from .universal import universal

FLAGS = (
    "-std=c99", "-O2", "-g0", "-fPIC", "-fvisibility=hidden",
    "-ffp-contract=off",  # no fused multiply-add: one result whatever the machine
    "-fno-math-errno",    # sqrt is then an instruction; nobody reads errno
)  # fmt: skip


class CompileError(BuildError):
    """No compiler, no such platform, or a compiler that failed; the message says which."""


@dataclass(frozen=True)
class Platform:
    """Folder in an FMU by FMI version (two slices of Apple's share one in FMI 2), suffix, and target of ``zig cc``."""

    fmi2: str
    fmi3: str
    suffix: str
    target: str


PLATFORMS = (
    # the oldest glibc that zig is asked to link against decides where the library loads: this is RHEL 7's
    Platform("linux64", "x86_64-linux", ".so", "x86_64-linux-gnu.2.17"),
    # FMI 2.0.5 names platforms that it has no name for as FMI 3 does
    Platform("aarch64-linux", "aarch64-linux", ".so", "aarch64-linux-gnu.2.17"),
    Platform("win64", "x86_64-windows", ".dll", "x86_64-windows-gnu"),
    # without a version the least macOS would be the newest that zig knows
    Platform("darwin64", "x86_64-darwin", ".dylib", "x86_64-macos.11.0"),
    Platform("darwin64", "aarch64-darwin", ".dylib", "aarch64-macos.11.0"),
)
"""Platforms of ``--platforms all``."""


def host() -> Platform:
    """The platform of this Python. The target is empty: the compiler's own."""
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(platform.machine().lower(), platform.machine().lower())
    system, suffix = {"win32": ("windows", ".dll"), "darwin": ("darwin", ".dylib")}.get(sys.platform, ("linux", ".so"))
    bits = 64 if sys.maxsize > 2**32 else 32
    return Platform(f"{'win' if system == 'windows' else system}{bits}", f"{machine}-{system}", suffix, "")


def chosen(names: str) -> tuple[Platform, ...]:
    """The platforms that ``names`` asks for: ``host``, ``all``, or FMI 3 names with commas. Raises `CompileError`."""
    if names == "host":
        return (host(),)
    if names == "all":
        return PLATFORMS
    known = {p.fmi3: p for p in PLATFORMS}
    wanted = [name.strip() for name in names.split(",")]
    for name in wanted:
        if name not in known:
            raise CompileError(f"unknown platform {name}: there are host, all, {', '.join(known)}")
    return tuple(known[name] for name in wanted)


def members(name: str, platforms: Iterable[Platform], fmi: int) -> dict[str, list[Platform]]:
    """The libraries of an archive, each with the platforms whose slices it joins."""
    joined: dict[str, list[Platform]] = {}
    for each in platforms:
        folder = each.fmi2 if fmi == 2 else each.fmi3
        joined.setdefault(f"binaries/{folder}/{name}{each.suffix}", []).append(each)
    return joined


def libraries(
    sources: Mapping[str, bytes], name: str, platforms: Iterable[Platform], fmi: int
) -> dict[str, bytes]:
    """The libraries as members of the archive. Raises `CompileError`."""
    built = {}
    for member, targets in members(name, platforms, fmi).items():
        slices = [library(sources, name, target) for target in targets]
        built[member] = slices[0] if len(slices) == 1 else universal(slices)
    return built


def library(sources: Mapping[str, bytes], name: str, target: Platform) -> bytes:
    """The library of one platform."""
    output = f"{name}{target.suffix}"
    headers = tuple((file, text) for file, text in sorted(sources.items()) if file.endswith(".h"))
    objects = {
        # generated functions include none of the headers, which are not the same for all versions of FMI
        file.removesuffix(".c") + ".o": compiled(target, file, text, headers if b'#include "' in text else ())
        for file, text in sorted(sources.items()) if file.endswith(".c")
    }  # fmt: skip
    flags = ["-shared", "-s"]
    if target.suffix == ".dylib":
        flags += [f"-Wl,-install_name,@rpath/{output}"]  # zig's default is the path of the output
    elif target.suffix == ".so":
        flags += ["-Wl,-z,defs"]  # an undefined symbol is an error here, not at the user's
    data = output_of([*compiler(target), *flags, "-o", output, *objects, "-lm"], objects, output)
    return timeless(data) if target.suffix == ".dll" else data


def timeless(library: bytes) -> bytes:
    """A Windows library with its time of linking zeroed, for which zig's linker has no option: ``TimeDateStamp`` is 8
    bytes behind the signature to which the field at 0x3c points."""
    (header,) = struct.unpack_from("<I", library, 0x3C)
    if library[header : header + 4] != b"PE\0\0":
        raise CompileError("the compiler's output is no Windows library")
    return library[: header + 8] + bytes(4) + library[header + 12 :]


@cache
def compiled(target: Platform, file: str, text: bytes, headers: tuple[tuple[str, bytes], ...]) -> bytes:
    """The object file of one source; those of the runtime serve all units of a build."""
    output = file.removesuffix(".c") + ".o"
    return output_of([*compiler(target), *FLAGS, "-c", file, "-o", output], {file: text, **dict(headers)}, output)


def output_of(command: Sequence[str], files: Mapping[str, bytes], output: str) -> bytes:
    """What the command makes of ``files``. Raises `CompileError`."""
    with tempfile.TemporaryDirectory() as directory:
        for name, content in files.items():
            (Path(directory) / name).write_bytes(content)
        done = subprocess.run(command, cwd=directory, capture_output=True, text=True)
        if done.returncode:
            raise CompileError(f"{shlex.join(command)}\nended with {done.returncode}:\n{done.stderr.strip()[-4000:]}")
        return (Path(directory) / output).read_bytes()


def compiler(target: Platform) -> list[str]:
    """The command for a platform: ``$CC`` or ``cc`` for the host, ``zig cc`` for the others and where there is none."""
    named = os.environ.get("CC", "")
    own = shlex.split(named or "cc")
    if not target.target and (named or shutil.which(own[0])):
        if not shutil.which(own[0]):
            raise CompileError(f"CC = {named}: there is no program {own[0]}")
        return own
    if not importlib.util.find_spec("ziglang"):
        what = f"for {target.fmi3}" if target.target else "on this machine"
        raise CompileError(f"no C compiler {what}: pip install 'towage[native]' brings one (ziglang), or set CC")
    return [sys.executable, "-m", "ziglang", "cc", *(["-target", target.target] if target.target else [])]
