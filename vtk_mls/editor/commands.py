"""The commands of the editor, for keys, the legend and the page."""

from __future__ import annotations

from typing import NamedTuple


class Command(NamedTuple):
    """A method of `Editor`, its argument, its keys as of `keys.name_of`, and a line of the legend.

    A line without a method is about the mouse; a command without a line shares another one's.
    """

    line: str
    text: str
    method: str = ""
    keys: tuple = ()
    value: object = None


_ROWS = (
    ("drag", "move a handle in the plane of the view"),
    ("Shift + drag", "along the normal of the surface"),
    ("Ctrl + drag", "on the surface; beside handles: select several"),
    ("Ctrl + click", "add a handle to the selection, or remove it"),
    ("Ctrl + A", "select all handles", "select_all", ("Ctrl+a",)),
    ("A", "add a handle on the surface under the mouse", "add_under_mouse", ("a",)),
    ("X", "delete the selected handles", "delete", ("x", "Delete", "BackSpace")),
    ("F", "fix the selected handles, or free them", "fix", ("f",)),
    ("Z   Y", "undo, redo (also with Ctrl)", "undo", ("z", "Ctrl+z")),
    ("", "", "redo", ("y", "Ctrl+y", "Ctrl+Z")),
    ("G", "make rigid: the mesh or label under the mouse", "make_rigid", ("g",)),
    ("U", "let the selected handles turn, by a box", "turn_handle", ("u",)),
    ("D", "draw a curve handle: click its nodes, Return", "draw_curve", ("d",)),
    ("9", "straighten the selected curve", "straighten", ("9",)),
    ("W", "where it acts: a ball, or everywhere", "change_mask", ("w",)),
    ("E", "type the name or the position of a handle", "enter_values", ("e",)),
    ("0", "return all handles to rest", "reset", ("0", "KP_0")),
    ("L", "lattice of handles; again: a finer one", "lay_lattice", ("l",)),
    ("K", "kind of the map: rigid, ..., polynomial 2, 3", "change_kind", ("k",)),
    ("+   \N{MINUS SIGN}", "handles act more or less locally", "change_alpha", ("+", "="), 1.25),
    ("", "", "change_alpha", ("-",), 0.8),
    (",   .", "handles are met more or less exactly", "change_smoothing", (",",), 0.8),
    ("", "", "change_smoothing", (".",), 1.25),
    ("O", "fewer folds, by automatic steps, or one step", "prevent_folds", ("o",)),
    ("C", "cut by a plane, a part of it, not at all", "change_cut", ("c",)),
    ("I", "another part of the plane", "change_half", ("i",)),
    ("P", "cut along a line, open or closed: click, P again", "incise", ("p",)),
    ("[   ]", "influence fades less or more around cuts", "change_nu", ("[",), 0.8),
    ("", "", "change_nu", ("]",), 1.25),
    ("1 ... 4", "target: beside, fade, checkerboard, difference", "compare_by", ("1",), "beside"),
    ("", "", "compare_by", ("2",), "fade"),
    ("", "", "compare_by", ("3",), "checkerboard"),
    ("", "", "compare_by", ("4",), "difference"),
    ("Left   Right", "less or more of the target", "change_share", ("Left",), -1),
    ("", "", "change_share", ("Right",), 1),
    ("Up   Down", "jump to the previous or the next pair", "jump_by", ("Up",), -1),
    ("", "", "jump_by", ("Down",), 1),
    ("5", "leave the selected pairs out, or include them", "toggle_enabled", ("5",)),
    ("7", "refine the selected pairs by the images", "refine", ("7",)),
    ("6", "show or hide the table of pairs", "toggle_table", ("6",)),
    ("B", "show the data before and after", "compare", ("b",)),
    ("M", "show or hide slices", "toggle_slices", ("m",)),
    ("J", "deformed grid, change of volume, folds", "change_distortion", ("j",)),
    ("V", "next colors and opacities", "change_look", ("v",)),
    ("Space", "hide handles and texts", "hide_handles", (" ",)),
    ("T", "show computing times", "time", ("t",)),
    ("R", "fit the view to the data", "reset_camera", ("r",)),
    ("S", "save handles, data, field, picture, script", "save", ("s", "Ctrl+s")),
    ("", "", "accept", ("Return", "KP_Enter")),
    ("", "", "decline", ("n",)),
    ("Esc", "clear the selection", "deselect", ("Escape",)),
    ("H   ?", "show or hide this list", "toggle_legend", ("h", "F1", "?")),
    ("Q", "quit; unsaved edits are kept", "quit", ("q", "Ctrl+q")),
)
COMMANDS = [Command(*row) for row in _ROWS]
# The page has fields and buttons of its own for these.
WINDOW_METHODS = "quit", "toggle_legend", "enter_values", "toggle_table"
# Shown without the legend; narrow windows show the last part only.
HINT = "Drag a handle, or beside it to turn.   C  cut   Z  undo   S  save", "H  all keys"
TARGET_HINT = "Click a place on one side, then on the other.", "H  all keys"


def legend(without=()):
    """(keys, text) for each line of the legend, without those of some methods."""
    return [(row.line, row.text) for row in COMMANDS if row.line and row.method not in without]


def actions():
    """(method, argument) by the name of the key."""
    return {key: (row.method, row.value) for row in COMMANDS for key in row.keys}


def with_key(text, method):
    """A text with the first key of a method in parentheses, for a button."""
    key = next(row.keys[0] for row in COMMANDS if row.method == method)
    return f"{text} ({'Space' if key == ' ' else key.upper()})"
