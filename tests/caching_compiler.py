"""A C compiler that compiles nothing twice: ``caching_compiler.py STORE CC ARGUMENTS...`` does what ``CC ARGUMENTS...`` does,
and keeps what came of every command that compiles. The key is the preprocessed source, the command and the compiler's own
description of itself, so that a result is what the compiler would have made. What no test asked for in a week goes."""

import contextlib
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import time

WEEK = 7 * 24 * 3600


def main(store: str, compiler: str, *arguments: str) -> int:
    """Returns the exit code of the compiler, which is run if it has to be."""
    command = [compiler, *arguments]
    sources = [a for a in arguments if a.endswith(".c")]
    if not sources or "-o" not in arguments:
        return subprocess.call(command)
    place = arguments.index("-o")
    output, rest = arguments[place + 1], [*arguments[:place], *arguments[place + 2 :]]
    # with debugging information the places of the sources are in the result too
    lines = [] if "-g" in rest else ["-P"]
    text = subprocess.run(
        [compiler, "-E", *lines, *(a for a in rest if a != "-c" and not a.startswith("-l"))], capture_output=True
    )
    if text.returncode:
        return subprocess.call(command)
    key = hashlib.sha256(text.stdout)
    for part in (version(compiler), *(a for a in rest if not a.endswith(".c") and not a.startswith("-I"))):
        key.update(part.encode() + b"\0")
    kept = os.path.join(store, key.hexdigest())
    if os.path.exists(kept):
        os.utime(kept)
        shutil.copy(kept, output)
        return 0
    code = subprocess.call(command)
    if code == 0:
        handle, name = tempfile.mkstemp(dir=store)
        os.close(handle)
        shutil.copy(output, name)
        os.replace(name, kept)
    return code


def version(compiler: str) -> str:
    """Machine, and path, size and time of the program, which tell one compiler from the next."""
    path = os.path.realpath(shutil.which(compiler) or compiler)
    status = os.stat(path)
    return f"{os.uname().nodename} {path} {status.st_size} {status.st_mtime_ns}"


def forget(store: str) -> None:
    """Remove what was not asked for in a week."""
    for entry in os.scandir(store):
        with contextlib.suppress(FileNotFoundError):  # another run was faster
            if time.time() - entry.stat().st_mtime > WEEK:
                os.unlink(entry.path)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
