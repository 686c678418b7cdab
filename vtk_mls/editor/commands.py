"""The commands of the editor: keys, texts of the legend, and methods of `Editor`."""

from __future__ import annotations

# (key in the legend, text, names of keys as of `keys.name_of`, method of the editor, its argument);
# rows without names are about the mouse.
COMMANDS = (
    ("drag", "move a handle in the plane of the view", (), "", None),
    ("Shift + drag", "along the normal of the surface", (), "", None),
    ("Ctrl + drag", "on the surface; beside handles: select several", (), "", None),
    ("Ctrl + click", "add a handle to the selection, or remove it", (), "", None),
    ("Ctrl + A", "select all handles", ("Ctrl+a",), "select_all", None),
    ("A", "add a handle on the surface under the mouse", ("a",), "add_under_mouse", None),
    ("X", "delete the selected handles", ("x", "Delete", "BackSpace"), "delete", None),
    ("F", "fix the selected handles, or free them", ("f",), "fix", None),
    ("Z   Y", "undo, redo (also with Ctrl)", ("z", "Ctrl+z"), "undo", None),
    ("", "", ("y", "Ctrl+y", "Ctrl+Z"), "redo", None),
    ("G", "make rigid: the mesh or label under the mouse", ("g",), "make_rigid", None),
    ("U", "let the selected handles turn, by a box", ("u",), "turn_handle", None),
    ("D", "draw a curve handle: click its nodes, Return", ("d",), "draw_curve", None),
    ("9", "straighten the selected curve", ("9",), "straighten", None),
    ("W", "where it acts: a ball, or everywhere", ("w",), "change_mask", None),
    ("E", "type the name or the position of a handle", ("e",), "enter_values", None),
    ("0", "return all handles to rest", ("0", "KP_0"), "reset", None),
    ("L", "lattice of handles; again: a finer one", ("l",), "lay_lattice", None),
    ("K", "kind of the map: rigid, ..., polynomial 2, 3", ("k",), "change_kind", None),
    ("+   \N{MINUS SIGN}", "handles act more or less locally", ("+", "="), "change_alpha", 1.25),
    ("", "", ("-",), "change_alpha", 0.8),
    (",   .", "handles are met more or less exactly", (",",), "change_smoothing", 0.8),
    ("", "", (".",), "change_smoothing", 1.25),
    ("O", "fewer folds, by automatic steps, or one step", ("o",), "prevent_folds", None),
    ("C", "cut by a plane, by half of it, not at all", ("c",), "change_cut", None),
    ("I", "another half of the plane", ("i",), "change_half", None),
    ("P", "cut along a line, open or closed: click, P again", ("p",), "incise", None),
    ("[   ]", "influence fades less or more around cuts", ("[",), "change_nu", 0.8),
    ("", "", ("]",), "change_nu", 1.25),
    ("1 ... 4", "target: beside, fade, checkerboard, difference", ("1",), "compare_by", "beside"),
    ("", "", ("2",), "compare_by", "fade"),
    ("", "", ("3",), "compare_by", "checkerboard"),
    ("", "", ("4",), "compare_by", "difference"),
    ("Left   Right", "less or more of the target", ("Left",), "change_share", -1),
    ("", "", ("Right",), "change_share", 1),
    ("Up   Down", "jump to the previous or the next pair", ("Up",), "jump_by", -1),
    ("", "", ("Down",), "jump_by", 1),
    ("5", "leave the selected pairs out, or include them", ("5",), "toggle_enabled", None),
    ("7", "refine the selected pairs by the images", ("7",), "refine", None),
    ("8", "take the kind that predicts the pairs better", ("8",), "take_kind", None),
    ("6", "show or hide the table of pairs", ("6",), "toggle_table", None),
    ("B", "show the data before and after", ("b",), "compare", None),
    ("M", "show or hide slices", ("m",), "toggle_slices", None),
    ("J", "deformed grid, change of volume, folds", ("j",), "change_distortion", None),
    ("V", "next colors and opacities", ("v",), "change_look", None),
    ("Space", "hide handles and texts", (" ",), "hide_handles", None),
    ("T", "show computing times", ("t",), "time", None),
    ("R", "fit the view to the data", ("r",), "reset_camera", None),
    ("S", "save handles, data, field, picture, script", ("s", "Ctrl+s"), "save", None),
    ("", "", ("Return", "KP_Enter"), "accept", None),
    ("", "", ("n",), "decline", None),
    ("Esc", "clear the selection", ("Escape",), "deselect", None),
    ("H   ?", "show or hide this list", ("h", "F1", "?"), "toggle_legend", None),
    ("Q", "quit; unsaved edits are kept", ("q", "Ctrl+q"), "quit", None),
)
# Shown without the legend; narrow windows show the last part only.
HINT = "Drag a handle, or beside it to turn.   C  cut   Z  undo   S  save", "H  all keys"

TARGET_HINT = "Click a place on one side, then on the other.", "H  all keys"


def legend():
    """(key, text) for each line of the legend."""
    return [(key, text) for key, text, *_ in COMMANDS if key]


def actions():
    """(method, argument) by the name of the key."""
    return {name: (method, value) for _, _, names, method, value in COMMANDS for name in names}
