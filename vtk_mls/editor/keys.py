"""The keys of the editor: what they are called, what the legend says, what they do."""

from __future__ import annotations

# (what the legend has, text, keys as `name_of` names them, method of the editor, its argument);
# lines without a key are for the mouse.
KEYS = (
    ("drag", "move a handle in the plane of the view", (), "", None),
    ("Shift + drag", "along the normal of the surface", (), "", None),
    ("Ctrl + drag", "on the surface; beside handles: select several", (), "", None),
    ("Ctrl + click", "select one more", (), "", None),
    ("Ctrl + A", "select all of them", ("Ctrl+a",), "select_all", None),
    ("A", "add a handle on the surface under the mouse", ("a",), "add_under_mouse", None),
    ("X", "delete the selected handles", ("x", "Delete", "BackSpace"), "delete", None),
    ("F", "fix the selected handles, or free them", ("f",), "fix", None),
    ("Z   Y", "undo, redo (also with Ctrl)", ("z", "Ctrl+z"), "undo", None),
    ("", "", ("y", "Ctrl+y", "Ctrl+Z"), "redo", None),
    ("0", "put all handles back", ("0", "KP_0"), "reset", None),
    ("L", "lay a lattice of handles, again a finer one", ("l",), "lay_lattice", None),
    ("K", "kind of the map: rigid, affine, ...", ("k",), "change_kind", None),
    ("+   \N{MINUS SIGN}", "handles act more or less locally", ("+", "="), "change_alpha", 1.25),
    ("", "", ("-",), "change_alpha", 0.8),
    ("C", "cut by a plane, by half of one, not at all", ("c",), "change_cut", None),
    ("I", "another half of the plane", ("i",), "change_half", None),
    ("P", "cut along a line, open or closed: click, P again", ("p",), "incise", None),
    ("[   ]", "cuts part less or more sharply", ("[",), "change_nu", 0.8),
    ("", "", ("]",), "change_nu", 1.25),
    ("B", "show it before, and after", ("b",), "compare", None),
    ("M", "slices beside the 3-D view, or not", ("m",), "toggle_slices", None),
    ("V", "another look of the data", ("v",), "change_look", None),
    ("Space", "hide handles and texts", (" ",), "hide_handles", None),
    ("T", "how long maps and pictures take", ("t",), "time", None),
    ("R", "see all of it", ("r",), "reset_camera", None),
    ("S", "save all: handles, data, field, picture, script", ("s", "Ctrl+s"), "save", None),
    ("", "", ("Return", "KP_Enter"), "accept", None),
    ("", "", ("n",), "decline", None),
    ("Esc", "select none", ("Escape",), "deselect", None),
    ("H   ?", "hide or show this", ("h", "F1", "?"), "toggle_legend", None),
    ("Q", "quit; nothing is lost", ("q", "Ctrl+q"), "quit", None),
)


# What is written while the legend is not there, the last of it alone in narrow windows.
HINT = "Drag a handle, or beside it to turn.   C  cut   Z  undo   S  save", "H  all keys"


def legend():
    """(key, text) for each line of the legend."""
    return [(shown, text) for shown, text, *_ in KEYS if shown]


def actions():
    """(method, argument) by the name of the key."""
    return {name: (method, value) for _, _, names, method, value in KEYS for name in names}


def name_of(interactor):
    """The name of the key that a vtkRenderWindowInteractor has an event of.

    Characters are named by themselves, others as VTK does; with Ctrl before.
    """
    symbol, code = interactor.GetKeySym() or "", interactor.GetKeyCode()
    symbol = _CHARACTERS.get(symbol, symbol)
    if interactor.GetControlKey():
        letter = symbol.upper() if interactor.GetShiftKey() else symbol.lower()
        return f"Ctrl+{letter}" if len(symbol) == 1 else symbol
    if len(symbol) == 1:
        return symbol.lower()
    return symbol or (code or "").strip("\0")


_CHARACTERS = {
    "plus": "+",
    "KP_Add": "+",
    "equal": "=",
    "minus": "-",
    "KP_Subtract": "-",
    "space": " ",
    "bracketleft": "[",
    "bracketright": "]",
    "comma": ",",
    "period": ".",
    "question": "?",
}
