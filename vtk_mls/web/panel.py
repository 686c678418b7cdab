"""The panel beside the picture: map, cut, handles, look, files."""

from __future__ import annotations

from trame.widgets import html
from trame.widgets import vuetify3 as v
from trame_client.widgets.core import HtmlElement

from vtk_mls.editor.distortion import MODES
from vtk_mls.model import options
from vtk_mls.web.transfers import MAX_HANDLE_BYTES

_CUTS = ("none", "None"), ("plane", "Plane"), ("half-plane", "Half-plane")
_FIELDS = {"density": "compact", "variant": "outlined", "hide_details": True}


def build(edit, begin, max_bytes):
    """Build the panel.

    Parameters
    ----------
    edit, begin, max_bytes
        As of `page_layout.build`.
    """
    with html.Div(classes="pa-4 d-flex flex-column", style="gap: 14px;"):
        _section("Map")
        _options(edit, "map")
        _section("Cut")
        _cut(edit)
        _section("Handles")
        _handles(edit)
        _shapes(edit)
        _section("Look")
        v.VSelect(
            items=("looks.map((title, value) => ({ title, value }))",),
            model_value=("look",),
            update_modelValue=(edit, "['look', $event]"),
            label="Colors and opacities",
            **_FIELDS,
        )
        v.VSelect(
            items=("distortions", _items(text.capitalize() for text in MODES)),
            model_value=("distortion",),
            update_modelValue=(edit, "['distortion', $event]"),
            label="Show of the deformation (J)",
            **_FIELDS,
        )
        _section("Files")
        _files(edit, begin, max_bytes)


def _items(titles):
    """Items of a list whose values are numbers."""
    return [{"title": title, "value": value} for value, title in enumerate(titles)]


def _section(title):
    html.Div(title, classes="mls-section mt-2")


def _options(edit, section):
    """Controls of the options in a section of the panel."""
    for option in options.OPTIONS:
        if option.section == section:
            if option.slider:
                _slider(edit, option.name, option.label, option.slider)
            elif option.choices:
                _select(edit, option)
            else:
                _number(edit, option)


def _select(edit, option):
    labels = option.choice_labels or option.choices
    items = [{"title": title, "value": value} for title, value in zip(labels, option.choices)]
    condition = {}
    if option.needs:
        name, value = option.needs
        condition["v_if"] = f"{name} === '{value}'"
    v.VSelect(
        items=(f"{option.name}_choices", items),
        model_value=(option.name,),
        update_modelValue=(edit, f"['{option.name}', $event]"),
        label=option.label,
        **condition,
        **_FIELDS,
    )


def _slider(edit, name, title, steps):
    low, high, step = steps
    with html.Div():
        with html.Div(classes="d-flex text-body-2"):
            html.Span(title)
            v.VSpacer()
            html.Span(f"{{{{ Number({name}).toFixed(2) }}}}", classes="text-primary")
        v.VSlider(
            min=low,
            max=high,
            step=step,
            model_value=(name,),
            end=(edit, f"['{name}', $event]"),
            color="primary",
            density="compact",
            hide_details=True,
            aria_label=title,
        )


def _number(edit, option):
    v.VTextField(
        model_value=(option.name,),
        label=option.label,
        title=" ".join(option.help.split()),
        change=(edit, f"['{option.name}', $event.target.value]"),
        **_FIELDS,
    )


def _cut(edit):
    with v.VBtnToggle(
        model_value=("cut",),
        update_modelValue=(edit, "['cut', $event]"),
        mandatory=True,
        divided=True,
        variant="outlined",
        density="compact",
        color="primary",
        classes="d-flex",
    ):
        for value, text in _CUTS:
            v.VBtn(text, value=value, classes="flex-grow-1", size="small")
    with html.Div(v_if="cut === 'half-plane'"):
        v.VBtn(
            "Another half",
            prepend_icon="mdi-rotate-3d-variant",
            block=True,
            variant="tonal",
            click=(edit, "['change_half']"),
        )
    v.VBtn(
        "Draw a line and cut along it",
        prepend_icon="mdi-content-cut",
        block=True,
        variant="tonal",
        title="Click on the surface, then here again (P)",
        click=(edit, "['incise']"),
    )
    with html.Div(
        v_if="cut !== 'none' || has_lines",
        classes="d-flex flex-column",
        style="gap: 14px;",
    ):
        _options(edit, "cut")


def _handles(edit):
    _table(edit)
    _selected(edit)
    with html.Div(classes="d-flex flex-wrap", style="gap: 8px;"):
        _small("mdi-pin-outline", "Fix", "fix", edit)
        _small("mdi-rotate-orbit", "Turn", "turn_handle", edit)
        _small("mdi-delete-outline", "Delete", "delete", edit)
        v.VBtn(
            "Lattice",
            prepend_icon="mdi-grid",
            size="small",
            variant="tonal",
            classes="flex-grow-1",
            title="Lay a lattice of handles, again a finer one (L)",
            click=(edit, "['lay_lattice']"),
        )


def _selected(edit):
    """Fields of the one selected handle: name, rest and present position."""
    with html.Div(
        v_if="selected.length === 1 && rows[selected[0]]",
        classes="d-flex flex-column",
        style="gap: 8px;",
    ):
        v.VTextField(
            v_if="rows[selected[0]].is_point",
            model_value=("rows[selected[0]].name",),
            label="Name",
            change=(edit, "['name', [selected[0], $event.target.value]]"),
            **_FIELDS,
        )
        _position(edit, "at", "position", "")
        with html.Div(v_if="!rows[selected[0]].is_mask"):
            _position(edit, "rest", "rest", " at rest")


def _position(edit, column, name, suffix):
    """Three fields for a position in a column of the table."""
    with html.Div(classes="d-flex", style="gap: 8px;"):
        for axis, coordinate in enumerate("xyz"):
            numbers = [f"rows[selected[0]].{column}[{i}]" for i in range(3)]
            values = ["selected[0]", *numbers]
            values[1 + axis] = "$event.target.value"
            v.VTextField(
                model_value=(numbers[axis],),
                label=coordinate + suffix,
                change=(edit, f"['{name}', [{', '.join(values)}]]"),
                **_FIELDS,
            )


def _shapes(edit):
    """Buttons for regions, curves and the mask."""
    for icon, text, name, title in (
        (
            "mdi-bone",
            "Make rigid: click on a mesh or label",
            "make_clicked_rigid",
            "Then move and turn it by its box (G)",
        ),
        (
            "mdi-vector-polyline",
            "{{ is_drawing ? 'End the curve' : 'Draw a curve' }}",
            "draw_curve",
            "Click its nodes on the surface or in slices (D)",
        ),
        (
            "mdi-circle-expand",
            "{{ has_mask ? 'Act everywhere' : 'Act in a ball only' }}",
            "change_mask",
            "A ball around the selected handle; drag its violet points (W)",
        ),
    ):
        v.VBtn(
            text,
            prepend_icon=icon,
            block=True,
            variant="tonal",
            title=title,
            click=(edit, f"['{name}']"),
        )


def _table(edit):
    """Rows of handles; a click selects, Ctrl+click adds to the selection."""
    rows = v.VVirtualScroll(items=("rows",), height=216, item_height=30, classes="mls-rows")
    row = "{ 'mls-row': true, 'is-selected': selected.includes(item.row) }"
    has_modifier = "$event.ctrlKey || $event.metaKey"
    other_rows = "selected.filter(i => i !== item.row)"
    toggled = f"selected.includes(item.row) ? {other_rows} : [...selected, item.row]"
    click = edit, f"['select', {has_modifier} ? ({toggled}) : [item.row]]"
    with rows, v.Template(v_slot_default="{ item }"), html.Div(classes=(row,), click=click):
        html.Span("{{ item.name }}")
        html.Span("{{ item.at.join(', ') }}", classes="at")
        html.Span("{{ item.moved || '' }}", classes="moved", title="distance moved")
        v.VIcon("mdi-pin", v_if="item.fixed", size="x-small", classes="ml-2")


def _small(icon, text, name, edit):
    v.VBtn(
        text,
        prepend_icon=icon,
        size="small",
        variant="tonal",
        classes="flex-grow-1",
        disabled=("selected.length === 0",),
        click=(edit, f"['{name}']"),
    )


def _files(edit, begin, max_bytes):
    v.VBtn(
        "Saved files ...",
        v_if="files.length",
        prepend_icon="mdi-download",
        block=True,
        variant="tonal",
        click="has_files = true",
    )
    for kind, title, icon, limit in (
        ("handles", "Open handles ...", "mdi-vector-point", MAX_HANDLE_BYTES),
        ("data", "Open an image or a mesh ...", "mdi-folder-open-outline", max_bytes),
        ("target", "Open a target to match ...", "mdi-image-multiple-outline", max_bytes),
        ("session", "Open session ...", "mdi-folder-clock-outline", MAX_HANDLE_BYTES),
    ):
        HtmlElement(
            "mls-send",
            kind=kind,
            label=title,
            icon=icon,
            limit=(str(limit),),
            answer=(edit, "['say', $event]"),
            __properties=["kind", "label", "icon", "limit"],
            __events=["answer"],
        )
    v.VBtn(
        "Save session",
        prepend_icon="mdi-content-save-move-outline",
        block=True,
        variant="tonal",
        title="Data, pairs, options, cuts and views in one file, .mls.json",
        click=(begin, "['save_session']"),
    )
