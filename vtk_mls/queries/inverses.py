"""Parts of the search for the inverse of a map, which the engines share.

Some points need no search. First guesses come from boxes, grids and displacements.
"""

import numpy as np

from vtk_mls.base.grid import Grid
from vtk_mls.base.linear_algebra import finite
from vtk_mls.model.limits import are_fixed

# Largest distance from the control points of inverses, in local units: the kernels' float32 squares
# it, and takes much larger squares for unreachable.
FARTHEST = 1e10
_MAX_SAMPLES = 1 << 12  # of points, to find outliers
_QUANTILES = 0.05, 0.95  # between which samples are usual
_OUTLIER_MARGIN = 4  # sizes of the box of usual samples; points beyond are outliers
_PADDING = 0.1  # of a box, as a fraction of its largest side
_MAX_COORDINATE = np.finfo(float).max / 8  # coordinates with finite differences
_MAX_PAIRS = 1 << 22  # of points and control points in one array
SAMPLES = 1 << 12  # of the map, to restart Newton's method where it fails
MAX_RESTARTS = 4  # in the samples of a level
EXTRA_LEVELS = 2  # beyond that of x with samples, for v may lie there
_TOLERANCE = 1e-5  # of inverses without a search, as a fraction of the size
_MAX_EVALUATIONS = 64  # of Newton's method
_CONVERGED = 1e-12  # residual that ends the iteration, as a fraction of the size
_MIN_SHARE = 0.01  # of a Newton step, by backtracking


def direct_inverses(backward, deformation, points):
    """Rows (k,) of `points` (m, 3) and their displacements (k, 3), world units.

    A search may find another place to which the map brings the same material where it folds.
    `backward` is the map, a function of points (k, 3).
    """
    indices, displacements = [np.zeros(0, np.int64)], [np.zeros((0, 3))]
    for region in deformation.handle_set.regions:
        low, high = region.shape.bounds
        rows = np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))
        rows = rows[region.shape.distance(points[rows].astype(float))[0] == 0]
        x = points[rows].astype(float)
        v = region.moved(x)
        # not where another region, a mask or a face is at the same place
        tolerance = _TOLERANCE * max(r.control_points.scale for r in deformation.regions)
        met = np.linalg.norm(backward(v) - x, axis=1) <= tolerance if len(rows) else rows == 0
        indices.append(rows[met])
        displacements.append((v - x)[met])
    if deformation.limits:
        fixed = np.flatnonzero(are_fixed(deformation.limits, points))
        indices.append(fixed)
        displacements.append(np.zeros((len(fixed), 3)))
    return np.concatenate(indices), np.concatenate(displacements)


def cubic_grid(box, nodes):
    """A grid with about `nodes` points and cubic cells over the `box` (2, 3), which may be flat.

    It has at least two points along each axis.
    """
    low, high = np.clip(box, -_MAX_COORDINATE, _MAX_COORDINATE)
    size = np.maximum(high - low, 1e-3 * ((high - low).max() or 1))
    step = float(np.exp(np.log(size / size.max()).mean()) * size.max() / np.cbrt(nodes))
    dimensions = np.maximum(np.ceil((high - low) / step).astype(int) + 1, 2)
    return Grid(dimensions, low, np.full(3, step))


def bounds(points):
    """Lowest and highest coordinates (2, 3) of the finite `points` (m, 3); 0 without points."""
    if len(points) == 0:
        return np.zeros((2, 3))
    # column by column: numpy takes many times longer along the first axis
    box = np.array([(x.min(), x.max()) for x in points.T], dtype=np.float64).T
    return box if np.isfinite(box).all() else bounds(points[np.isfinite(points).all(axis=1)])


def usual_bounds(points, box):
    """The `bounds` of `points` (m, 3) without outliers; `box` (2, 3) are those with outliers."""
    samples = points[:: max(1, len(points) // _MAX_SAMPLES)]
    samples = samples[np.isfinite(samples).all(axis=1)].astype(np.float64)
    if len(samples) == 0:
        return box
    low, high = np.quantile(samples, _QUANTILES, axis=0)
    usual = padded(np.array([low, high]), _OUTLIER_MARGIN)
    if (usual[0] <= box[0]).all() and (box[1] <= usual[1]).all():
        return box
    is_usual = ((usual[0] <= samples) & (samples <= usual[1])).all(axis=1)
    return padded(bounds(samples[is_usual]), _PADDING) if is_usual.any() else box


def usual_box(control_points):
    """The cube (2, 3), local units, around the deformed control points, which `levels` double.

    It does not depend on the points of a question.
    """
    low, high = bounds(control_points.local(control_points.handles.positions[1]))
    half = (0.5 + _PADDING) * ((high - low).max() or 1)
    return (low + high) / 2 + half * np.array([[-1], [1]])


def levels(box, points):
    """How often a `box` (2, 3) must be doubled about its center to contain `points` (m, 3)."""
    offset = np.abs(points - box.mean(axis=0)) / (np.ptp(box, axis=0) / 2)
    share, power = np.frexp(offset.max(axis=1))  # share in [0.5, 1)
    return np.maximum(power - (share == 0.5), 0)


def doubled(box, level):
    """A `box` (2, 3), doubled `level` times about its center."""
    center = box.mean(axis=0)
    return center + 2.0**level * (box - center)


def padded(box, share):
    """`box` (2, 3) with a margin of `share` times its largest side."""
    return box + share * np.ptp(box, axis=0).max() * np.array([[-1], [1]])


def motions(rest, deformed, points):
    """Possible displacements v - x (m, 3) of material next to a cut, for x of `points` (m, 3).

    A control point dragged along a cut moves only the material on its own side. The map with p and
    q swapped is between both sides, where there may be no material. Yields the mean displacement of
    the control points, then that of the nearest control point.
    """
    displacements = deformed - rest
    yield np.tile(displacements.mean(axis=0), (len(points), 1))
    step = max(1, _MAX_PAIRS // len(rest))
    nearest = [
        np.square(part[:, None] - rest).sum(axis=2).argmin(axis=1)
        for part in np.split(points, range(step, len(points), step))
    ]
    yield displacements[np.concatenate(nearest)]


def newton(evaluate, x, guess, size):
    """v (m, 3) with v + d(v) = x from a first guess of v, and the residuals |v + d(v) - x| (m,).

    `evaluate(v, rows)` returns the displacements d (k, 3) at v (k, 3) for `rows` (k,) of x, and a
    function without arguments for the Jacobians of v + d(v), (k, 3, 3). The tolerance is relative
    to the lengths `size` (m,). Backtracking halves a step that does not reduce the residual.
    """
    candidate, v = guess.copy(), guess.copy()
    residual, share, step = np.full(len(x), np.inf), np.ones(len(x)), np.zeros_like(x)
    tolerance = _CONVERGED * size
    active = np.arange(len(x))
    for _ in range(_MAX_EVALUATIONS):
        displacement, jacobians = evaluate(candidate[active], active)
        error = x[active] - candidate[active] - displacement
        distance = np.linalg.norm(error, axis=1)
        closer = distance < residual[active]
        v[active[closer]], residual[active[closer]] = candidate[active[closer]], distance[closer]
        share[active] = np.where(closer, 1, share[active] / 2)
        goes_on = (residual[active] > tolerance[active]) & (share[active] > _MIN_SHARE)
        if not goes_on.any():
            break
        new = goes_on & closer
        inverse = np.linalg.pinv(finite(jacobians()[new]))
        step[active[new]] = (inverse @ error[new][:, :, None])[:, :, 0]
        active = active[goes_on]
        candidate[active] = v[active] + share[active, None] * step[active]
    return v, residual
