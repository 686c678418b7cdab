"""Cuts that belong to the material, in float64.

Which control points act on it is decided in the undeformed space: a cut sees control point i at
p_i, and the material at its own place x. So G(v) is the fixed point x = G(v; damping as seen from
x).

The search for x begins where the affine map that fits all control points best has it. A step that
passes a cut goes on as if the cut were still ahead: what blocks is exchanged, and the map continued
smoothly behind the face. If it ends there, the material on that side of the cut does not reach v;
the other side gets a search of its own, from that place. If that ends behind the cut, too, v is
void, and the better of the two counts.
"""

from __future__ import annotations

import numpy as np

from vtk_mls.reference.weights import View

_ROUNDS = 60  # of one search
_SETTLED = 1e-13  # next to the size of x: a step of the search that ends it


def settled(evaluate, cuts, start, sizes, searches=2):
    """How the cuts see what is at some points v in the end.

    Parameters
    ----------
    evaluate : function of rows (indices) and a View of them
        G(v) for these of the points: (rows, 3).
    cuts : sequence of Obstacle
    start : (m, 3) float64, world coordinates
        Where the searches begin.
    sizes : (m,) float64, world units
        What rounding is relative to.
    searches : int
        1 where only the material on the side where the search starts is wanted.

    Returns
    -------
    View
    """
    best = View(start.copy(), np.zeros((len(start), len(cuts)), bool))
    distance = np.full(len(start), -np.inf)
    rows = np.arange(len(start))
    for _ in range(searches):
        found = _search(evaluate, cuts, rows, start, sizes)
        reached = void_distance(cuts, found)
        better = reached > distance[rows]
        for kept, new in zip((*best, distance), (*found, reached)):
            kept[rows[better]] = new[better]
        behind = found.passed.any(axis=1)
        rows, start = rows[behind], found.x[behind]
        if len(rows) == 0:
            break
    return best


def void_distance(cuts, view):
    """How far the material of a View is from the cuts: (m,); below 0 behind one of them."""
    result = np.full(len(view.x), np.inf)
    for cut, passed in zip(cuts, view.passed.T):
        distance = cut.void_distance(view.x, view.x)
        result = np.minimum(result, np.where(passed, -distance, distance))
    return result


def _search(evaluate, cuts, rows, start, sizes):
    """The fixed points for `rows` that searches from `start` (rows, 3) find, as a View."""
    x, passed = start.copy(), np.zeros((len(start), len(cuts)), bool)
    residuals, images = np.full_like(x, np.nan), np.full_like(x, np.nan)
    going = np.arange(len(x))
    for _ in range(_ROUNDS):
        image = evaluate(rows[going], View(x[going], passed[going]))
        residual = image - x[going]
        moves = np.linalg.norm(residual, axis=1) > _SETTLED * sizes[rows[going]]
        going, image, residual = going[moves], image[moves], residual[moves]
        if len(going) == 0:
            break
        # two residuals tell how far a step leads
        change = residual - residuals[going]
        share = np.sum(residual * change, axis=1) / np.sum(change**2, axis=1)
        share = np.clip(np.nan_to_num(share), -1, 1)[:, None]
        step = np.where(share == 0, image, image - share * (image - images[going]))
        residuals[going], images[going] = residual, image
        for number, cut in enumerate(cuts):
            passed[going, number] ^= cut.blocks(x[going], step)
        x[going] = step
    return View(x, passed)
