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
        self._drafts, self._saved = drafts, state
        self._found = drafts and drafts.found()

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
        """Keep nothing of this session any more, for this state is saved; nor what it replaces."""
        self._saved = state
        if self._drafts is not None:
            self._drafts.forget_all()
            if self._found:
                self._found = self._drafts.found()

    @property
    def offered(self):
        """The newest state of another session that was not taken yet; None if there is none."""
        return self._found[0] if self._found else None

    def offer(self):
        """A sentence that offers it; empty if there is nothing."""
        if not self._found:
            return ""
        text = time.strftime("%d %B, %H:%M", time.localtime(self._found[1]))
        return (
            f"{len(self.offered)} handles of {text} were not saved: Return brings them back, "
            "N drops them."
        )

    def take(self):
        """Offer it no more, but what was left before it; it is gone when this session saves."""
        self._drafts.take()
        self._found = self._drafts.found()

    def drop(self):
        """Never offer it again, but what was left before it."""
        self._drafts.drop()
        self._found = self._drafts.found()
