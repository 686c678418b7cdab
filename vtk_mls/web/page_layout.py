"""The layout of the page: a bar with a menu, the picture, a panel."""

import numpy as np
from trame.ui.vuetify3 import VAppLayout
from trame.widgets import html
from trame.widgets import vuetify3 as v
from trame_client.widgets.core import HtmlElement

from vtk_mls.editor import commands
from vtk_mls.editor.commands import with_key
from vtk_mls.editor.slices import ONLY_3D, PANES, SLICES
from vtk_mls.rendering.volume_colors import FOLDED, MAX_DOUBLINGS, colors_of
from vtk_mls.web import pair_table, panel
from vtk_mls.web.controls import icon_button, small_button
from vtk_mls.web.transfers import ALL

_THEMES = {
    "dark": {"background": "#0d0f16", "surface": "#161a25", "primary": "#6ea1ff"},
    "light": {"background": "#f2f4f8", "surface": "#ffffff", "primary": "#2563eb"},
}
_COLORS = {"secondary": "#f5b944", "error": "#e5616b", "success": "#43b581"}
CONFIG = {
    "theme": {
        "defaultTheme": "dark",
        "themes": {
            name: {"dark": name == "dark", "colors": {**colors, **_COLORS}}
            for name, colors in _THEMES.items()
        },
    }
}
# Buttons of the bar: icon, title, edit, and the class of those that narrow pages hide, and have in
# the menu only.
_TOOLS = (
    ("mdi-undo", "Undo", "undo", ""),
    ("mdi-redo", "Redo", "redo", ""),
    ("mdi-restore", "Put all handles back", "reset", "d-none d-md-inline-flex"),
    ("mdi-compare", "Before and after", "compare", "d-none d-md-inline-flex"),
    ("mdi-eye-outline", "Hide or show handles", "hide_handles", "d-none d-md-inline-flex"),
)
_LONG = "save", "refine"  # commands that the page begins as tasks
_COLORS_AT = np.linspace(-MAX_DOUBLINGS, MAX_DOUBLINGS, 9)  # doublings of the volume
_STATUS = ['role="status"']  # trame has no keyword for it
_SIZE = (  # of a file, with its unit
    "Intl.NumberFormat('en', { notation: 'compact', style: 'unit', unit: 'byte', "
    "unitDisplay: 'narrow' }).format(file.size)"
)
_NARROW = 900  # pixels; on narrower pages the panel covers the picture
_IS_NARROW = f"$vuetify.display.width < {_NARROW}"


def build(server, edit, begin):
    """Build the page of trame's Server.

    The page calls `edit(name, value)`, and `begin(name)` of a task that may be long, or of "stop".
    """
    with VAppLayout(server, vuetify_config=CONFIG) as layout:
        layout.root.theme = ("theme",)
        with v.VAppBar(density="compact", flat=True, border=True):
            _bar(edit, begin)
        with v.VNavigationDrawer(
            model_value=(f"{_IS_NARROW} ? has_sheet : has_panel",),
            update_modelValue=f"{_IS_NARROW} ? (has_sheet = $event) : (has_panel = $event)",
            location="right",
            width=("Math.min(348, $vuetify.display.width - 42)",),
            mobile_breakpoint=(str(_NARROW),),  # a number for the page, not a string
        ):
            panel.build(edit, begin)
        with v.VMain(style="height: 100dvh;"), html.Div(classes="mls-work"):
            with html.Div(classes="d-flex d-md-none justify-center"):
                _panes(edit, (ONLY_3D, *SLICES))
                _views(edit)
            with html.Div(classes="mls-stage"):
                _stage(edit, begin)
                _offer(edit)
            # above the picture; with slices, below it
            with html.Div(classes=("['mls-notes', { 'is-line': has_target }]",)):
                _notes(edit, begin)
            pair_table.build(edit, begin)
        _saved_files()


def _bar(edit, begin):
    with v.VBtn(icon=True, density="comfortable", classes="ml-2", title="All commands (H)"):
        v.VIcon("mdi-menu")
        _menu(edit, begin)
    icon = {"src": "vtk_mls_page/icon.svg", "width": 28, "height": 28, "alt": ""}
    html.Img(**icon, classes="ml-2 d-none d-sm-block")
    with html.Div(classes="mls-title"):
        html.Div("{{ title }}", classes="text-body-1 font-weight-medium text-truncate")
        html.Div("unsaved", v_if="!is_saved", classes="text-caption text-secondary")
    v.VSpacer()
    with html.Div(classes="d-none d-md-flex"):
        _panes(edit, PANES)
        _views(edit)
    for icon, title, name, classes in _TOOLS:
        icon_button(icon, with_key(title, name), (edit, f"['{name}']"), classes=classes)
    v.VDivider(vertical=True, inset=True, classes="mx-2 d-none d-md-block")
    icon = "theme === 'dark' ? 'mdi-weather-sunny' : 'mdi-weather-night'"
    change = "theme = theme === 'dark' ? 'light' : 'dark'"
    icon_button((icon,), "Light or dark", change, classes="d-none d-sm-inline-flex")
    title = with_key("Handles, deformed data, displacement field, picture, script", "save")
    look = {"variant": "flat", "color": "primary", "classes": "mx-2", "title": title}
    icon, click = "mdi-content-save-outline", (begin, "['save']")
    v.VBtn("Save", prepend_icon=icon, click=click, loading=("is_saving",), **look)
    change = f"{_IS_NARROW} ? (has_sheet = !has_sheet) : (has_panel = !has_panel)"
    icon_button("mdi-tune-variant", "Panel", change)


def _views(edit):
    title, click = with_key("Show everything", "reset_camera"), (edit, "['reset_camera']")
    icon_button("mdi-fit-to-page-outline", title, click, variant="text")
    icon = "selects_several ? 'mdi-checkbox-multiple-marked' : 'mdi-checkbox-multiple-outline'"
    title, click = "Select several handles (Ctrl)", "selects_several = !selects_several"
    icon_button((icon,), title, click, variant="text")


def _panes(edit, names):
    """Buttons that show one slice, the 3-D view, or all of them."""
    with html.Div(classes="mls-panes", v_if="has_panes"):
        for name in names:
            text, variant = name[0].upper() + name[1:], (f"pane === '{name}' ? 'flat' : 'text'",)
            color = (f"pane === '{name}' ? 'primary' : undefined",)
            options = {"color": color, "title": "Or double click in the picture"}
            small_button(text, None, (edit, f"['pane', '{name}']"), variant, **options)


def _stage(edit, begin):
    HtmlElement(
        "mls-picture",
        trame_server=None,
        name=("title",),
        __events=["save", "menu"],
        several=("selects_several",),
        __properties=["name", "several"],
        save=(begin, "['save']"),
        menu="has_menu = !has_menu",
    )
    look = {"color": "primary", "height": 4, "absolute": True, "style": "z-index: 5;"}
    look["indeterminate"] = ("!is_saving || progress === 0",)
    v.VProgressLinear(v_if="is_saving || is_busy", model_value=("progress",), **look)
    classes = "['mls-side', { 'is-over': comparison !== 'beside' }]"
    html.Div("{{ target_name }}", v_if="target_name", classes=(classes,))
    _volume_colors()


def _volume_colors():
    """What the colors of the change of volume mean."""
    colors = [f"rgb({', '.join(f'{255 * x:.0f}' for x in c)})" for c in colors_of(2.0**-_COLORS_AT)]
    with html.Div(v_if="has_colors", classes="mls-colors"):
        html.Span("volume \N{MULTIPLICATION SIGN}")
        html.Span("1/4")
        html.I(style=f"width: 120px; background: linear-gradient(90deg, {', '.join(colors)});")
        html.Span("4")
        html.I(style=f"width: 14px; background: rgb{tuple(255 * x for x in FOLDED)};")
        html.Span("folds")


def _notes(edit, begin):
    """Status, message, and the progress of work."""
    html.Div("{{ status }}", classes="mls-status")
    with html.Div(classes="mls-messages"):
        options = {"click": (edit, "['say', '']"), "raw_attrs": _STATUS}
        is_shown = "message && message !== offer"
        html.Div("{{ message }}", v_if=is_shown, classes="mls-message", **options)
    with html.Div(v_if="is_saving", classes="mls-task", raw_attrs=_STATUS):
        html.Span("{{ task }} {{ progress }} %")
        v.VBtn("Stop", size="x-small", variant="tonal", click=(begin, "['stop']"))
    html.Div("Working ...", v_if="is_busy && !is_saving", classes="mls-task", raw_attrs=_STATUS)


def _offer(edit):
    """The offer of unsaved handles of another session; other messages do not hide it."""
    is_shown = "offer && offer !== hidden_offer"
    with html.Div(v_if=is_shown, classes="mls-message mls-offer", raw_attrs=_STATUS):
        html.Span("{{ offer }}")
        for text, click, method, variant in (
            ("Bring them back", (edit, "['accept']"), "accept", "tonal"),
            ("Later", "hidden_offer = offer", None, "text"),
            ("Drop them", (edit, "['decline']"), "decline", "text"),
        ):
            title = with_key(text, method) if method else None
            small_button(text, None, click, variant, classes="ml-2", title=title)


def _menu(edit, begin):
    """All commands with their keys, and what the mouse does."""
    menu = v.VMenu(v_model=("has_menu", False), activator="parent")
    with menu, v.VList(density="compact", classes="mls-menu"):
        for title, rows in commands.MENUS.items():
            is_shown = "has_target" if title == "Landmarks" else "true"
            with v.Template(v_if=is_shown):
                v.VListSubheader(title)
                for row in rows:
                    if row.method != "quit":
                        _entry(row, edit, begin)
        v.VListSubheader("Mouse")
        for button, text in commands.MOUSE:
            with html.Div(classes="mls-entry px-4 py-1 text-body-2"):
                html.Span(text)
                html.B(button)


def _entry(row, edit, begin):
    """An entry of the menu; its key is at the right, and in the tool tip."""
    call, key = begin if row.method in _LONG else edit, commands.key_of(row)
    arguments = [row.method] if row.value is None else [row.method, row.value]
    item = v.VListItem(click=(call, str(arguments)))
    with item, html.Div(classes="mls-entry text-body-2", title=f"{row.text} ({key})"):
        html.Span(row.text)
        html.B(key)


def _saved_files():
    """A dialog with the files that were saved last, for download."""
    dialog = v.VDialog(v_model=("has_files", False), max_width=480, scrollable=True)
    with dialog, v.VCard(title="Saved", subtitle=("'in ' + saved_folder",)):
        with v.VCardText(classes="px-2 py-0"), v.VList(density="compact", nav=True):
            v.VListItem(
                v_for="file in files",
                key=("file.name",),
                title=("file.name",),
                subtitle=(f"file.what + ', ' + {_SIZE}",),
                href=("'saved/' + encodeURIComponent(file.name)",),
                raw_attrs=["download"],
                append_icon="mdi-download",
            )
        warning = "These files lack the last edits: save again to include them."
        html.Div(warning, v_if="!is_saved", classes="text-caption text-secondary px-6")
        with v.VCardActions():
            link = {"href": f"saved/{ALL}", "raw_attrs": ["download"]}
            v.VBtn("All files (.zip)", prepend_icon="mdi-folder-zip-outline", **link)
            v.VSpacer()
            v.VBtn("Close", click="has_files = false")
