"""How long a silent child process is waited for.

On a machine that is busy with other things a second of work takes many. What counts is therefore
the processor time of the child, where the system tells it.
"""

from __future__ import annotations

import os
import time
from contextlib import suppress

_SPENT = 2.0  # of the processors' time, as a multiple of the seconds that a step may take
_AT_REST = 0.01  # a child that gets less of a processor waits for something
_LONGEST = 20.0  # of the clock's time, likewise
_UNTOLD = 2.5  # of the clock's time where the system does not tell the processors'


class Patience:
    """Says whether a child that is silent works, or will never answer.

    Parameters
    ----------
    pid : int
        Of the child.
    seconds : float
        That a step may take on a machine that has nothing else to do.
    """

    def __init__(self, pid, seconds):
        self._pid, self.seconds = pid, seconds
        self.begin()

    def begin(self):
        """The child has spoken."""
        self._start = time.monotonic()
        self._first = self._before = _processor_seconds(self._pid)

    def ends(self):
        """Whether it has ended; asked each `seconds` of silence."""
        now, before = _processor_seconds(self._pid), self._before
        self._before = now
        if now is None or before is None:
            return self.waited > _UNTOLD * self.seconds
        return (
            now - before < _AT_REST * self.seconds
            or now - self._first > _SPENT * self.seconds
            or self.waited > _LONGEST * self.seconds
        )

    @property
    def waited(self):
        """Seconds since the child has spoken."""
        return time.monotonic() - self._start


def _processor_seconds(pid):
    """What a process has spent so far; None where the system does not tell."""
    with suppress(OSError, ValueError, IndexError, AttributeError):
        with open(f"/proc/{pid}/stat") as file:
            fields = file.read().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return None
