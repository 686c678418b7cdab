"""Values of an editor for the panel, as JSON has them."""

import numpy as np

from vtk_mls import CurveHandle
from vtk_mls.editor.grips import MASK, POINT, names_of
from vtk_mls.editor.matching.pairs import key_of, table_of
from vtk_mls.editor.matching.target import BESIDE, FADE
from vtk_mls.files import metadata
from vtk_mls.files.metadata import LENGTH_UNIT, METAIMAGE_HEADER, NIFTI_HEADER, NRRD_HEADER
from vtk_mls.model.options import values_of as values_of_options

_IN_MILLIMETERS = NIFTI_HEADER, NRRD_HEADER, METAIMAGE_HEADER
_DIGITS = 5  # after the first digit of the distance between handles


def values_of(editor, previous):
    """Values of an `Editor` by their names in the page's templates.

    `previous` are the values before, as rows do not change while a handle is dragged.
    """
    state = editor.state
    values = values_of_options(state)
    presets = max((item.preset_names for item in editor.scene.items), key=len)
    values.update(
        cut=shape_of(state),
        has_lines=any(not cut.labels() for cut in state.cuts),
        selected=editor.selected.tolist(),
        message=editor.message,
        is_saved=editor.document.is_saved,
        offer=editor.offer,
        status=editor.status,
        presets=presets,
        preset=editor.view.preset % len(presets),
        distortion=editor.view.distortion.mode,
        has_colors=editor.view.distortion.has_colors,
        has_curve=any(isinstance(handle, CurveHandle) for handle in state.handles),
        has_mask=state.mask is not None,
        is_drawing=editor.is_drawing_curve,
    )
    has_target = editor.target is not None
    values.update(
        has_target=has_target,
        comparison=editor.comparison.mode,
        share=editor.comparison.share,
        target_name=_title_of(editor),
        pane=editor.slices.pane,
        has_panes=editor.scene.flat_axis is None,
        unit=_unit_of(editor),
        target_grid=editor.saver.uses_target_grid,
        times=[f"{i}: {time:g}" for i, time in enumerate(editor.saver.times, 1)],
        step=editor.saver.step,
    )
    if editor.document.grabbed is None or "rows" not in previous:
        values["rows"] = _rows(state)
        values["pairs"] = _pairs(state, editor.scores) if has_target else []
        table = table_of(state) if has_target else None
        median = table and table.median_error
        values["median_error"] = "" if median is None else f"{median:.3g}"
        values["choice"] = table.choice if table else ""
    return values


def _title_of(editor):
    """What is drawn at the right, or in slices: the target, or how it is compared; "" without."""
    if editor.target is None:
        return ""
    mode, name = editor.comparison.mode, editor.target.name
    if mode == FADE:
        return f"fade: {100 * editor.comparison.share:.0f} % {name}"
    return f"target: {name}" if mode == BESIDE else f"{mode}: {name}"


def _unit_of(editor):
    """The unit of coordinates; "" if it is not known."""
    data = editor.saver.datasets[0]
    units = [*metadata.load(data, LENGTH_UNIT)]
    units += ["mm" for header in _IN_MILLIMETERS if metadata.load(data, header)]
    return units[0] if units else ""


def shape_of(state):
    """The name of the shape of the flat cut that the mouse moves, or "none"."""
    return "none" if state.flat_cut is None else state.flat_cut.name


def _rows(state):
    grips = state.grips
    steps = np.linalg.norm(grips.deformed - grips.rest, axis=1)
    decimals = _decimals(grips.deformed)
    rest, positions = (np.round(x, decimals) + 0.0 for x in (grips.rest, grips.deformed))
    columns = names_of(state), rest, positions, steps, grips.anchored, grips.owner
    return [
        {
            "row": i,
            "name": name,
            "rest": before.tolist(),
            "at": position.tolist(),
            "moved": float(f"{step:.3g}"),
            "fixed": bool(fixed),
            "is_point": bool(owner == POINT),
            "is_mask": bool(owner == MASK),
        }
        for i, (name, before, position, step, fixed, owner) in enumerate(zip(*columns))
    ]


def _pairs(state, scores):
    decimals = min(max(_decimals(state.deformed), 0), 3) if len(state) else 1
    table, rows = table_of(state), []
    for row, name in enumerate(names_of(state)[: len(state)]):
        rest, deformed, error = state.rest[row], state.deformed[row], float(table.errors[row])
        score, refused = scores.get(key_of(state, row), (None, ""))
        rows.append(
            {
                "row": row,
                "name": name,
                "rest": _place(rest, decimals),
                "at": _place(deformed, decimals),
                "distance": float(np.linalg.norm(deformed - rest)),
                "error": None if np.isnan(error) else error,
                "score": None if score is None or np.isnan(score) else score,
                "refused": refused,
                "enabled": bool(state.enabled[row]),
                "outlier": bool(table.are_outliers[row]),
            }
        )
    return rows


def _place(point, decimals):
    return ", ".join(f"{x:.{decimals}f}" for x in np.round(point, decimals) + 0.0)


def _decimals(positions):
    """The number of decimals that distinguishes handles at positions (n, 3)."""
    if len(positions) == 0:
        return 0
    span = np.ptp(positions, axis=0).max() or np.abs(positions).max() or 1.0
    return _DIGITS - int(np.floor(np.log10(span)))
