"""Cuts that move with the material, in float64.

The rest positions decide which control points act on the material: p_i of the control points, and
the origin x of the material. So G(v) is the fixed point x = G(v; damping at x).

The search for x starts at the best fitting affine map. When a step crosses a cut, the map is
continued smoothly behind its face: blocked and unblocked control points are swapped. If the search
ends behind the face, the material on that side of the cut does not reach v, and a second search
starts on the other side. If that ends behind the cut as well, v is void, and the result with the
larger void distance is used.
"""

import numpy as np

from vtk_mls.reference.weights import EvaluationPoints

_MAX_STEPS = 60  # of one search
_TOLERANCE = 1e-13  # of the last step of a search, relative to the size of x


def solve_origin(evaluate, cuts, start, sizes, searches=2):
    """The origins x = G(v; damping at x) of points v, as EvaluationPoints.

    `evaluate` is a function of rows (indices) and their EvaluationPoints: G(v) there. Searches
    begin at `start` (m, 3): 1 on its side only, 2 on the other side, too. Rounding errors are
    relative to the lengths `sizes` (m,).
    """
    best = EvaluationPoints(start.copy(), np.zeros((len(start), len(cuts)), bool))
    distance = np.full(len(start), -np.inf)
    rows = np.arange(len(start))
    for _ in range(searches):
        found = _search(evaluate, cuts, rows, start, sizes)
        reached = void_distance(cuts, found)
        better = reached > distance[rows]
        for result, new in zip((*best, distance), (*found, reached)):
            result[rows[better]] = new[better]
        behind = found.crossed_cuts.any(axis=1)
        rows, start = rows[behind], found.x[behind]
        if len(rows) == 0:
            break
    return best


def void_distance(cuts, at):
    """Distances (m,) of the EvaluationPoints `at` from the cuts; negative behind a crossed cut."""
    result = np.full(len(at.x), np.inf)
    for cut, is_crossed in zip(cuts, at.crossed_cuts.T):
        distance = cut.void_distance(at.x, at.x)
        result = np.minimum(result, np.where(is_crossed, -distance, distance))
    return result


def _search(evaluate, cuts, rows, start, sizes):
    """Fixed points for `rows`, from `start` (rows, 3), as EvaluationPoints."""
    x, crossed_cuts = start.copy(), np.zeros((len(start), len(cuts)), bool)
    residuals, images = np.full_like(x, np.nan), np.full_like(x, np.nan)
    active = np.arange(len(x))
    for _ in range(_MAX_STEPS):
        image = evaluate(rows[active], EvaluationPoints(x[active], crossed_cuts[active]))
        residual = image - x[active]
        moves = np.linalg.norm(residual, axis=1) > _TOLERANCE * sizes[rows[active]]
        active, image, residual = active[moves], image[moves], residual[moves]
        if len(active) == 0:
            break
        # Anderson acceleration with one previous residual
        change = residual - residuals[active]
        share = np.sum(residual * change, axis=1) / np.sum(change**2, axis=1)
        share = np.clip(np.nan_to_num(share), -1, 1)[:, None]
        step = np.where(share == 0, image, image - share * (image - images[active]))
        residuals[active], images[active] = residual, image
        for index, cut in enumerate(cuts):
            crossed_cuts[active, index] ^= cut.blocks(x[active], step)
        x[active] = step
    return EvaluationPoints(x, crossed_cuts)
