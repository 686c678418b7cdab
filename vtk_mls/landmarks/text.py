"""A report in words and tables, and as a page of HTML."""

from collections.abc import Iterable, Sequence
from html import escape

import numpy as np

from vtk_mls.landmarks.pair_report import Report
from vtk_mls.landmarks.refinement import Refinement

_MAX_NAMES = 10  # in a sentence
_STYLE = "body { font: 15px/1.5 sans-serif; margin: 2em } td, th { padding: 2px 12px }"


def heading(report: Report) -> list[str]:
    """Sentences with the results and the recommended settings."""
    median = report.tried[report.recommended]
    baseline = report.baseline
    of = "" if report.sampled == len(report.names) else f" (of {report.sampled} pairs)"
    best = next(iter(report.tried))
    lines = [
        *_about_shape(report, "" if report.recommended == best else best.flags),
        f"{len(report.names)} pairs; median error of a pair predicted from the others: "
        f"{median:.3g}{of}; with one rigid map for all {baseline['rigid']:.3g}, with one affine "
        f"map {baseline['affine']:.3g}",
        f"take: {report.recommended.flags}",
    ]
    swapped = {i for pair in report.swaps for i in pair}
    rows = [i for i in worst_first(report) if report.outlier[i] and i not in swapped]
    none = "none"
    if report.shape.is_drag:
        none = "not looked for; most pairs rest, as handles of a drag do, and landmarks do not"
    lines.append(f"outliers: {_listed([report.names[i] for i in rows]) or none}")
    pairs = [f"{report.names[i]} and {report.names[j]}" for i, j in report.swaps]
    lines.append(f"labels that look swapped: {_listed(pairs) or 'none'}")
    determinant = report.smallest_determinant
    result = "does not fold at sampled points"
    if determinant <= 0:
        is_between = report.determinant_between <= 0
        result = (
            "folds" if is_between else "folds, but not at samples between neighboring landmarks"
        )
    return [*lines, f"the map {result}: smallest determinant {determinant:.3g}"]


def _about_shape(report, refused):
    """Sentences about a mirror, a thin set, and the options `refused` that predict best, or ""."""
    shape = report.shape
    if shape.mirror:
        axis = "an oblique axis" if shape.mirror == "oblique" else f"the axis {shape.mirror}"
        yield (
            f"q is a mirror image of p (left and right are mixed up, or {axis} is turned around): "
            "swap the names of left and right, or check the frame of the points; every map that "
            "meets these pairs folds"
        )
        return
    text = f"`{refused}` predicts best, but flattens, folds or explodes the volume around the pairs"
    if shape.is_thin:
        size = " x ".join(f"{extent:.3g}" for extent in shape.extents)
        name = "line" if shape.is_line else "plane"
        text = f"; {text}" if refused else ""
        yield (
            f"the pairs are nearly on a {name} ({size} along their principal axes), so the map "
            f"away from it is a guess; add pairs beside it{text}"
        )
    elif refused:
        yield text
    if not report.is_sensible:
        yield "no settings tried give a sensible map around the pairs; these come nearest to it"


def setting_rows(report: Report) -> list[list[str]]:
    """A head and rows of the best settings, and of one map for all."""
    rows = [["settings", "median error"]]
    rows += [[s.flags, f"{median:.4g}"] for s, median in report.tried.items()]
    return rows + [[f"one {name} map", f"{m:.4g}"] for name, m in report.baseline.items()]


def pair_rows(report: Report, rows: Iterable[int]) -> list[list[str]]:
    """A head and a row for each of the pairs `rows`."""
    lines = [["pair", "moved", "error", ""]]
    for i in rows:
        partner = report.swapped_with[i]
        remark = "outlier" if report.outlier[i] else ""
        if partner >= 0:
            remark = f"swapped with {report.names[partner]}?"
        lines.append([report.names[i], f"{report.moved[i]:.4g}", f"{report.error[i]:.4g}", remark])
    return lines


def refinement_heading(refinement: Refinement) -> str:
    """A sentence with the number of landmarks that moved, and how far."""
    is_moved = np.array([not reason for reason in refinement.refused], bool)
    count, moved = len(is_moved), refinement.moved[is_moved]
    if not is_moved.any():
        return f"none of {count} landmarks is refined: no match is trustworthy"
    before, score = (
        np.nanmedian(column[is_moved]) for column in (refinement.score_before, refinement.score)
    )
    return (
        f"{len(moved)} of {count} landmarks are refined; moved by {np.median(moved):.3g} (median), "
        f"{moved.max():.3g} at most; median score {before:.2f} before, {score:.2f} now"
    )


def refinement_sentence(refinement: Refinement, names: Sequence[str]) -> str:
    """A sentence about the refinement of one landmark or of several."""
    if len(names) > 1:
        text = refinement_heading(refinement)
        still = [name for name, reason in zip(names, refinement.refused) if reason]
        rest = f"; not moved: {_listed(still)}" if 0 < len(still) < len(names) else ""
        return f"{text[0].upper()}{text[1:]}{rest}."
    if refinement.refused[0]:
        return f"Landmark {names[0]} is not moved: {refinement.refused[0]}."
    before, score = float(refinement.score_before[0]), float(refinement.score[0])
    return (
        f"Landmark {names[0]} is moved by {refinement.moved[0]:.3g}; score {before:.2f} before, "
        f"{score:.2f} now."
    )


def worst_first(report: Report) -> list[int]:
    """Rows of all pairs: outliers first, then by error."""
    return [int(i) for i in np.lexsort([-report.error, ~report.outlier])]


def aligned(rows: list[list[str]]) -> list[str]:
    """Lines of a table for a terminal: first and last column to the left, numbers to the right."""
    widths = [max(map(len, column)) for column in zip(*rows)]
    last = len(widths) - 1
    return [
        "  ".join(
            cell.ljust(width) if column == 0 or column == last > 1 else cell.rjust(width)
            for column, (cell, width) in enumerate(zip(row, widths))
        ).rstrip()
        for row in rows
    ]


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


def _listed(names):
    more = f" and {len(names) - _MAX_NAMES} more" * (len(names) > _MAX_NAMES)
    return ", ".join(names[:_MAX_NAMES]) + more
