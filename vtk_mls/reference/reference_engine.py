"""The float64 specification of the map, in the order of the paper.

Equation numbers are those of Tejada et al., *Interactive Moving Least-Squares Volume Deformation*.
Points are rows as in the paper: l(x) = (x - q*) M + p*. This module implements the interface
`engine.protocol.Engine` without optimizations: the OpenCL engine is tested against it, and it is
tested against the properties of the map. The weights are in `weights`, the fits in
`vtk_mls.model.kinds`.
"""

import functools
import itertools

import numpy as np

from vtk_mls.base import interpolation
from vtk_mls.base.progress import SILENT
from vtk_mls.model.regions import ON_PLANE
from vtk_mls.queries import certificate, inverses, vector_fields, void_cells
from vtk_mls.queries.vector_fields import sampled_parts
from vtk_mls.reference import rest_frame
from vtk_mls.reference.fit import StepFit, fit_of, jacobian_of
from vtk_mls.reference.weights import EvaluationPoints

NAME = "reference (numpy, float64)"

_FOUND = 1e-5  # largest residual of an inverse, in local units
_MAX_VALUES = 1 << 21  # in a temporary array
_POINTS_OF_SEGMENT = 80  # of the quadrature


def backward(deformation, points, progress=SILENT):
    return points + _evaluate(deformation, points, progress)[0]


def void_distance(deformation, points, progress=SILENT):
    return _evaluate(deformation, points, progress)[1]


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
        return _evaluate(deformation, points, progress, with_jacobian=True)[2]
    result = np.empty((len(points), 3, 3))
    for part in progress.over(_parts(len(points), deformation)):
        for region in deformation.regions:
            rows = part.start + np.flatnonzero(region.holds(deformation.planes, origins[part]))
            at = _evaluation_points(deformation, origins[rows])
            fit = fit_of(deformation, region.control_points, points[rows], at)
            result[rows] = jacobian_of(fit)
    return result


def least_determinant(deformation, points, progress=SILENT):
    if deformation.steps_used == 1:
        return np.linalg.det(jacobian(deformation, points, progress))
    result = np.empty(len(points))
    for part in progress.over(_parts(len(points), deformation)):
        v = points[part]
        for region in deformation.regions:
            rows = part.start + np.flatnonzero(region.holds(deformation.moved_planes, v))
            _, _, fit = _fit_in_region(deformation, region, points[rows])
            result[rows] = fit.least_determinant()
    return result


def forward(deformation, points, progress=SILENT):
    displacement, found = np.full(points.shape, np.nan), np.zeros(len(points), bool)
    backward_map = functools.partial(backward, deformation)
    for part in progress.over(_parts(len(points), deformation)):
        for region in deformation.regions:
            distance = np.abs(region.control_points.local(points[part])).max(axis=1)
            mask = (distance <= inverses.FARTHEST) & region.holds(deformation.planes, points[part])
            rows = part.start + np.flatnonzero(mask)
            if len(rows) > 0:
                x = points[rows].astype(np.float64)
                v, residual = _inverse(deformation, region, x)
                close = _FOUND * _size_of(region.control_points, x)
                displacement[rows], found[rows] = v - x, residual <= close
        rows, direct = inverses.direct_inverses(backward_map, deformation, points[part])
        displacement[part.start + rows], found[part.start + rows] = direct, True
    return displacement, found


def _inverse(deformation, region, x):
    """v (m, 3) with G(v) = x for x (m, 3), and the residuals |G(v) - x| (m,), world units."""
    steps = region.control_points.steps(deformation.steps_used)
    if len(steps) == 1:
        return _inverse_of_map(deformation, region, x)
    v, residual = x, np.zeros(len(x))
    for step in steps:
        v, step_residual = _solve_step(deformation, region.sides, step, v, v, x)
        residual += step_residual
    return v, residual


def _inverse_of_map(deformation, region, x):
    """`_inverse` of a map in one step.

    Newton's method starts from the map with p and q swapped. Where it fails, it restarts with cuts
    in the rest frame from other `motions`, then from the samples of the map with the nearest
    images. The result for a point does not depend on the other points.
    """
    control_points = region.control_points
    tolerance = _FOUND * _size_of(control_points, x)
    swapped = StepFit(deformation.with_deformed_cuts, region.swapped.control_points, x)

    def search(x, candidate):
        return _solve_step(deformation, region.sides, control_points, x, candidate, x)

    v, residual = search(x, x + swapped.displacement())

    def unresolved():
        return np.flatnonzero(residual > tolerance)

    def restart(rows, start):
        solution, remaining = search(x[rows], start)
        better = remaining < residual[rows]
        v[rows[better]], residual[rows[better]] = solution[better], remaining[better]
        return remaining <= tolerance[rows]

    if deformation.in_rest_frame and len(rows := unresolved()) > 0:
        for motion in inverses.motions(*control_points.handles.positions, x[rows]):
            restart(rows, x[rows] + motion)
    rows, box = unresolved(), inverses.usual_box(control_points)
    levels = inverses.levels(box, control_points.local(x[rows] - control_points.mean_displacement))
    for level in np.unique(levels):
        remaining = rows[levels == level]
        for extra in range(inverses.EXTRA_LEVELS + 1):
            if len(remaining) == 0:
                break
            samples = _samples(deformation, region, inverses.doubled(box, level + extra))
            min_distance = np.full(len(remaining), -1.0)
            for _ in range(inverses.MAX_RESTARTS):
                start, distance = _nearest_sample(deformation, samples, x[remaining], min_distance)
                is_unresolved = ~restart(remaining, start)
                remaining, min_distance = remaining[is_unresolved], distance[is_unresolved]
    return v, residual


def _solve_step(deformation, sides, control_points, x, candidate, origins):
    """v with G(v) = x, from `candidate`, all (m, 3); the residuals |G(v) - x| (m,), world units.

    G is the map of one step; cuts in the rest frame see from the `origins` (m, 3). Newton steps may
    cross cuts; only the end of the search is checked against them.
    """
    at = _evaluation_points(deformation, origins)
    candidate = np.where(_is_blocked(deformation, x, candidate)[:, None], x, candidate)

    def evaluate(v, rows):
        fit = StepFit(deformation, control_points, v, at and at.rows(rows))
        return fit.displacement(), lambda: fit.jacobians()[0]

    v, residual = inverses.newton(evaluate, x, candidate, _size_of(control_points, x))
    cut_off = _is_blocked(deformation, x, v)
    planes = [] if deformation.in_rest_frame else deformation.planes
    for plane, side in zip(planes, sides):
        cut_off |= side * plane.height(v) < -ON_PLANE * _size_of(control_points, x)
    return v, np.where(cut_off, np.inf, residual)


def _evaluation_points(deformation, x):
    """EvaluationPoints at `x` (m, 3) with no cut crossed; None for cuts in the deformed frame."""
    if not deformation.in_rest_frame:
        return None
    return EvaluationPoints(x, np.zeros((len(x), len(deformation.obstacles)), bool))


def _is_separated(deformation, x, other):
    """Whether a cut with an edge is between `x` (m, 3) and `other`: (m,) bool."""
    blocks = [cut.blocks(x, other) for cut in deformation.obstacles]
    return np.any(blocks, axis=0) if blocks else np.zeros(len(x), bool)


def _size_of(control_points, x):
    """Length that tolerances at `x` (m, 3) are relative to: (m,), world units."""
    return np.maximum(control_points.scale, np.abs(x - control_points.center).max(axis=1))


def _is_blocked(deformation, x, v):
    """Whether a cut with an edge, fixed in the deformed frame, is between `x` and `v` (m, 3)."""
    if deformation.in_rest_frame:
        return np.zeros(len(x), bool)
    return _is_separated(deformation, x, v)


def _samples(deformation, region, box):
    """Points v (m, 3) over a `box` (2, 3), local units, with det(J) > 0; G(v) (m, 3)."""
    control_points = region.control_points
    local = inverses.cubic_grid(box, inverses.SAMPLES).points()
    v = control_points.center + control_points.scale * local
    v = v[region.holds(deformation.moved_planes, v)]
    displacement, void_distance, jacobian = _in_region(deformation, region, v, with_jacobian=True)
    upright = np.linalg.det(jacobian) > 0
    if deformation.in_rest_frame:
        upright &= void_distance >= 0
    return v[upright], (v + displacement)[upright]


def _nearest_sample(deformation, samples, x, min_distance):
    """The sample v (m, 3) whose G(v) is nearest to each `x` (m, 3), and its distance (m,).

    Only samples farther than `min_distance` (m,) count.
    """
    best, nearest = x.copy(), np.full(len(x), np.inf)
    v, images = samples
    positions = images if deformation.in_rest_frame else v  # in the frame of the cuts
    for row, point in enumerate(x):
        distance = np.linalg.norm(point - images, axis=1)
        distance[distance <= min_distance[row]] = np.inf
        while (distance < np.inf).any():
            i = distance.argmin()
            if not _is_separated(deformation, point[None], positions[i][None])[0]:
                best[row], nearest[row] = v[i], distance[i]
                break
            distance[i] = np.inf
    return best, nearest


def displacement_field(deformation, grid, progress=SILENT):
    displacement = np.empty((grid.size, 3), dtype=np.float32)
    void_distance = np.empty(grid.size, dtype=np.float32) if deformation.cuts else None
    for part in progress.over(_parts(grid.size, deformation)):
        v = grid.points(part.start, part.stop)
        displacement[part], distance, _ = _evaluate(deformation, v)
        if deformation.cuts:
            void_distance[part] = distance
    void_distance = void_distance.reshape(grid.shape) if deformation.cuts else None
    return displacement.reshape(*grid.shape, 3), void_distance


def jacobian_field(deformation, grid, progress=SILENT):
    result = np.empty((grid.size, 3, 3), dtype=np.float32)
    for part in progress.over(_parts(grid.size, deformation)):
        v = grid.points(part.start, part.stop)
        result[part] = _evaluate(deformation, v, with_jacobian=True)[2].swapaxes(1, 2)
    return result.reshape(*grid.shape, 3, 3)


def resample(deformation, arrays, sampling, progress=SILENT, void_distance=None, covariant=None):
    parts = _sources(deformation, sampling, progress, with_jacobian=bool(covariant))
    versions = [None] * len(arrays)
    return sampled_parts(arrays, versions, sampling, parts, sample, void_distance, covariant)


def gradient(array, grid, progress=SILENT):
    return vector_fields.gradient(array, grid, progress)


def sample(array, index, method, background, source, version=None):
    return interpolation.sample(array, index, method, background, source)


def void_by_corners(void_distance, min_distance, progress=SILENT):
    return void_cells.by_corners(void_distance, min_distance)


def doubtful_voxels(displacement, axes, progress=SILENT):
    return certificate.doubtful_voxels(displacement, axes)


def void_distance_listed(deformation, grid, indices, progress=SILENT):
    result = np.empty(len(indices), np.float32)
    for part in progress.over(_parts(len(indices), deformation)):
        result[part] = _evaluate(deformation, grid.points_of(indices[part]))[1]
    return result


def source_index(deformation, sampling, progress=SILENT):
    return np.concatenate([index for _, index, *_ in _sources(deformation, sampling, progress)])


def _sources(deformation, sampling, progress, with_jacobian=False):
    """Parts of the target with their origins, as indices (m, 3) of the whole source.

    And their void distances (m,), and Jacobians (m, 3, 3) or None.
    """
    source, target = sampling.source, sampling.target
    matrix, offset = target.whole.index_transform(source.whole)
    to_index = source.world_to_index
    for part in progress.over(_parts(target.size, deformation)):
        v = target.points(part.start, part.stop)
        moved, void_distance, jacobian = _evaluate(deformation, v, with_jacobian=with_jacobian)
        index = target.indices(part.start, part.stop) + target.first
        index = index @ matrix.T + offset + moved @ to_index.T
        if deformation.cuts and not sampling.continues:
            index[void_distance < 0] = -np.inf
        yield part, index, void_distance, jacobian


def _evaluate(deformation, points, progress=SILENT, with_jacobian=False):
    """Displacements (m, 3), void distances (m,) and Jacobians (m, 3, 3) or None at `points`."""
    displacement, void_distance = np.empty(points.shape), np.full(len(points), -np.inf)
    jacobian = np.empty((len(points), 3, 3)) if with_jacobian else None
    results = displacement, void_distance, jacobian
    for part in progress.over(_parts(len(points), deformation)):
        v = points[part]
        masks = [region.holds(deformation.moved_planes, v) for region in deformation.regions]
        for region, mask in zip(deformation.regions, masks):
            _merge_region(deformation, region, points, part.start + np.flatnonzero(mask), results)
        if not deformation.has_competing_regions:
            continue
        for region, mask in zip(deformation.regions, masks):  # second pass: points still void
            rows = part.start + np.flatnonzero(~mask & (void_distance[part] < 0))
            _merge_region(deformation, region, points, rows, results)
    return results


def _merge_region(deformation, region, points, rows, results):
    """Set `results` to those of a region in the `rows` where its void distance is larger."""
    if len(rows) == 0:
        return
    with_jacobian = results[2] is not None
    of_region = _in_region(deformation, region, points[rows], with_jacobian=with_jacobian)
    better = ~(of_region[1] <= results[1][rows])
    for result, new in zip(results, of_region):
        if result is not None:
            result[rows[better]] = new[better]


def _in_region(deformation, region, v, start=None, with_jacobian=False):
    """`_evaluate` for the material of one region; only on the side of `start` (m, 3), if given."""
    displacement, void_distance, fit = _fit_in_region(deformation, region, v, start)
    return displacement, void_distance, jacobian_of(fit) if with_jacobian else None


def _fit_in_region(deformation, region, v, start=None):
    """Displacements (m, 3) and void distances (m,) of `_in_region`, and the fit."""
    control_points, cuts = region.control_points, deformation.obstacles

    def fit_at(rows, at):
        return fit_of(deformation, control_points, v[rows], at)

    if deformation.in_rest_frame and cuts:
        searches = 1
        if start is None:
            matrix, offset = control_points.affine
            # without BLAS, whose rounding depends on the number of points
            start, searches = (v[:, None] * matrix).sum(axis=2) + offset, 2
        at = rest_frame.solve_origin(
            lambda rows, at: v[rows] + fit_at(rows, at).displacement(),
            cuts,
            start,
            _size_of(control_points, v),
            searches,
        )
        fit, void_distance = fit_at(slice(None), at), rest_frame.void_distance(cuts, at)
    else:
        fit, void_distance = fit_at(slice(None), None), np.full(len(v), np.inf)
    displacement = fit.displacement()
    if deformation.in_rest_frame:
        legs = [(v, v + displacement)]
    else:
        legs = fit.legs
        for cut, (after, before) in itertools.product(cuts, legs):
            void_distance = np.minimum(void_distance, cut.void_distance(after, before))
    for plane, side in zip(deformation.planes, region.sides):
        for _, before in legs:
            void_distance = np.minimum(void_distance, side * plane.height(before))
    return displacement, void_distance, fit


def _parts(count, deformation):
    """Slices of points whose temporary arrays have at most `_MAX_VALUES` values."""
    values_per_point = max(
        (len(c) + _POINTS_OF_SEGMENT * len(c.handles.segments)) * max(c.kind.functions(c) + 3, 6)
        for c in (region.control_points for region in deformation.regions)
    )
    step = max(1, _MAX_VALUES // values_per_point)
    return [slice(start, min(count, start + step)) for start in range(0, count, step)]
