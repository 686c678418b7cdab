"""A report as a page of HTML with pictures, in one file."""

from __future__ import annotations

from html import escape

import numpy as np

from vtk_mls.landmarks.pair_report import Report
from vtk_mls.landmarks.text import heading, pair_rows, setting_rows, worst_first

_SIZE, _MARGIN = 320, 12  # of a picture, pixels
_BAR_HEIGHT, _MAX_BARS = 160, 400
_VIEWS = (
    ("x to the right, y down", 0, 1, 1),
    ("x right, z up", 0, 2, -1),
    ("y right, z up", 1, 2, -1),
)
_COLORS = {"": "#3b6ea5", "outlier": "#c62828", "swapped": "#d97a00"}
_STYLE = """
body { font: 15px/1.5 sans-serif; margin: 2em auto; max-width: 1040px; padding: 0 1em; color: #222 }
table { border-collapse: collapse; margin: 1em 0 } td, th { padding: 2px 12px; text-align: right }
th { border-bottom: 1px solid #999 } td:first-child, th:first-child { text-align: left }
figure { display: inline-block; margin: 0 12px 12px 0 } svg { background: #f6f6f6 }
code { background: #eee; padding: 1px 4px } .outlier { color: #c62828 } .swapped { color: #b06000 }
"""


def page(report: Report) -> str:
    """The text of the page of a `Report`."""
    views = "".join(_projection(report, *view) for view in _VIEWS)
    legend = "Lines from p (dot) to q; red: outliers, orange: labels that look swapped."
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Landmarks</title><style>{_STYLE}</style></head>
<body><h1>Landmarks</h1>
{"".join(f"<p>{escape(line)}</p>" for line in heading(report))}
<h2>Settings</h2>{_table(setting_rows(report))}
<h2>Pictures</h2><p>{legend}</p>{views}
<h2>Errors when left out</h2>{_bars(report)}
<h2>Pairs, worst first</h2>{_pairs(report)}
</body></html>
"""


def _class_of(report, i):
    if report.swapped_with[i] >= 0:
        return "swapped"
    return "outlier" if report.outlier[i] else ""


def _projection(report, title, across, up, sign):
    """A picture of all pairs along an axis."""
    places = np.stack([report.rest, report.deformed])[:, :, [across, up]] * [1, sign]
    low = places.min(axis=(0, 1))
    size = np.ptp(places, axis=(0, 1)).max() or 1
    p, q = (places - low) / size * (_SIZE - 2 * _MARGIN) + _MARGIN
    marks = []
    for i in sorted(range(len(p)), key=lambda i: bool(_class_of(report, i))):
        color = _COLORS[_class_of(report, i)]
        (x, y), (to_x, to_y) = p[i], q[i]
        marks.append(
            f'<g stroke="{color}" fill="{color}"><title>{escape(report.names[i])}</title>'
            f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{to_x:.1f}" y2="{to_y:.1f}"/>'
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2"/></g>'
        )
    return (
        f'<figure><svg width="{_SIZE}" height="{_SIZE}">{"".join(marks)}</svg>'
        f"<figcaption>{title}</figcaption></figure>"
    )


def _bars(report):
    """A bar for the error of each pair, worst first."""
    rows = worst_first(report)[:_MAX_BARS]
    largest = report.error.max() or 1
    width = max(2, min(16, 1000 // len(rows)))
    bars = []
    for place, i in enumerate(rows):
        height = report.error[i] / largest * _BAR_HEIGHT
        bars.append(
            f'<rect x="{place * width}" y="{_BAR_HEIGHT - height:.1f}" width="{width - 1}" '
            f'height="{height:.1f}" fill="{_COLORS[_class_of(report, i)]}">'
            f"<title>{escape(report.names[i])}: {report.error[i]:.3g}</title></rect>"
        )
    more = "" if len(rows) == len(report.names) else f"<p>The {len(rows)} largest.</p>"
    size = f'width="{len(rows) * width}" height="{_BAR_HEIGHT}"'
    return f"{more}<svg {size}>{''.join(bars)}</svg>"


def _table(rows, classes=None):
    head, *body = rows
    lines = ["<tr>" + "".join(f"<th>{escape(cell)}</th>" for cell in head) + "</tr>"]
    for i, row in enumerate(body):
        name = f' class="{classes[i]}"' if classes else ""
        lines.append(f"<tr{name}>" + "".join(f"<td>{escape(c)}</td>" for c in row) + "</tr>")
    return f"<table>{''.join(lines)}</table>"


def _pairs(report):
    rows = worst_first(report)
    return _table(pair_rows(report, rows), [_class_of(report, i) for i in rows])
