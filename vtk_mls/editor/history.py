"""Undo and redo without a limit."""


class History:
    """States that were, one that is, and those that were taken back."""

    def __init__(self, state):
        self._past, self._future = [], []
        self.state = state

    def push(self, state):
        """Go on to a new state; what was taken back is gone."""
        self._past.append(self.state)
        self._future.clear()
        self.state = state

    def undo(self):
        """Go back; whether there was a state to go back to."""
        return self._step(self._past, self._future)

    def redo(self):
        """Go forth again; whether there was one."""
        return self._step(self._future, self._past)

    def _step(self, source, target):
        if not source:
            return False
        target.append(self.state)
        self.state = source.pop()
        return True
