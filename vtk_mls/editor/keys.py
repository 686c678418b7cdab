"""The keys of a window call commands of the editor."""

from vtk_mls.editor.commands import actions
from vtk_mls.editor.mouse import Observer

_NAMES = "plus KP_Add equal minus KP_Subtract space bracketleft bracketright comma period question"
_CHARACTERS = dict(zip(_NAMES.split(), "++=-- [],.?"))


def name_of(interactor):
    """The name of the key in the current event of a vtkRenderWindowInteractor.

    A character is its own name, other keys have the names of VTK; with Ctrl, "Ctrl+" before it.
    """
    symbol, code = interactor.GetKeySym() or "", interactor.GetKeyCode()
    symbol = _CHARACTERS.get(symbol, symbol)
    if interactor.GetControlKey():
        letter = symbol.upper() if interactor.GetShiftKey() else symbol.lower()
        return f"Ctrl+{letter}" if len(symbol) == 1 else symbol
    if len(symbol) == 1:
        return symbol.lower()
    return symbol or (code or "").strip("\0")


class Keyboard(Observer):
    """Calls the methods of an editor for the keys of an interactor."""

    def __init__(self, interactor, editor):
        self._editor, self._actions = editor, actions()
        handlers = {"KeyPressEvent": self._press, "CharEvent": lambda _, event: self._abort(event)}
        super().__init__(interactor, handlers)

    def _press(self, interactor, event):
        action = self._actions.get(name_of(interactor))
        if action is not None:
            self._abort(event)
            self._editor.do(*action)
