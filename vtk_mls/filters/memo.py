"""What a filter keeps between its executions."""

from __future__ import annotations


class Memo:
    """The last value of something, kept while what it was made of stays equal."""

    def __init__(self):
        self._kept = None

    def of(self, state, make):
        """The value for `state`: what `make()` returns, unless it is that of the last state."""
        if self._kept is None or self._kept[0] != state:
            self._kept = state, make()
        return self._kept[1]
