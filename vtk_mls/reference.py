"""The float64 specification of the map, in the order of the paper.

Equation numbers are those of Tejada et al., *Interactive Moving Least-Squares Volume Deformation*.
Points are rows here as there: l(x) = (x - q*) M + p*. No speed tricks: the engine is tested
against this module, and this module against the properties that the map must have. Both answer
the same questions with the same signatures.

The weights are in `weights`, the fits of the kinds in the room `kinds`.
"""

from __future__ import annotations

import numpy as np

from vtk_mls import guesses, sampling
from vtk_mls.linear_algebra import finite, unit
from vtk_mls.regions import ON_PLANE
from vtk_mls.weights import WeightedPoints

NAME = "reference (numpy, float64)"

# The search for the inverse: evaluations, smallest part of a step, distances in local units.
_TRIALS, _SMALLEST_SHARE = 64, 0.01
_EXACT, _FOUND = 1e-12, 1e-5
_SAMPLES = 1 << 12  # of the map, where points begin that do not find their place otherwise
_STARTS = 4  # so many of them, one after the other, ...
_WORTH = 0.05  # ... while they find at least this share of what is lost
_CHUNK = 1 << 21  # numbers per temporary array


def backward(deformation, points, progress=None):
    """G(v) (m, 3) at `points` v (m, 3), world coordinates."""
    return points + _answers(deformation, points, "displacement", progress)


def jacobian(deformation, points, progress=None):
    """dG_i/dv_j (m, 3, 3) at `points` v (m, 3)."""
    return _answers(deformation, points, "jacobian", progress)


def forward(deformation, points, progress=None):
    """v - x with G(v) = x at `points` x (m, 3), (m, 3); whether there is one (m,).

    Newton's method from the map with p and q exchanged, and while that leads nowhere, from the
    places among samples that the map brings nearest to x.
    """
    displacement, found = np.full(points.shape, np.nan), np.zeros(len(points), bool)
    box = guesses.usual_bounds(points, guesses.bounds(points))
    for part in _parts(len(points), deformation, progress):
        for region in deformation.regions:
            here = np.abs(region.control_points.local(points[part])).max(axis=1) <= guesses.FARTHEST
            here &= region.holds(deformation.planes, points[part])
            rows = part.start + np.flatnonzero(here)
            if len(rows) == 0:
                continue
            x = points[rows].astype(np.float64)
            close = _FOUND * _size_of(region.control_points, x)
            exchanged = _Fit(deformation, region.exchanged.control_points, x)
            v, left = _newton(deformation, region, x, x + exchanged.displacement())
            tried, samples = np.full(len(x), -1.0), None
            for _ in range(_STARTS):
                (lost,) = np.nonzero(left > close)
                if len(lost) == 0:
                    break
                samples = samples or _samples(deformation, region, box)
                begin, tried[lost] = _nearest_sample(deformation, samples, x[lost], tried[lost])
                again, rest = _newton(deformation, region, x[lost], begin)
                better = rest < left[lost]
                v[lost[better]], left[lost[better]] = again[better], rest[better]
                if (rest <= close[lost]).mean() < _WORTH:
                    break
            displacement[rows], found[rows] = v - x, left <= close
    return displacement, found


def _newton(deformation, region, x, trial):
    """v with G(v) = x, from `trial` on, all (m, 3); distance of G(v) from x (m,), in world units.

    A step that does not come closer, or leads through a cut, is halved. One that is stuck at a cut
    may pass it from then on: the place may be beyond what is hidden from x.
    """
    v = trial = np.where(_is_blocked(deformation, x, trial)[:, None], x, trial)
    left, share, way = np.full(len(x), np.inf), np.ones(len(x)), np.zeros_like(x)
    passing, close = np.zeros(len(x), bool), _EXACT * _size_of(region.control_points, x)
    for step in range(_TRIALS):
        fit = _Fit(deformation, region.control_points, trial)
        rest = x - trial - fit.displacement()
        distance = np.linalg.norm(rest, axis=1)
        closer, stopped = distance < left, np.zeros(len(x), bool)
        if step > 0:
            stopped = closer & ~passing & _is_blocked(deformation, x, trial)
        closer &= ~stopped
        v, left = np.where(closer[:, None], trial, v), np.where(closer, distance, left)
        share = np.where(closer, 1, share / 2)
        stuck = stopped & (share <= _SMALLEST_SHARE)
        passing |= stuck
        share[stuck] = 1
        moving = (left > close) & (share > _SMALLEST_SHARE)
        if not moving.any():
            break
        turn = closer & moving
        jacobian = np.where(turn[:, None, None], fit.jacobian(), np.eye(3))
        newton = (np.linalg.pinv(finite(jacobian)) @ rest[:, :, None])[:, :, 0]
        way = np.where(turn[:, None], newton, way)
        trial = v + share[:, None] * way
    cut_off = _is_blocked(deformation, x, v)
    for plane, side in zip(deformation.planes, region.sides):
        cut_off |= side * plane.height(v) < -ON_PLANE * _size_of(region.control_points, x)
    return v, np.where(cut_off, np.inf, left)


def _size_of(control_points, x):
    """What is left of a search at `x` (m, 3) is relative to: (m,), world units."""
    return np.maximum(control_points.scale, np.abs(x - control_points.centre).max(axis=1))


def _is_blocked(deformation, x, v):
    """Whether a cut that one can go round is between `x` and `v` (m, 3)."""
    blocks = [cut.blocks(x, v) for cut in deformation.obstacles]
    return np.any(blocks, axis=0) if blocks else np.zeros(len(x), bool)


def _samples(deformation, region, box):
    """Places v (m, 3) all round where the map is right side out, and their G(v) (m, 3)."""
    control_points = region.control_points
    box = guesses.joined(box, guesses.bounds(control_points.deformed))
    v = guesses.Lattice.over(guesses.padded(box, 0.1), _SAMPLES).points()
    v = v[region.holds(deformation.planes, v)]
    fit = _Fit(deformation, control_points, v)
    upright = np.linalg.det(fit.jacobian()) > 0
    return v[upright], (v + fit.displacement())[upright]


def _nearest_sample(deformation, samples, x, tried):
    """For each of `x` (m, 3) the v among `samples` whose G(v) comes nearest; how near (m,).

    But not as near as `tried` (m,), or nearer.
    """
    best, nearest = x.copy(), np.full(len(x), np.inf)
    for v, image in zip(*samples):
        distance = np.linalg.norm(x - image, axis=1)
        nearer = (distance < nearest) & (distance > tried)
        nearer[nearer] = ~_is_blocked(deformation, x[nearer], v[None])
        best[nearer], nearest[nearer] = v, distance[nearer]
    return best, nearest


def displacement_field(deformation, grid, progress=None):
    """G(v) - v (nz, ny, nx, 3) float32 at points v of `grid`, world units; the void distance."""
    displacement = np.empty((grid.size, 3), dtype=np.float32)
    void_distance = np.empty(grid.size, dtype=np.float32) if deformation.cuts else None
    for part in _parts(grid.size, deformation, progress):
        v = grid.points(part.start, part.stop)
        moved = _answers(deformation, v, "displacement")
        displacement[part] = moved
        if deformation.cuts:
            void_distance[part] = _void_distance(deformation, v, v + moved)
    void_distance = void_distance.reshape(grid.shape) if deformation.cuts else None
    return displacement.reshape(*grid.shape, 3), void_distance


def jacobian_field(deformation, grid, progress=None):
    """(dG/dv)^T (nz, ny, nx, 3, 3) float32 at the points v of `grid`."""
    result = np.empty((grid.size, 3, 3), dtype=np.float32)
    for part in _parts(grid.size, deformation, progress):
        v = grid.points(part.start, part.stop)
        result[part] = _answers(deformation, v, "jacobian").swapaxes(1, 2)
    return result.reshape(*grid.shape, 3, 3)


def resample(deformation, arrays, source, target, methods, background, continued, progress=None):
    """Each of `arrays` on the grid `source`, deformed, at the points of the grid `target`."""
    results = [np.empty(target.shape + a.shape[3:], a.dtype) for a in arrays]
    for part, index in _source_index(deformation, source, target, continued, progress):
        for array, method, result in zip(arrays, methods, results):
            flat = result.reshape(-1, *array.shape[3:])
            flat[part] = sampling.sample(array, index, method, background, source)
    return results


def source_bounds(deformation, source, target, continued, progress=None):
    """Lowest and highest index (2, 3) of `source.whole` that points of `target` come from."""
    bounds = sampling.NO_BOUNDS
    for _, index in _source_index(deformation, source, target, continued, progress):
        bounds = sampling.joined_bounds(bounds, index, source.whole.dimensions)
    return bounds


def _source_index(deformation, source, target, continued, progress):
    """Parts of `target`, and where they come from: indices (m, 3) of `source.whole`."""
    matrix, offset = target.whole.index_transform(source.whole)
    to_index = np.linalg.inv(source.index_to_world)
    for part in _parts(target.size, deformation, progress):
        v = target.points(part.start, part.stop)
        moved = _answers(deformation, v, "displacement")
        index = target.indices(part.start, part.stop) + target.first
        index = index @ matrix.T + offset + moved @ to_index.T
        if deformation.cuts and not continued:
            index[_void_distance(deformation, v, v + moved) < 0] = -np.inf
        yield part, index


def resample_gradients(
    deformation, vectors, source, target, method, continued, normalise, progress=None
):
    """J_G^T n(G(v)) (nz, ny, nx, 3) float32 for `vectors` n, float32; the void distance."""
    ways = (vectors,), source, target, (method,), 0.0, continued, progress
    (moved,) = resample(deformation, *ways)
    result = np.einsum("...ij,...j->...i", jacobian_field(deformation, target), moved)
    if normalise:
        result = unit(result)
    _, void_distance = displacement_field(deformation, target)
    return result.astype(np.float32), void_distance


def _void_distance(deformation, v, origin):
    return np.min([cut.void_distance(v, origin) for cut in deformation.cuts], axis=0)


def _answers(deformation, points, question, progress=None):
    """The displacement or the Jacobian at `points`, region by region."""
    result = np.empty((len(points), 3, 3) if question == "jacobian" else points.shape)
    for part in _parts(len(points), deformation, progress):
        v, answers = points[part], result[part]
        for region in deformation.regions:
            here = region.holds(deformation.planes, v)
            if here.any():
                fit = _Fit(deformation, region.control_points, v[here])
                answers[here] = getattr(fit, question)()
    return result


def _parts(count, deformation, progress):
    """Slices of at most `_CHUNK` numbers per control point and function."""
    numbers = max(
        len(c) * max(c.kind.functions(c) + 3, 6)
        for c in (region.control_points for region in deformation.regions)
    )
    step = max(1, _CHUNK // numbers)
    for start in range(0, count, step):
        yield slice(start, min(count, start + step))
        if progress is not None:
            progress(min(1.0, (start + step) / count))


class _Fit:
    """The weighted fit of Eq. 2 for each of the places v (m, 3)."""

    def __init__(self, deformation, control_points, v):
        self.weighted = WeightedPoints(deformation, control_points, v)
        self.fit = control_points.kind.fit(self.weighted)

    def jacobian(self):
        """dG/dv: the derivative of l at fixed weights, and of l by the weights.

        The weights enter the optimal fit only through each control point's residual, so
        their part is a sum of dw_i times the influence of control point i on the value.
        """
        through_weights = np.einsum("mic,mia->mca", self.fit.influence(), self.weighted.dw)
        at_rest = self.weighted.at_rest[:, None, None]
        return np.where(at_rest, np.eye(3), self.fit.linear + through_weights)

    def displacement(self):
        """G(v) - v = l(v) - v, Eq. 4 (rotations) and Eq. 26 (affine and polynomial)."""
        return np.where(self.weighted.at_rest[:, None], 0, self.fit.displacement)
