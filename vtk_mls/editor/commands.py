"""The commands of the editor: keys of the window, and the menu of the page."""

from typing import NamedTuple


class Command(NamedTuple):
    """A method of `Editor`, its argument, and its keys as of `keys.name_of`."""

    text: str
    method: str
    keys: tuple
    value: object = None


MENUS = {
    "Edit": (
        Command("Undo", "undo", ("z", "Ctrl+z")),
        Command("Redo", "redo", ("y", "Ctrl+y", "Ctrl+Z")),
        Command("Save", "save", ("s", "Ctrl+s")),
        Command("Bring unsaved edits back, or end the curve", "accept", ("Return", "KP_Enter")),
        Command("Drop unsaved edits", "decline", ("n",)),
        Command("Quit; unsaved edits are kept", "quit", ("q", "Ctrl+q")),
    ),
    "Handles": (
        Command("Add a handle on the surface", "add_under_mouse", ("a",)),
        Command("Delete the selected handles", "delete", ("x", "Delete", "BackSpace")),
        Command("Fix the selected handles, or free them", "fix", ("f",)),
        Command("Turn the selected handles by a box", "turn_handle", ("u",)),
        Command("Select all handles", "select_all", ("Ctrl+a",)),
        Command("Clear the selection", "deselect", ("Escape",)),
        Command("Put all handles back", "reset", ("0", "KP_0")),
        Command("Lattice of handles; again: a finer one", "lay_lattice", ("l",)),
        Command("Make a mesh or a label rigid", "make_rigid", ("g",)),
        Command("Draw a curve handle", "draw_curve", ("d",)),
        Command("Straighten the selected curve", "straighten", ("9",)),
        Command("Act in a ball only, or everywhere", "change_mask", ("w",)),
    ),
    "Map": (
        Command("Next kind of map", "change_kind", ("k",)),
        Command("Handles act more locally", "change_alpha", ("+", "="), 1.25),
        Command("Handles act less locally", "change_alpha", ("-",), 0.8),
        Command("Meet handles more exactly", "change_smoothing", (",",), 0.8),
        Command("Meet handles less exactly", "change_smoothing", (".",), 1.25),
        Command("Fewer folds by automatic steps, or one step", "prevent_folds", ("o",)),
    ),
    "Cut": (
        Command("Next shape of the cut", "change_cut", ("c",)),
        Command("Another part of the plane", "change_half", ("i",)),
        Command("Cut along a line", "incise", ("p",)),
        Command("Influence fades less around cuts", "change_nu", ("[",), 0.8),
        Command("Influence fades more around cuts", "change_nu", ("]",), 1.25),
    ),
    "Landmarks": (
        Command("Data and target side by side", "compare_by", ("1",), "beside"),
        Command("Fade from the data to the target", "compare_by", ("2",), "fade"),
        Command("Checkerboard of data and target", "compare_by", ("3",), "checkerboard"),
        Command("Difference of data and target", "compare_by", ("4",), "difference"),
        Command("Less of the target", "change_share", ("Left",), -1),
        Command("More of the target", "change_share", ("Right",), 1),
        Command("Previous pair", "jump_by", ("Up",), -1),
        Command("Next pair", "jump_by", ("Down",), 1),
        Command("Leave the selected pairs out, or include them", "toggle_enabled", ("5",)),
        Command("Refine the selected pairs by the images", "refine", ("7",)),
    ),
    "View": (
        Command("Before and after", "compare", ("b",)),
        Command("Slices", "toggle_slices", ("m",)),
        Command("Deformed grid, change of volume, folds", "change_distortion", ("j",)),
        Command("Next colors and opacities", "change_look", ("v",)),
        Command("Hide or show handles", "hide_handles", (" ",)),
        Command("Computing times", "time", ("t",)),
        Command("Show everything", "reset_camera", ("r",)),
    ),
}
COMMANDS = [command for menu in MENUS.values() for command in menu]
MOUSE = (
    ("drag", "move a handle in the plane of the view; beside handles: turn the view"),
    ("Shift + drag", "move a handle along the normal of the surface"),
    ("Ctrl + drag", "move a handle on the surface; beside handles: select several"),
    ("Ctrl + click", "add a handle to the selection, or remove it"),
    ("wheel, pinch", "zoom"),
)
HINT = "Drag a handle, or beside it to turn.   C  cut   M  slices   Z  undo   S  save"
TARGET_HINT = "Click a place, then drag its landmark where it is wrong.   Z  undo   S  save"
_NAMES = {" ": "Space", "Escape": "Esc", "-": "\N{MINUS SIGN}"}


def actions():
    """(method, argument) by the name of the key."""
    return {key: (row.method, row.value) for row in COMMANDS for key in row.keys}


def key_of(command):
    """The first key of a command, for people."""
    key = command.keys[0]
    return _NAMES.get(key, key.title())


def with_key(text, method, value=None):
    """A text with the first key of each command of a method in parentheses, for a tool tip.

    A value selects the command that has it, if there is one.
    """
    rows = [row for row in COMMANDS if row.method == method]
    rows = [row for row in rows if row.value == value] or rows
    return f"{text} ({' '.join(map(key_of, rows))})"
