"""Edits of the panel: a name and a value from the page."""

import math
from contextlib import suppress

from vtk_mls.editor.commands import COMMANDS
from vtk_mls.editor.slices import PANES
from vtk_mls.model.cuts import BY_NUMBERS
from vtk_mls.model.options import OPTIONS
from vtk_mls.web import panel_values

# Commands by method and argument; the page begins long tasks otherwise, and only windows quit.
_OTHERS = "save", "refine", "quit"
_COMMANDS = [(row.method, row.value) for row in COMMANDS if row.method not in _OTHERS]
# Instead of commands for the place under the mouse, which is over a button.
_CLICKED = {"add_under_mouse": "add_clicked", "make_rigid": "make_clicked_rigid"}
_OPTIONS = {option.name: option for option in OPTIONS if option.section != "computing"}
_MAX_MESSAGE, _MAX_NAME = 300, 100  # characters
_PAIR_EDITS = "enable", "jump", "delete_pair"
_ROW_EDITS = *_PAIR_EDITS, "name", "position", "rest"
_CUTS = "none", *BY_NUMBERS


def apply(session, name, value=None):
    """Make an edit; in the editor's thread.

    `name` is a method of `COMMANDS`, an option of the map, or as in `_apply`; `value` is one of
    JSON. The page shows a message about an invalid one.
    """
    editor = session.editor
    if (name, value) in _COMMANDS:
        editor.do(_CLICKED.get(name, name), value)
        return
    editor.finish()
    editor.say("")
    # edits that the page never sends are ignored
    with editor.document.reporting_errors(), suppress(LookupError, OverflowError):
        _apply(editor, name, value)


def _apply(editor, name, value):
    option = _OPTIONS.get(name)
    if option and not option.choices:
        _set_number(editor, option, value)
    elif option and value in option.choices:
        if value != getattr(editor.state, name):
            editor.change(editor.state.changed(**{name: value}))
    elif name == "cut" and value in _CUTS:
        _set_cut(editor, value)
    elif name == "preset":
        editor.set_look(int(value))
    elif name == "step" and 0 <= int(value) < len(editor.saver.times):
        editor.show_step(int(value))
    elif name == "distortion":
        editor.set_distortion(int(value))
    elif name == "select":
        count = len(editor.state.grips)
        editor.select(sorted({int(row) for row in value if 0 <= int(row) < count}))
    elif name == "say":
        editor.say(str(value)[:_MAX_MESSAGE])
    elif name == "pane" and value in PANES:
        editor.show_pane(value)
    elif name == "target_grid":
        editor.saver.uses_target_grid = bool(value)
    elif name == "comparison":
        editor.compare_by(value)
    elif name == "share":
        editor.set_comparison(share=float(value))
    elif name in _ROW_EDITS:
        row, *values = value
        _edit_row(editor, name, int(row), values)


def _set_number(editor, option, value):
    number = _number(value)
    low, high, _ = option.slider or (-math.inf, math.inf, None)
    if number is None or not (low <= number <= high and option.is_valid(number)):
        expected = f"a number from {low:g} to {high:g}" if option.slider else option.expected
        editor.say(f"`{option.name}` must be {expected}.")
    elif number != getattr(editor.state, option.name):
        editor.change(editor.state.changed(**{option.name: option.checked(number)}))


def _set_cut(editor, shape):
    """Step through the editor's shapes until the cut has this one."""
    for _ in _CUTS:
        if panel_values.shape_of(editor.state) == shape:
            return
        editor.change_cut()


def _edit_row(editor, name, row, values):
    """Edit a pair of landmarks, or a grip."""
    if not 0 <= row < len(editor.state if name in _PAIR_EDITS else editor.state.grips):
        return
    if name == "enable":
        editor.set_enabled([row], bool(values[0]))
    elif name == "jump":
        editor.jump_to(row)
    elif name == "delete_pair":
        editor.delete_pairs([row])
    elif name == "name":
        editor.set_name(row, str(values[0])[:_MAX_NAME].strip())
    else:
        position = [_number(text) for text in values]
        if len(position) != 3 or None in position:
            editor.say("A position is three numbers.")
        else:
            (editor.set_position if name == "position" else editor.set_rest)(row, position)


def _number(value):
    """A finite number from a text; None if it is not one."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        return None
    return number if math.isfinite(number) else None
