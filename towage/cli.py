"""The command line: a table of commands, and what an error, an interruption or a bug looks like from outside.

A command is a module with ``HELP``, ``add_arguments(parser)`` and ``execute(arguments) -> exit code``; it is cheap to
import, since ``towage --help`` imports all of them, and imports what is heavy when it is executed.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import io
import os
import sys
from collections.abc import Sequence

from towage import __version__
from towage.errors import FileError, TowageError
from towage.files import reason
from towage.terminal import BUG, INTERRUPTED, Plain, complain

COMMANDS = {
    "run": "towage.commands.run",
    "recover": "towage.commands.recover",
    "verify-result": "towage.commands.verify_result",
    "report": "towage.commands.report",
    "check": "towage.commands.check",
    "validate": "towage.commands.validate",
    "export": "towage.commands.export",
    "import": "towage.commands.import_system",
    "list": "towage.commands.list",
    "verify": "towage.commands.verify",
    "stability": "towage.commands.stability",
    "response": "towage.commands.response",
    "route": "towage.commands.route",
    "sweep": "towage.commands.sweep",
    "operability": "towage.commands.operability",
    "simplest": "towage.commands.simplest",
    "reproduce": "towage.commands.reproduce",
    "new": "towage.commands.new",
    "vet": "towage.commands.vet",
}
EXIT_CODES = """exit codes:
  0    done, whatever the verdict
  1    verify: a case is over its tolerance; reproduce: a printed number differs without a reason
  2    a scene, an FMU or the command line is refused
  3    a run failed; what it recorded is kept
  4    sweep, operability: some runs were not done, the others are complete
  70   a defect of towage
  130  interrupted; what was recorded is kept
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command in ``arguments`` (default: the process's own) and return its exit code."""
    if sys.stderr is None:  # closed by who started this process
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115
    if sys.stdout is None:
        complain("standard output is closed: give it a file or a terminal, or /dev/null")
        return FileError.exit_code
    if isinstance(sys.stderr, io.TextIOWrapper):  # a title must not end a run on an ASCII terminal
        sys.stderr.reconfigure(errors="backslashreplace")
    if type(sys.stdout) is io.TextIOWrapper:
        sys.stdout = Plain.of(sys.stdout)
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
    except BrokenPipeError:  # the reader of stdout, as head, had enough
        _no_more_output()
        return 1
    except OSError as error:  # of the machine, not of towage
        complain(f"{error.filename or 'standard output'}: {reason(error)}")
        _no_more_output()
        return FileError.exit_code
    except Exception as error:
        import traceback

        traceback.print_exc()
        complain(
            f"{type(error).__name__}: this is a defect of towage {__version__}, not of your scene. Please report it "
            "with the lines above, the command and the scene file."
        )
        return BUG
    return code


def _no_more_output() -> None:
    """Keep the interpreter from flushing a stream that cannot be written."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


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
