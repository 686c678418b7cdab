"""The name of the target and the table of pairs, as texts in the window."""

from __future__ import annotations

import numpy as np

from vtk_mls.editor.overlay import size_of, text_actor
from vtk_mls.editor.polydata import configured

_COLOR, _TITLE_COLOR, _PANEL = (0.95, 0.95, 0.8), (1, 0.78, 0.35), (0.04, 0.05, 0.08)
_MARGIN, _SIZE = 14, 13
_MAX_ROWS, _MAX_NAME = 24, 14  # of the table, and letters of a name
_TICK_COLUMNS = range(2, 5)  # letters of a line


class PairText:
    """A title and the table of pairs, drawn in the renderer of all texts."""

    def __init__(self, renderer, title):
        self._title, self._table = text_actor(_TITLE_COLOR, _SIZE), text_actor(_COLOR, _SIZE)
        self._title.SetInput(title)
        self._renderer, self._rows, self._first_row = renderer, [], 0
        for actor in (self._title, self._table):
            actor.GetTextProperty().SetVerticalJustificationToTop()
            renderer.AddViewProp(actor)
        font = self._table.GetTextProperty()
        configured(font, BackgroundColor=_PANEL, BackgroundOpacity=0.7).SetFontFamilyToCourier()
        self.set_table(None, ())

    def set_visible(self, is_visible):
        """Show or hide title and table."""
        self._title.SetVisibility(is_visible)
        self._table.SetVisibility(is_visible and bool(self._table.GetInput()))

    def set_table(self, table, selected, score=None):
        """Show a `PairTable` with the selected rows marked, or none for None.

        `score` is that of the only selected row, and why it is refused; None without one.
        """
        lines, self._rows = [], []
        if table is not None:
            shown = rows_shown(table, selected, self._first_row)
            lines = lines_of(table, selected, score, shown)
            self._rows, self._first_row = table.rows[shown], shown.start
        self._table.SetInput("\n".join(lines))
        self._table.SetVisibility(bool(lines))

    def cell_at(self, pixel):
        """The `PairRow` at a pixel, and whether its tick is there; None beside rows."""
        if not self._table.GetVisibility():
            return None
        lines, size = self._table.GetInput().split("\n"), size_of(self._table, self._renderer)
        across, down = (pixel - np.array(self._table.GetPosition())) * (1, -1) / size
        if not (0 <= across < 1 and 0 <= down < 1):
            return None
        line = int(down * len(lines)) - 1
        if not 0 <= line < len(self._rows) or self._rows[line].row is None:
            return None
        return self._rows[line], int(across * max(map(len, lines))) in _TICK_COLUMNS

    def lay_out(self, renderer):
        """Place the texts at the top of another renderer, of the target."""
        left, low = renderer.GetOrigin()
        top = low + renderer.GetSize()[1] - _MARGIN
        self._title.SetPosition(left + _MARGIN, top)
        self._table.SetPosition(left + _MARGIN, top - 2 * _SIZE)


def lines_of(table, selected, score=None, shown=slice(0, _MAX_ROWS)):
    """Lines of text as of `PairText.set_table`; `shown` is a slice of the rows."""
    marked, rows = {int(row) for row in selected}, table.rows
    lines = [f"  use {'name':{_MAX_NAME}} distance    error"]
    for row in rows[shown]:
        name = f"{row.name[:_MAX_NAME]:{_MAX_NAME}}"
        if row.row is None:
            missing = "target" if row.deformed is None else "data"
            lines.append(f"      {name} click on the {missing}")
            continue
        mark = ">" if row.row in marked else " "
        tick = "[x]" if row.is_enabled else "[ ]"
        error = "off" if not row.is_enabled else "-" if row.error is None else f"{row.error:.4g}"
        lines.append(f"{mark} {tick} {name} {row.distance:8.4g} {error:>8}")
    if len(rows) > _MAX_ROWS:
        lines.append(f"  {shown.start + 1} to {shown.stop} of {len(rows)}")
    if table.has_errors:
        lines.append(f"  median error when left out {table.median_error:.3g}")
        lines += [f"  {table.choice}"] * bool(table.choice)
    else:
        lines.append("  no errors yet: they need 4 pairs")
    selected_pairs = [pair for pair in rows if pair.row in marked]
    if len(selected_pairs) == 1:
        lines += _lines_about(*selected_pairs, score)
    return lines


def rows_shown(table, selected, first=0):
    """The slice of the rows of a `PairTable` that fit in the window.

    From `first` on if the selected row is among them, so that a click does not move the rows; else
    around it.
    """
    count, row = len(table.rows), int(min(selected, default=first))
    if not first <= row < first + _MAX_ROWS:
        first = row - _MAX_ROWS // 2
    first = max(0, min(first, count - _MAX_ROWS))
    return slice(first, min(first + _MAX_ROWS, count))


def _lines_about(pair, score):
    """Both places of a `PairRow`, and the result of its refinement."""
    places = ("data", pair.rest), ("target", pair.deformed)
    lines = [f"  {side:6} " + ", ".join(f"{x:.5g}" for x in place) for side, place in places]
    if score is not None:
        value, reason = score
        lines.append(f"  not moved: {reason}" if reason else f"  score {value:.3g}")
    return lines
