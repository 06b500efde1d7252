"""What an engine prints: a pipe that the guard empties all the time, keeping the end of it."""

from __future__ import annotations

import os
import re
from contextlib import suppress

KEPT = 4000
LONGEST_WORDS = 300
"""Characters that are quoted."""
AT_ONCE = 1 << 16
READS = 64
"""A flood is read in so many pieces at most before the guard looks at other things."""


class Output:
    """The pipe behind the engine's standard output and standard error, and the last that came through it."""

    def __init__(self) -> None:
        self.reading, self.writing = os.pipe()
        os.set_blocking(self.reading, False)
        self.last = b""

    def fileno(self) -> int:
        """Return the descriptor to read from."""
        return self.reading

    def drain(self) -> None:
        """Take what is there."""
        with suppress(BlockingIOError):
            for _ in range(READS):
                data = os.read(self.reading, AT_ONCE)
                self.last = (self.last + data)[-KEPT:]
                if len(data) < AT_ONCE // 2:
                    return

    def forget(self) -> None:
        """Take what is there, and forget it."""
        self.drain()
        self.last = b""

    def last_words(self) -> str:
        """What was printed last, on one printable line: its beginning, which names an error, and its end."""
        self.drain()
        text = "".join(c if c.isprintable() or c == "\n" else "\ufffd" for c in self.last.decode("utf-8", "replace"))
        text = re.sub("\ufffd+", "\ufffd", text)
        line = " | ".join(line.strip() for line in text.splitlines() if line.strip())
        first, rest = LONGEST_WORDS * 3 // 4, LONGEST_WORDS // 4
        return line if len(line) <= LONGEST_WORDS else f"{line[:first]} … {line[-rest:]}"
