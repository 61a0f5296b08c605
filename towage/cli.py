"""The command line: a table of commands, and what an error, an interruption or a bug looks like from outside.

A command is a module with ``HELP``, ``add_arguments(parser)`` and ``execute(arguments) -> exit code``; it is cheap to
import, since ``towage --help`` imports all of them, and imports what is heavy when it is executed.
"""

from __future__ import annotations

import argparse
import importlib
import io
import os
import sys
from collections.abc import Sequence

from towage import __version__
from towage.errors import TowageError

COMMANDS = {
    "run": "towage.commands.run",
    "report": "towage.commands.report",
    "check": "towage.commands.check",
    "validate": "towage.commands.validate",
    "export": "towage.commands.export",
    "list": "towage.commands.list",
    "verify": "towage.commands.verify",
    "stability": "towage.commands.stability",
    "response": "towage.commands.response",
    "route": "towage.commands.route",
    "sweep": "towage.commands.sweep",
    "new": "towage.commands.new",
    "vet": "towage.commands.vet",
}
INTERRUPTED = 130
"""128 + SIGINT, as shells have it."""
BUG = 70
"""EX_SOFTWARE of sysexits.h."""
EXIT_CODES = """exit codes:
  0    done, whatever the verdict
  1    verify: a case is over its tolerance
  2    a scene, an FMU or the command line is refused
  3    a run failed; what it recorded is kept
  4    sweep: some runs were not done, the others are complete
  70   a defect of towage
  130  interrupted; what was recorded is kept
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command in ``arguments`` (default: the process's own) and return its exit code."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a title must not end a run on an ASCII terminal
    parsed = parser().parse_args(arguments)
    try:
        code: int = parsed.execute(parsed)
        sys.stdout.flush()
    except TowageError as error:
        complain(str(error))
        return error.exit_code
    except KeyboardInterrupt:
        complain("interrupted")
        return INTERRUPTED
    except BrokenPipeError:  # the reader of stdout, as head, had enough; keep the interpreter from flushing again
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except Exception as error:
        import traceback

        traceback.print_exc()
        complain(
            f"{type(error).__name__}: this is a defect of towage {__version__}, not of your scene. Please report it "
            "with the lines above, the command and the scene file."
        )
        return BUG
    return code


def complain(message: str) -> None:
    """An error on stderr."""
    print(f"towage: error: {message}", file=sys.stderr, flush=True)


def parser() -> argparse.ArgumentParser:
    """The parser of all commands."""
    top = argparse.ArgumentParser(
        prog="towage",
        description="Couples FMUs of ships, lines and what hangs from them, and judges every run.",
        epilog=f"example:\n  towage run sea_cliff --out out\n\n{EXIT_CODES}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    top.add_argument("-V", "--version", action="version", version=f"towage {__version__}")
    commands = top.add_subparsers(metavar="COMMAND", required=True)
    for name, module in COMMANDS.items():
        command = importlib.import_module(module)
        sub = commands.add_parser(
            name,
            help=command.HELP,
            description=f"{command.HELP[0].upper()}{command.HELP[1:]}.",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        command.add_arguments(sub)
        sub.set_defaults(execute=command.execute)
    return top
