"""A process that reads forecasts as `towage.process.child.Child`, forked instead of started: thousands of files a minute."""

from __future__ import annotations

import importlib
import json
import os
import signal
from typing import Any

from towage.process.child import Died


class Forked:
    """Answers as ``main()`` of the module does, with the libraries that this process has loaded."""

    def __init__(self, module: str) -> None:
        served = importlib.import_module(module)
        (asked, self._ask), (self._answered, answer) = os.pipe(), os.pipe()
        self._pid = os.fork()
        if not self._pid:
            os.dup2(asked, 0)
            os.dup2(answer, 1)
            os.closerange(3, 64)
            served.main()
            os._exit(0)
        os.close(asked)
        os.close(answer)
        self._lines = os.fdopen(self._answered, "rb")

    def ask(self, request: bytes, report: object, timeout: float) -> dict[str, Any]:
        """As `Child.ask`."""
        os.write(self._ask, request)
        line = self._lines.readline()
        if line:
            answer: dict[str, Any] = json.loads(line)
            return answer
        _, status = os.waitpid(self._pid, 0)
        self._pid = 0
        death = Died("died")
        death.code = os.waitstatus_to_exitcode(status)
        raise death

    def end(self) -> None:
        """As `Child.end`."""
        if self._pid:
            os.kill(self._pid, signal.SIGKILL)
            os.waitpid(self._pid, 0)
            self._pid = 0

    def __enter__(self) -> Forked:
        return self

    def __exit__(self, *raised: object) -> None:
        self.end()
        os.close(self._ask)
        self._lines.close()
