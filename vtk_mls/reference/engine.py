"""The float64 specification of the map, in the order of the paper.

Equation numbers are those of Tejada et al., *Interactive Moving Least-Squares Volume Deformation*.
Points are rows here as there: l(x) = (x - q*) M + p*. No speed tricks: the engine is tested
against this module, and this module against the properties that the map must have. Both answer
the questions of `engine.protocol.Engine`.

The weights are in `weights`, the fits of the kinds in the room `kinds`.
"""

from __future__ import annotations

import numpy as np

from vtk_mls.base import interpolation
from vtk_mls.base.linear_algebra import finite
from vtk_mls.base.progress import SILENT
from vtk_mls.model.regions import ON_PLANE
from vtk_mls.queries import first_guesses as guesses
from vtk_mls.queries import vector_fields, void_cells
from vtk_mls.reference import rest_frame
from vtk_mls.reference.rest_frame import settled
from vtk_mls.reference.weights import View, WeightedPoints

NAME = "reference (numpy, float64)"

# The search for the inverse: evaluations; smallest share of a Newton step; residuals at which the
# iteration ends and at which the inverse counts as found, local units.
_TRIALS, _SMALLEST_SHARE = 64, 0.01
_EXACT, _FOUND = 1e-12, 1e-5
_SAMPLES = 1 << 12  # of the map, from which Newton's method starts again where it fails
_STARTS = 4  # so many of them, one after the other
_WIDER = 2  # levels beyond that of x, from which there are starts, too: v may lie there
_CHUNK = 1 << 21  # numbers per temporary array


def backward(deformation, points, progress=SILENT):
    return points + _answers(deformation, points, progress)[0]


def void_distance(deformation, points, progress=SILENT):
    return _answers(deformation, points, progress)[1]


def origins_from(deformation, points, starts, progress=SILENT):
    origins, void_distance = np.empty(points.shape), np.empty(len(points))
    for part in progress.over(_parts(len(points), deformation)):
        for region in deformation.regions:
            rows = part.start + np.flatnonzero(region.holds(deformation.planes, starts[part]))
            v = points[rows]
            displacement, void_distance[rows], _ = _in_region(deformation, region, v, starts[rows])
            origins[rows] = v + displacement
    return origins, void_distance


def jacobian(deformation, points, progress=SILENT, origins=None):
    if origins is None:
        return _answers(deformation, points, progress, with_jacobian=True)[2]
    result = np.empty((len(points), 3, 3))
    for part in progress.over(_parts(len(points), deformation)):
        for region in deformation.regions:
            rows = part.start + np.flatnonzero(region.holds(deformation.planes, origins[part]))
            view = _seen_from(deformation, origins[rows])
            result[rows] = _Fit(deformation, region.control_points, points[rows], view).jacobian()
    return result


def forward(deformation, points, progress=SILENT):
    displacement, found = np.full(points.shape, np.nan), np.zeros(len(points), bool)
    for part in progress.over(_parts(len(points), deformation)):
        for region in deformation.regions:
            here = np.abs(region.control_points.local(points[part])).max(axis=1) <= guesses.FARTHEST
            here &= region.holds(deformation.planes, points[part])
            rows = part.start + np.flatnonzero(here)
            if len(rows) > 0:
                x = points[rows].astype(np.float64)
                v, residual = _inverse(deformation, region, x)
                close = _FOUND * _size_of(region.control_points, x)
                displacement[rows], found[rows] = v - x, residual <= close
    return displacement, found


def _inverse(deformation, region, x):
    """v with G(v) = x for x (m, 3); the residuals |G(v) - x| (m,), in world units.

    Newton's method starts from the map with p and q exchanged, and if that fails, where the cuts
    belong to the material from other `motions`, then from the samples of the map whose images are
    nearest to x. Nothing that is done for a point depends on the other points.
    """
    control_points = region.control_points
    close = _FOUND * _size_of(control_points, x)
    exchanged = _Fit(deformation.exchanged_frame, region.exchanged.control_points, x)
    v, residual = _newton(deformation, region, x, x + exchanged.displacement())

    def lost():
        return np.flatnonzero(residual > close)

    def restart(rows, start):
        again, remaining = _newton(deformation, region, x[rows], start)
        better = remaining < residual[rows]
        v[rows[better]], residual[rows[better]] = again[better], remaining[better]
        return remaining <= close[rows]

    if deformation.in_rest_frame and len(rows := lost()) > 0:
        for motion in guesses.motions(control_points.rest, control_points.deformed, x[rows]):
            restart(rows, x[rows] + motion)
    rows, box = lost(), guesses.usual_box(control_points)
    levels = guesses.levels(box, control_points.local(x[rows] - control_points.mean_displacement))
    for level in np.unique(levels):
        remaining = rows[levels == level]
        for wider in range(_WIDER + 1):
            if len(remaining) == 0:
                break
            samples = _samples(deformation, region, guesses.doubled(box, level + wider))
            tried = np.full(len(remaining), -1.0)
            for _ in range(_STARTS):
                start, tried = _nearest_sample(deformation, samples, x[remaining], tried)
                is_lost = ~restart(remaining, start)
                remaining, tried = remaining[is_lost], tried[is_lost]
    return v, residual


def _newton(deformation, region, x, trial):
    """v with G(v) = x, from `trial` on, all (m, 3); the residuals |G(v) - x| (m,), in world units.

    Backtracking halves a step that does not reduce the residual. Steps may cross cuts: what counts
    is where the search ends.
    """
    view = _seen_from(deformation, x)
    trial = np.where(_is_blocked(deformation, x, trial)[:, None], x, trial)
    v = trial.copy()
    residual, share, step = np.full(len(x), np.inf), np.ones(len(x)), np.zeros_like(x)
    close = _EXACT * _size_of(region.control_points, x)
    moving = np.arange(len(x))
    for _ in range(_TRIALS):
        fit = _Fit(deformation, region.control_points, trial[moving], _rows_of(view, moving))
        error = x[moving] - trial[moving] - fit.displacement()
        distance = np.linalg.norm(error, axis=1)
        closer = distance < residual[moving]
        v[moving[closer]], residual[moving[closer]] = trial[moving[closer]], distance[closer]
        share[moving] = np.where(closer, 1, share[moving] / 2)
        goes_on = (residual[moving] > close[moving]) & (share[moving] > _SMALLEST_SHARE)
        if not goes_on.any():
            break
        jacobian = finite(fit.material_jacobian()[goes_on & closer])
        newton = (np.linalg.pinv(jacobian) @ error[goes_on & closer][:, :, None])[:, :, 0]
        step[moving[goes_on & closer]] = newton
        moving = moving[goes_on]
        trial[moving] = v[moving] + share[moving, None] * step[moving]
    cut_off = _is_blocked(deformation, x, v)
    planes = [] if deformation.in_rest_frame else deformation.planes
    for plane, side in zip(planes, region.sides):
        cut_off |= side * plane.height(v) < -ON_PLANE * _size_of(region.control_points, x)
    return v, np.where(cut_off, np.inf, residual)


def _seen_from(deformation, x):
    """How cuts that belong to the material see it at `x` (m, 3), as a View; None for others."""
    if not deformation.in_rest_frame:
        return None
    return View(x, np.zeros((len(x), len(deformation.obstacles)), bool))


def _rows_of(view, rows):
    """The `rows` of a View, or None for None."""
    return view and View(view.x[rows], view.passed[rows])


def _is_parted(deformation, x, other):
    """Whether a cut that one can go round is between `x` (m, 3) and another place."""
    blocks = [cut.blocks(x, other) for cut in deformation.obstacles]
    return np.any(blocks, axis=0) if blocks else np.zeros(len(x), bool)


def _size_of(control_points, x):
    """Length that residual tolerances at `x` (m, 3) are relative to: (m,), world units."""
    return np.maximum(control_points.scale, np.abs(x - control_points.centre).max(axis=1))


def _is_blocked(deformation, x, v):
    """Whether a cut that one can go round, and that stays, is between `x` and `v` (m, 3)."""
    if deformation.in_rest_frame:
        return np.zeros(len(x), bool)
    return _is_parted(deformation, x, v)


def _samples(deformation, region, box):
    """Points v (m, 3) over a `box` (2, 3), local units, with det(J) > 0; G(v) (m, 3)."""
    control_points = region.control_points
    local = guesses.cubic_grid(box, _SAMPLES).points()
    v = control_points.centre + control_points.scale * local
    v = v[region.holds(deformation.moved_planes, v)]
    displacement, void_distance, jacobian = _in_region(deformation, region, v, with_jacobian=True)
    upright = np.linalg.det(jacobian) > 0
    if deformation.in_rest_frame:
        upright &= void_distance >= 0
    return v[upright], (v + displacement)[upright]


def _nearest_sample(deformation, samples, x, tried):
    """For each of `x` (m, 3) the v among `samples` whose G(v) is nearest; its distance (m,).

    Only those farther than `tried` (m,) count.
    """
    best, nearest = x.copy(), np.full(len(x), np.inf)
    v, images = samples
    seen = images if deformation.in_rest_frame else v
    for row, point in enumerate(x):
        distance = np.linalg.norm(point - images, axis=1)
        distance[distance <= tried[row]] = np.inf
        while (distance < np.inf).any():
            i = distance.argmin()
            if not _is_parted(deformation, point[None], seen[i][None])[0]:
                best[row], nearest[row] = v[i], distance[i]
                break
            distance[i] = np.inf
    return best, nearest


def displacement_field(deformation, grid, progress=SILENT):
    displacement = np.empty((grid.size, 3), dtype=np.float32)
    void_distance = np.empty(grid.size, dtype=np.float32) if deformation.cuts else None
    for part in progress.over(_parts(grid.size, deformation)):
        v = grid.points(part.start, part.stop)
        displacement[part], distance, _ = _answers(deformation, v)
        if deformation.cuts:
            void_distance[part] = distance
    void_distance = void_distance.reshape(grid.shape) if deformation.cuts else None
    return displacement.reshape(*grid.shape, 3), void_distance


def jacobian_field(deformation, grid, progress=SILENT):
    result = np.empty((grid.size, 3, 3), dtype=np.float32)
    for part in progress.over(_parts(grid.size, deformation)):
        v = grid.points(part.start, part.stop)
        result[part] = _answers(deformation, v, with_jacobian=True)[2].swapaxes(1, 2)
    return result.reshape(*grid.shape, 3, 3)


def resample(
    deformation,
    arrays,
    sampling,
    progress=SILENT,
    void_distance=None,
    covariant=None,
):
    covariant = covariant or {}
    results = [np.empty(sampling.target.shape + a.shape[3:], a.dtype) for a in arrays]
    methods = sampling.methods(len(arrays))
    for part, index, distance, jacobian in _sources(
        deformation, sampling, progress, with_jacobian=bool(covariant)
    ):
        if deformation.cuts and void_distance is not None:
            void_distance[part] = distance
        for number, (array, method, result) in enumerate(zip(arrays, methods, results)):
            flat = result.reshape(-1, *array.shape[3:])
            background = 0.0 if number in covariant else sampling.background
            flat[part] = interpolation.sample(array, index, method, background, sampling.source)
            if number in covariant:
                transposed = jacobian.swapaxes(1, 2)
                flat[part] = vector_fields.covariant(flat[part], transposed, covariant[number])
    return results


def gradient(array, grid, progress=SILENT):
    return vector_fields.gradient(array, grid, progress)


def sample(array, index, method, background, source):
    return interpolation.sample(array, index, method, background, source)


def void_by_corners(void_distance, min_distance, progress=SILENT):
    return void_cells.by_corners(void_distance, min_distance)


def void_distance_listed(deformation, grid, indices, progress=SILENT):
    result = np.empty(len(indices), np.float32)
    for part in progress.over(_parts(len(indices), deformation)):
        result[part] = _answers(deformation, grid.numbered(indices[part]))[1]
    return result


def source_bounds(deformation, sampling, progress=SILENT):
    bounds = interpolation.NO_BOUNDS
    for _, index, *_ in _sources(deformation, sampling, progress):
        bounds = interpolation.joined_bounds(bounds, index, sampling.source.whole)
    return bounds


def _sources(deformation, sampling, progress, with_jacobian=False):
    """Parts of the target, and where they come from: indices (m, 3) of the whole source.

    And the void distances there, and Jacobians (m, 3, 3) or None.
    """
    source, target = sampling.source, sampling.target
    matrix, offset = target.whole.index_transform(source.whole)
    to_index = source.world_to_index
    for part in progress.over(_parts(target.size, deformation)):
        v = target.points(part.start, part.stop)
        moved, void_distance, jacobian = _answers(deformation, v, with_jacobian=with_jacobian)
        index = target.indices(part.start, part.stop) + target.first
        index = index @ matrix.T + offset + moved @ to_index.T
        if deformation.cuts and not sampling.continues:
            index[void_distance < 0] = -np.inf
        yield part, index, void_distance, jacobian


def _answers(deformation, points, progress=SILENT, with_jacobian=False):
    """Displacements (m, 3), void distances (m,) and Jacobians (m, 3, 3) or None at `points`."""
    displacement, void_distance = np.empty(points.shape), np.full(len(points), -np.inf)
    jacobian = np.empty((len(points), 3, 3)) if with_jacobian else None
    results = displacement, void_distance, jacobian
    for part in progress.over(_parts(len(points), deformation)):
        v = points[part]
        held = [region.holds(deformation.moved_planes, v) for region in deformation.regions]
        for region, here in zip(deformation.regions, held):
            _take(deformation, region, points, part.start + np.flatnonzero(here), results)
        if not deformation.has_rivals:
            continue
        for region, here in zip(deformation.regions, held):  # where there is nothing as yet
            rows = part.start + np.flatnonzero(~here & (void_distance[part] < 0))
            _take(deformation, region, points, rows, results)
    return results


def _take(deformation, region, points, rows, results):
    """Take the answers of a region in those `rows` where its void distance is larger."""
    if len(rows) == 0:
        return
    jacobian = results[2]
    with_jacobian = jacobian is not None
    found = _in_region(deformation, region, points[rows], with_jacobian=with_jacobian)
    better = ~(found[1] <= results[1][rows])
    for result, new in zip(results, found):
        if result is not None:
            result[rows[better]] = new[better]


def _in_region(deformation, region, v, start=None, with_jacobian=False):
    """What `_answers` says of the material of one region, on one side if there is a `start`."""
    control_points, cuts = region.control_points, deformation.obstacles

    def fit_of(rows, view):
        return _Fit(deformation, control_points, v[rows], view)

    if deformation.in_rest_frame and cuts:
        searches = 1
        if start is None:
            matrix, offset = control_points.affine
            # not by BLAS, whose rounding depends on the number of points
            start, searches = (v[:, None] * matrix).sum(axis=2) + offset, 2
        view = settled(
            lambda rows, view: v[rows] + fit_of(rows, view).displacement(),
            cuts,
            start,
            _size_of(control_points, v),
            searches,
        )
        fit, void_distance = fit_of(slice(None), view), rest_frame.void_distance(cuts, view)
    else:
        fit, void_distance = fit_of(slice(None), None), np.full(len(v), np.inf)
    displacement = fit.displacement()
    origin = v + displacement
    for cut in () if deformation.in_rest_frame else cuts:
        void_distance = np.minimum(void_distance, cut.void_distance(v, origin))
    for plane, side in zip(deformation.planes, region.sides):
        void_distance = np.minimum(void_distance, side * plane.height(origin))
    return displacement, void_distance, fit.jacobian() if with_jacobian else None


def _parts(count, deformation):
    """Slices of at most `_CHUNK` numbers per control point and function."""
    numbers = max(
        len(c) * max(c.kind.functions(c) + 3, 6)
        for c in (region.control_points for region in deformation.regions)
    )
    step = max(1, _CHUNK // numbers)
    return [slice(start, min(count, start + step)) for start in range(0, count, step)]


class _Fit:
    """The weighted fit of Eq. 2 for each of the places v (m, 3).

    A place that is alone is evaluated twice: numpy.einsum sums along other axes, and rounds
    otherwise, where there is one.
    """

    def __init__(self, deformation, control_points, v, view=None):
        self.count = len(v)
        if self.count == 1:
            v, view = np.repeat(v, 2, axis=0), _rows_of(view, [0, 0])
        self.weighted = WeightedPoints(deformation, control_points, v, view)
        self.fit = control_points.kind.fit(self.weighted)

    def jacobian(self):
        """dG/dv: for G(v) = x the derivative of x = G(v; damping as seen from x)."""
        if not self.weighted.dw_dx.any():
            return self.material_jacobian()
        by_x = np.where(self._at_rest, 0, self._through(self.weighted.dw_dx))[: self.count]
        return np.linalg.pinv(finite(np.eye(3) - by_x)) @ self.material_jacobian()

    def material_jacobian(self):
        """The derivative of l at fixed weights, and of l by the weights, for the same material.

        The weights enter the optimal fit only through each control point's residual, so
        their part is a sum of dw_i times the influence of control point i on the value.
        """
        linear = self.fit.linear + self._through(self.weighted.dw)
        return np.where(self._at_rest, np.eye(3), linear)[: self.count]

    @property
    def _at_rest(self):
        return self.weighted.at_rest[:, None, None]

    def _through(self, slopes):
        """The change of l with weights that have `slopes` (m, n, 3)."""
        return np.einsum("mic,mia->mca", self.fit.influence(), slopes)

    def displacement(self):
        """G(v) - v = l(v) - v, Eq. 4 (rotations) and Eq. 26 (affine and polynomial)."""
        at_rest = self.weighted.at_rest[:, None]
        return np.where(at_rest, 0, self.fit.displacement)[: self.count]
