"""Values of an editor for the panel, as JSON has them."""

from __future__ import annotations

import numpy as np

from vtk_mls import HalfPlane, Plane, Surface
from vtk_mls.editor.grips import MASK, POINT, names_of
from vtk_mls.model.options import values_of as values_of_options

_DIGITS = 5  # after the first digit of the distance between handles


def values_of(editor, previous, look):
    """Values by their names in the page's templates.

    Parameters
    ----------
    editor : Editor
    previous : dict
        The values before; rows do not change while a handle is dragged.
    look : int
        Index of the preset of colors.
    """
    state = editor.state
    values = values_of_options(state)
    looks = max((item.preset_names for item in editor.scene.items), key=len)
    values.update(
        cut=shape_of(state.cuts),
        has_lines=any(isinstance(cut, Surface) for cut in state.cuts),
        selected=editor.selected.tolist(),
        message=editor.message,
        offer=editor.offer,
        status=editor.status,
        looks=looks,
        look=look % len(looks),
        distortion=editor.view.distortion.mode,
        count=len(state),
        has_mask=state.mask is not None,
        is_drawing=editor.is_drawing_curve,
    )
    if editor.document.grabbed is None or "rows" not in previous:
        values["rows"] = _rows(state)
    return values


def shape_of(cuts):
    """The shape of the flat cut that the mouse moves: "plane", "half-plane", or "none"."""
    flat = [cut for cut in cuts if isinstance(cut, (Plane, HalfPlane))]
    if not flat:
        return "none"
    return "plane" if isinstance(flat[-1], Plane) else "half-plane"


def _rows(state):
    """Rows of the handle table: points, regions, nodes of curves, the mask."""
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


def _decimals(positions):
    """The number of decimals that distinguishes handles at positions (n, 3)."""
    if len(positions) == 0:
        return 0
    span = np.ptp(positions, axis=0).max() or np.abs(positions).max() or 1.0
    return _DIGITS - int(np.floor(np.log10(span)))
