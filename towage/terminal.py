"""What the user reads on a terminal: no text of a scene or of a foreign unit may act on it."""

from __future__ import annotations

import io
import sys
import unicodedata

INTERRUPTED = 130
"""Exit code after a signal that ends a job: 128 + SIGINT, as shells have it."""
BUG = 70
"""Exit code of a defect: EX_SOFTWARE of sysexits.h."""
LONGEST = 2000
"""Letters of a message that are shown."""


def escaped(text: str, keep: str = "\n\t", longest: int = LONGEST) -> str:
    """The text with control characters, and those that turn the direction of writing, spelled out as in Python, but for those
    in ``keep``; the middle of one longer than ``longest`` is left out, which is said."""
    if len(text) > longest:
        half = longest // 2
        text = f"{text[:half]} [... {len(text) - 2 * half} letters ...] {text[-half:]}"
    if text.isascii() and text.isprintable():
        return text
    return "".join(
        letter
        if letter in keep or unicodedata.category(letter) not in ("Cc", "Cf", "Cs", "Zl", "Zp")
        else spelled(letter)
        for letter in text
    )


def spelled(letter: str) -> str:
    """A letter as in the source of a program, as \\x1b."""
    return letter.encode("unicode_escape").decode("ascii")


class Plain(io.TextIOWrapper):
    """A text stream in which tabs and ends of lines alone act, whoever writes to it; what its encoding lacks is spelled."""

    @classmethod
    def of(cls, stream: io.TextIOWrapper) -> Plain:
        """In the place of a stream, which is of no use afterwards."""
        encoding, lines = stream.encoding, stream.line_buffering
        return cls(stream.detach(), encoding=encoding, errors="backslashreplace", line_buffering=lines)

    def write(self, text: str) -> int:
        """As that of a stream."""
        return super().write(escaped(text, longest=sys.maxsize))


def tell(text: str) -> None:
    """A remark on stderr."""
    print(escaped(text), file=sys.stderr, flush=True)


def complain(message: str) -> None:
    """An error on stderr."""
    print(f"towage: error: {escaped(message)}", file=sys.stderr, flush=True)
