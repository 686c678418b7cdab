"""A report as a page of HTML."""

from __future__ import annotations

from html import escape

from vtk_mls.landmarks.pair_report import Report
from vtk_mls.landmarks.text import heading, pair_rows, setting_rows, worst_first

_STYLE = "body { font: 15px/1.5 sans-serif; margin: 2em } td, th { padding: 2px 12px }"


def page(report: Report) -> str:
    """The text of the page of a `Report`."""
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Landmarks</title><style>{_STYLE}</style></head>
<body><h1>Landmarks</h1>
{"".join(f"<p>{escape(line)}</p>" for line in heading(report))}
<h2>Settings</h2>{_table(setting_rows(report))}
<h2>Pairs, worst first</h2>{_table(pair_rows(report, worst_first(report)))}
</body></html>
"""


def _table(rows: list[list[str]]) -> str:
    lines = ("".join(f"<td>{escape(cell)}</td>" for cell in row) for row in rows)
    return f"<table>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>"
