"""What is not saved yet: kept while one edits, and offered by the next session."""

from __future__ import annotations

import time


class Unsaved:
    """Knows which state is saved, and keeps others in drafts.

    Parameters
    ----------
    drafts : Drafts or None
        Nothing is kept without.
    state : State
        At first, which needs no saving.
    """

    def __init__(self, drafts, state):
        self._drafts, self._saved, self._offered = drafts, state, None

    def keep(self, state):
        """Keep a state, unless it is saved.

        Raises
        ------
        OSError
            Naming the file.
        """
        if self._drafts is None:
            return
        if state is self._saved:
            self._drafts.forget()
        else:
            self._drafts.keep(state)

    def note_saved(self, state):
        """Keep nothing any more, for this state is saved."""
        self._saved = state
        if self._drafts is not None:
            self._drafts.forget_all()

    def offer(self):
        """A sentence that offers what another session has left; empty if there is nothing."""
        found = self._drafts and self._drafts.found()
        if not found:
            return ""
        self._offered, when = found
        text = time.strftime("%d %B, %H:%M", time.localtime(when))
        return f"{len(self._offered)} handles of {text} were not saved: Return brings them back."

    def accepted(self):
        """The state that was offered, once; None if there is none."""
        state, self._offered = self._offered, None
        return state
