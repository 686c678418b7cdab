"""The pairs of landmarks below the two pictures: comparison, table, refinement."""

from trame.widgets import html
from trame.widgets import vuetify3 as v

from vtk_mls.editor.commands import with_key
from vtk_mls.editor.matching.target import MODES
from vtk_mls.web.controls import icon_button, slider, small_button, toggle

_HEIGHT, _NARROW_HEIGHT = 176, 120  # of the table, pixels
_IS_NARROW = "$vuetify.display.width < (has_panel ? 1150 : 700)"  # beside the panel
# Title, key, whether narrow pages show it.
_COLUMNS = (
    ("On", "enabled", True),
    ("Name", "name", True),
    ("On the moving data", "rest", False),
    ("On the target", "at", False),
    ("Distance", "distance", False),
    ("Error", "error", True),
    ("Score", "score", True),
    ("", "actions", True),
)
# By column: when a warning is shown, its color, its tool tip.
_ALERTS = {
    "error": ("item.outlier", "error", "outlier: far from what the other pairs predict"),
    "score": ("item.refused", "secondary", ("'not moved: ' + item.refused",)),
}
_ALIGNED_RIGHT = "distance", "error", "score"


def build(edit, begin):
    """Build the table, which pages with a target show.

    `edit` and `begin` are as of `page_layout.build`.
    """
    with v.VSheet(v_if="has_target", classes="mls-pairs", border="t"):
        with html.Div(classes="mls-tools"):
            _comparison(edit)
            v.VSpacer()
            _errors()
            _refinement(begin)
        _table(edit)


def _comparison(edit):
    toggle("comparison", [(mode, mode.capitalize()) for mode in MODES], edit, "compare_by")
    text, options = "Share of the target", {"style": "width: 70px; flex: none;"}
    options.update(v_if="comparison === 'fade'", title=with_key(text, "change_share"))
    slider("share", text, (0, 1, 0.05), edit, **options)
    with html.Div(classes="mls-tools"):
        for icon, text, step in (("up", "Previous pair", -1), ("down", "Next pair", 1)):
            title, click = with_key(text, "jump_by", step), (edit, f"['jump_by', {step}]")
            options = {"size": "x-small", "variant": "tonal"}
            icon_button(f"mdi-chevron-{icon}", title, click, "default", **options)


def _errors():
    """The median error. Narrow pages keep its line, so that the picture above keeps its size."""
    text = "median_error ? `median error ${median_error} ${unit} ${choice}` : ''"
    title = "Each pair predicted from the others"
    html.Span(f"{{{{ {text} }}}}", classes="mls-errors text-caption", title=title)


def _refinement(begin):
    tip = "Move landmarks on the target to the best match of the images around them"
    for text, rows in (("Refine", "selected"), ("Refine all", "pairs")):
        click = begin, f"['{text.lower().replace(' ', '_')}']"
        options = {"disabled": (f"is_saving || !{rows}.length",), "title": with_key(tip, "refine")}
        small_button(text, "mdi-crosshairs-gps", click, **options)


def _table(edit):
    headers = [
        {
            "title": title,
            "key": key,
            "sortable": key not in ("rest", "at", "actions"),
            "align": "end" if key in _ALIGNED_RIGHT else "start",
            "has_unit": key in ("distance", "error"),
        }
        for title, key, _ in _COLUMNS
    ]
    narrow = [header for header, (*_, is_shown) in zip(headers, _COLUMNS) if is_shown]
    table = v.VDataTableVirtual(
        headers=(
            f"({_IS_NARROW} ? narrow_headers : pair_headers).map(header => "
            "({ ...header, title: header.title + (header.has_unit && unit ? ` (${unit})` : '') }))",
        ),
        items=("pairs",),
        item_value="row",
        density="compact",
        fixed_header=True,
        height=(f"{_IS_NARROW} ? {_NARROW_HEIGHT} : {_HEIGHT}",),
        row_props=(
            "({ item }) => ({ class: { 'is-selected': selected.includes(item.row), "
            "'is-off': !item.enabled } })",
        ),
        no_data_text="Click a place on either side, then drag its landmark where it is wrong.",
        sort_by=("pair_order", [{"key": "error", "order": "desc"}]),
        update_sortBy="pair_order = $event",
    )
    table.server.state.update({"pair_headers": headers, "narrow_headers": narrow})
    with table:
        _cells(edit)


def _cells(edit):
    with _cell("enabled"):
        change = edit, "['enable', [item.row, $event.target.checked]]"
        title = with_key("Leave the pair out, or include it", "toggle_enabled")
        options = {"checked": ("item.enabled",), "title": title, "raw_attrs": [_label("Use")]}
        html.Input(type="checkbox", change=change, **options)
    with _cell("name"):
        change = edit, "['name', [item.row, $event.target.value]]"
        options = {"classes": "mls-name", "raw_attrs": [_label("Name of")]}
        focus = edit, "['select', [item.row]]"
        html.Input(value=("item.name",), focus=focus, change=change, **options)
    for key in _ALIGNED_RIGHT:
        with _cell(key):
            html.Span(f"{{{{ item.{key} === null ? '' : Number(item.{key}.toPrecision(3)) }}}}")
            if key in _ALERTS:
                condition, color, title = _ALERTS[key]
                options = {"size": "x-small", "color": color, "classes": "ml-1", "title": title}
                v.VIcon("mdi-alert-outline", v_if=condition, **options)
    with _cell("actions"):
        for icon, text, click in (
            ("mdi-target", "Jump to", "['jump', [item.row]]"),
            ("mdi-delete-outline", "Delete", "['delete_pair', [item.row]]"),
        ):
            options = {"size": "x-small", "variant": "text", "raw_attrs": [_label(text)]}
            icon_button(icon, text, (edit, click), "default", **options)


def _label(text):
    """The attribute that names a control of a row; trame drops `aria_label`."""
    return f":aria-label=\"'{text} ' + item.name\""


def _cell(key):
    return v.Template(raw_attrs=[f'v-slot:item.{key}="{{ item }}"'])
