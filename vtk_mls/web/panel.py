"""The panel beside the picture: map, cut, handles, colors, files."""

from trame.widgets import html
from trame.widgets import vuetify3 as v
from trame_client.widgets.core import HtmlElement

from vtk_mls.editor.commands import with_key
from vtk_mls.editor.distortion import MODES
from vtk_mls.model import options
from vtk_mls.model.cuts import BY_NUMBERS
from vtk_mls.web.controls import select, slider, small_button, text_field, toggle, wide_button
from vtk_mls.web.transfers import MAX_DATA_BYTES, MAX_HANDLE_BYTES

_CUTS = [(name, name.capitalize()) for name in ("none", *BY_NUMBERS)]
_EDGED = [name for name, shape in BY_NUMBERS.items() if len(shape.fields) > 2]
_IS_NOTHING_SELECTED = "selected.length === 0"
# Methods of the editor whose keys change an option.
_METHODS = {
    "kind": "change_kind",
    "alpha": "change_alpha",
    "smoothing": "change_smoothing",
    "steps": "prevent_folds",
    "nu": "change_nu",
}


def build(edit, begin):
    """Build the panel; `edit` and `begin` as of `page_layout.build`."""
    with html.Div(classes="pa-4 d-flex flex-column", style="gap: 14px;"):
        _section("Map")
        _options(edit, "map")
        _section("Cut")
        _cut(edit)
        _section("Handles")
        _handles(edit)
        _shapes(edit)
        _section("Look")
        with html.Div(v_if="times.length > 1", title="The step that is shown, and saved"):
            items = ("times.map((title, value) => ({ title, value }))",)
            select("step", "Time step: time", items, edit)
        with html.Div(title=with_key("Colors and opacities", "change_look")):
            items = ("presets.map((title, value) => ({ title, value }))",)
            select("preset", "Colors and opacities", items, edit)
        with html.Div(title=with_key("How the deformation changes space", "change_distortion")):
            items = [{"title": text.capitalize(), "value": i} for i, text in enumerate(MODES)]
            select("distortion", "Show of the deformation", ("distortions", items), edit)
        _section("Files")
        _files(edit, begin)


def _section(title):
    html.Div(title, classes="mls-section mt-2")


def _column(gap):
    """Options of a Div whose contents are below each other."""
    return {"classes": "d-flex flex-column", "style": f"gap: {gap}px;"}


def _command(edit, text, icon, name, tip, **options):
    """A wide button that calls a method of the editor, with its key in the tool tip."""
    wide_button(text, icon, (edit, f"['{name}']"), title=with_key(tip, name), **options)


def _options(edit, section):
    for option in options.OPTIONS:
        if option.section == section:
            name, *values = option.needs or ("1", 1)
            # shown while it has an effect
            with html.Div(title=_tool_tip(option), v_if=f"{values}.includes({name})"):
                if option.slider:
                    _slider(edit, option)
                elif option.choices:
                    _select(edit, option)
                else:
                    change = edit, f"['{option.name}', $event.target.value]"
                    text_field(option.name, option.label, change)


def _tool_tip(option):
    text = " ".join(option.help.split())
    return with_key(text, _METHODS[option.name]) if option.name in _METHODS else text


def _select(edit, option):
    labels = option.choice_labels or option.choices
    items = [{"title": title, "value": value} for title, value in zip(labels, option.choices)]
    select(option.name, option.label, (f"{option.name}_choices", items), edit)


def _slider(edit, option):
    with html.Div(classes="d-flex text-body-2"):
        html.Span(option.label)
        v.VSpacer()
        html.Span(f"{{{{ Number({option.name}).toFixed(2) }}}}", classes="text-primary")
    slider(option.name, option.label, option.slider, edit)


def _cut(edit):
    toggle("cut", _CUTS, edit, "change_cut")
    tip, is_shown = "Turn the cut about its normal, or let it grow", f"{_EDGED}.includes(cut)"
    _command(edit, "Another part", "mdi-rotate-3d-variant", "change_half", tip, v_if=is_shown)
    tip = "Click on the surface, then here again"
    _command(edit, "Draw a line and cut along it", "mdi-content-cut", "incise", tip)
    with html.Div(v_if="cut !== 'none' || has_lines", **_column(14)):
        _options(edit, "cut")


def _handles(edit):
    _table(edit)
    _selected(edit)
    with html.Div(classes="d-flex flex-wrap", style="gap: 8px;"):
        for text, icon, name, tip, condition in (
            ("Add", "mdi-plus", "add_under_mouse", "Click on the surface or in a slice", ""),
            ("Fix", "mdi-pin-outline", "fix", "Fix, or free", _IS_NOTHING_SELECTED),
            ("Turn", "mdi-rotate-orbit", "turn_handle", "By a box", _IS_NOTHING_SELECTED),
            ("Delete", "mdi-delete-outline", "delete", "Delete", _IS_NOTHING_SELECTED),
            ("Select all", "mdi-select-all", "select_all", "Select all handles", ""),
            ("Deselect", "mdi-select-off", "deselect", "Clear the selection", _IS_NOTHING_SELECTED),
            ("Lattice", "mdi-grid", "lay_lattice", "Lay a lattice, again a finer one", ""),
        ):
            small_button(
                text,
                icon,
                (edit, f"['{name}']"),
                classes="flex-grow-1",
                disabled=(condition or "false",),
                title=with_key(tip, name),
            )


def _selected(edit):
    """Fields of the one selected handle: name, rest and present position."""
    with html.Div(v_if="selected.length === 1 && rows[selected[0]]", **_column(8)):
        change = edit, "['name', [selected[0], $event.target.value]]"
        text_field("rows[selected[0]].name", "Name", change, v_if="rows[selected[0]].is_point")
        _position(edit, "at", "position", "")
        with html.Div(v_if="!rows[selected[0]].is_mask"):
            _position(edit, "rest", "rest", " at rest")


def _position(edit, column, name, suffix):
    """Three fields for a position in a column of the table."""
    with html.Div(classes="d-flex", style="gap: 8px;"):
        for axis, letter in enumerate("xyz"):
            coordinates = [f"rows[selected[0]].{column}[{i}]" for i in range(3)]
            values = ["selected[0]", *coordinates]
            values[1 + axis] = "$event.target.value"
            change = edit, f"['{name}', [{', '.join(values)}]]"
            text_field(coordinates[axis], letter + suffix, change)


def _shapes(edit):
    tip = "Then move and turn it by its box"
    _command(edit, "Make rigid: click on a mesh or label", "mdi-bone", "make_rigid", tip)
    text = "{{ is_drawing ? 'End the curve' : 'Draw a curve' }}"
    tip = "Click its nodes on the surface or in slices"
    _command(edit, text, "mdi-vector-polyline", "draw_curve", tip)
    text, tip = (
        "Straighten the curve",
        "To a line of its length: the selected curve, or the only one",
    )
    _command(edit, text, "mdi-ray-start-end", "straighten", tip, v_if="has_curve")
    text = "{{ has_mask ? 'Act everywhere' : 'Act in a ball only' }}"
    tip = "A ball around the selected handle; drag its violet points"
    _command(edit, text, "mdi-circle-expand", "change_mask", tip)


def _table(edit):
    """Rows of handles; a click selects, Ctrl+click adds to the selection."""
    rows = v.VVirtualScroll(items=("rows",), height=216, item_height=30, classes="mls-rows")
    row = "{ 'mls-row': true, 'is-selected': selected.includes(item.row) }"
    has_modifier = "(selects_several || $event.ctrlKey || $event.metaKey)"
    other_rows = "selected.filter(i => i !== item.row)"
    toggled = f"selected.includes(item.row) ? {other_rows} : [...selected, item.row]"
    click = edit, f"['select', {has_modifier} ? ({toggled}) : [item.row]]"
    with rows, v.Template(v_slot_default="{ item }"), html.Div(classes=(row,), click=click):
        html.Span("{{ item.name }}")
        html.Span("{{ item.at.join(', ') }}", classes="at")
        html.Span("{{ item.moved || '' }}", classes="moved", title="distance moved")
        v.VIcon("mdi-pin", v_if="item.fixed", size="x-small", classes="ml-2")


def _files(edit, begin):
    wide_button("Saved files ...", "mdi-download", "has_files = true", v_if="files.length")
    change, text = (edit, "['target_grid', $event]"), "Save images on the target's grid"
    options = {"density": "compact", "hide_details": True, "update_modelValue": change}
    v.VCheckbox(v_if="has_target", model_value=("target_grid",), label=text, **options)
    for kind, title, icon, limit in (
        ("handles", "Open handles ...", "mdi-vector-point", MAX_HANDLE_BYTES),
        ("data", "Open an image or a mesh ...", "mdi-folder-open-outline", MAX_DATA_BYTES),
        ("target", "Open a target to match ...", "mdi-image-multiple-outline", MAX_DATA_BYTES),
        ("session", "Open session ...", "mdi-folder-clock-outline", MAX_HANDLE_BYTES),
    ):
        values = {"kind": kind, "label": title, "icon": icon, "limit": (str(limit),)}
        names = {"__properties": [*values], "__events": ["answer"]}
        HtmlElement("mls-send", answer=(edit, "['say', $event]"), **values, **names)
    title = "Data, pairs, options, cuts and views in one file, .mls.json"
    click = begin, "['save_session']"
    wide_button("Save session", "mdi-content-save-move-outline", click, title=title)
