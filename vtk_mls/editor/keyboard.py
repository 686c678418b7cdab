"""The keys that are pressed, as calls of the editor's methods."""

from __future__ import annotations

from vtk_mls.editor import keys
from vtk_mls.editor.mouse import PRIORITY


class Keyboard:
    """Does in an editor what the keys of an interactor say."""

    def __init__(self, interactor, editor):
        self._interactor, self._editor, self._actions = interactor, editor, keys.actions()
        self._tags = {
            event: interactor.AddObserver(event, what, PRIORITY)
            for event, what in (("KeyPressEvent", self._press), ("CharEvent", self._abort))
        }

    def detach(self):
        """Hear no more events."""
        for tag in self._tags.values():
            self._interactor.RemoveObserver(tag)

    def _press(self, interactor, event):
        action = self._actions.get(keys.name_of(interactor))
        if action is not None:
            self._abort(interactor, event)
            self._editor.do(*action)

    def _abort(self, interactor, event):
        """Keep an event from interactor styles, which have their own meanings for keys."""
        interactor.GetCommand(self._tags[event]).SetAbortFlag(True)
