"""The number of steps in which a deformation does not fold."""

import itertools
from dataclasses import replace

import numpy as np

from vtk_mls.base.grid import Grid
from vtk_mls.base.messages import warn
from vtk_mls.base.progress import SILENT
from vtk_mls.model.handles.handle_paths import MAX_POINTS, rigid_path
from vtk_mls.model.options import MAX_STEPS
from vtk_mls.queries import certificate
from vtk_mls.queries.fields import DisplacementField

# The smallest determinant of a step that is accepted: the more steps, the nearer to 1 all are.
MIN_DETERMINANT = 0.1
_MAX_STRAIGHT, _LEGS = 16, 8  # steps on straight ways; lines of a rigid path
_LATTICE = 20  # points along each axis of a box or grid; their middles are sampled, too
_MARGIN = 0.5  # around the handles, as a fraction of their box
_MAX_POINTS = 1 << 18
_MAX_HANDLES = 1 << 12
# Around handles, the first to fold, at a quarter of the distance to the nearest other and at its
# doubles, which finds folds around clusters of any size; and on the way between handles.
_MAX_CENTERS = 128
_MAX_PAIRS = 1024
_WAY = 0.1, 0.25, 0.5, 0.75, 0.9
_DIRECTIONS = np.array([d for d in itertools.product((-1, 0, 1), repeat=3) if np.abs(d).sum() % 2])
_DIRECTIONS = _DIRECTIONS / np.linalg.norm(_DIRECTIONS, axis=1, keepdims=True)
# The search around the smallest determinants: points, samples around each, rounds at half the
# distance.
_BEST, _TRIALS, _ROUNDS = 64, 24, 4
_SAFE = 0.6  # samples with a larger determinant are not looked at again in more steps
_MAX_CHECKED = 1 << 12  # centers of voxels that fold, to choose the number of steps


def in_enough_steps(engine, deformation, where=None, progress=SILENT):
    """The deformation in as many steps that no determinant of a step is below `MIN_DETERMINANT`.

    In `MAX_STEPS` the smallest determinant may be below. `where` is a Grid or points (m, 3) of the
    deformed space, by default a box around the handles.
    """
    samples, remaining = _samples(deformation, where), {}  # by the length of the path
    for candidate in _in_more_steps(deformation):
        part, progress = progress.divided(1, 2)
        points, radius = remaining.get(len(candidate.path), samples)
        values = engine.least_determinant(candidate, points, part)
        smallest = _smallest_around(engine, candidate, points, radius, values, MIN_DETERMINANT)
        if smallest > MIN_DETERMINANT:
            return candidate
        is_near = ~(values > max(_SAFE, np.sort(values)[:_BEST][-1]))  # also NaN
        remaining[len(candidate.path)] = points[is_near], radius[is_near]
    warn(
        f"The deformation may fold in {candidate.steps_used} steps: a determinant is "
        f"{smallest:.3g}; handles should not go through the same place at the same time"
    )
    return candidate


def _in_more_steps(deformation):
    """The deformation in twice as many steps each time, up to `MAX_STEPS`.

    Control points that need more than 16 on straight ways take a rigid path, too.
    """
    is_free = len(deformation.path) + len(deformation.handles) == 0
    has_rigid_path = is_free and 2 < len(deformation.rest) <= MAX_POINTS
    rigid = None
    for count in (2**i for i in range(MAX_STEPS.bit_length())):
        if count > _MAX_STRAIGHT and rigid is None and has_rigid_path:
            path = rigid_path(deformation.rest, deformation.deformed, _LEGS)
            rigid = replace(deformation, path=path)
            yield from map(rigid.in_steps, (_LEGS, _MAX_STRAIGHT))
        yield deformation.in_steps(count)
        if rigid:
            yield rigid.in_steps(count)


def checked_field(engine, deformation, grid, progress=SILENT):
    """The DisplacementField on a grid and its FoldCheck, and the deformation in as many steps.

    The steps are doubled, up to `MAX_STEPS`, until the determinant of the map is above 0 at the
    corners and centers of all voxels. A warning counts the others.
    """
    while True:
        computing, checking, progress = progress.divided(4, 1, 5)
        displacement, distance = engine.displacement_field(deformation, grid, computing)
        field = DisplacementField(displacement, grid, distance)
        folds = certificate.check(engine, deformation, field, checking)
        if len(folds.map_indices) == 0:
            return field, folds, deformation
        if deformation.steps_used >= MAX_STEPS:
            break
        rows = folds.map_indices[:: -(-len(folds.map_indices) // _MAX_CHECKED)]
        points, is_folded = grid.cells.points_of(rows), True
        while is_folded and deformation.steps_used < MAX_STEPS:
            deformation = deformation.in_steps(2 * deformation.steps_used)
            is_folded = _determinants(engine, deformation, points).min() <= 0
    warn(
        f"The map folds in {len(folds.map_indices)} of {grid.cells.size} voxels, even in "
        f"{deformation.steps_used} steps; handles should not go through the same place at the same "
        "time"
    )
    return field, folds, deformation


def unfolded(engine, deformation, points):
    """The deformation in as many steps that it does not fold where points (m, 3) of the
    undeformed space go: they have a position, and the determinant there is above 0.
    """
    while True:
        displacement, is_found = engine.forward(deformation, points, SILENT)
        moved = np.nan_to_num(points + displacement)
        is_folded = _determinants(engine, deformation, moved) <= 0
        if not deformation.cuts:  # else material may have no position behind a cut
            is_folded |= ~is_found
        if not is_folded.any() or deformation.steps_used >= MAX_STEPS:
            return deformation
        deformation = deformation.in_steps(2 * deformation.steps_used)


def smallest_determinant(engine, deformation):
    """The smallest determinant of the Jacobian of the whole map at sampled points."""
    return float(_determinants(engine, deformation, _samples(deformation, None)[0]).min())


def smallest_step_determinant(engine, deformation):
    """The smallest determinant of the Jacobian of a step at sampled points and around these."""
    points, radius = _samples(deformation, None)
    values = engine.least_determinant(deformation, points, SILENT)
    return float(_smallest_around(engine, deformation, points, radius, values))


def _smallest_around(engine, deformation, points, radius, values, limit=-np.inf):
    """The smallest of the determinants `values` of points and those of others around the smallest.

    The points are followed through all steps. The search stops at one that is not above `limit`.
    """
    smallest = values.min()
    rng = np.random.default_rng(0)
    for _ in range(_ROUNDS):
        if smallest <= limit:
            break
        best = np.argpartition(values, min(_BEST, len(values) - 1))[:_BEST]
        best = best[np.argsort(values[best])]
        radius = np.repeat(radius[best] / 2, _TRIALS)
        points = np.repeat(points[best], _TRIALS, axis=0)
        points = points + radius[:, None] * rng.normal(size=points.shape)
        values = engine.least_determinant(deformation, points, SILENT)
        smallest = min(smallest, values.min())
    return smallest


def _determinants(engine, deformation, points):
    return np.linalg.det(engine.jacobian(deformation, points, SILENT))


def _samples(deformation, where):
    """Points (m, 3) of a Grid, given points, or a box around the handles, and around these.

    And how far (m,) from each a search for a smaller determinant begins.
    """
    if where is not None and not isinstance(where, Grid):
        where = where[:: -(-len(where) // _MAX_POINTS)]
        return where, np.zeros(len(where))
    places = np.concatenate(deformation.handle_set.positions)
    low, high = places.min(axis=0), places.max(axis=0)
    size = (high - low).max() or 1.0
    if where is not None:
        last = np.array(where.dimensions) - 1
        step = np.maximum(last / (_LATTICE - 1), 1)
        lattice = where.at(_lattice(np.zeros(3), last, step))
        step = np.linalg.norm(where.index_to_world @ step)
    else:
        margin = _MARGIN * size
        step = (1 + 2 * _MARGIN) * size / (_LATTICE - 1)
        lattice = _lattice(low - margin, high + margin, np.full(3, step))
    groups = [(lattice, np.full(len(lattice), step))]
    groups += [_around_handles(r.control_points.handles, size) for r in deformation.regions]
    return tuple(np.concatenate(parts) for parts in zip(*groups))


def _lattice(low, high, step):
    """Points (m, 3) from `low` to `high`, and the middles between them."""
    axes = [np.arange(a, b + s / 2, s) for a, b, s in zip(low, high, step)]
    middles = [axis[:-1] + s / 2 if len(axis) > 1 else axis for axis, s in zip(axes, step)]
    return np.concatenate([_product(axes), _product(middles)])


def _product(axes):
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def _around_handles(handles, size):
    """Points (m, 3) around and between handles, and their distances (m,) from other points."""
    rest, deformed = handles.positions
    if len(deformed) < 2:
        return np.zeros((0, 3)), np.zeros(0)
    rows = np.arange(len(deformed))[:: -(-len(deformed) // _MAX_HANDLES)]
    distance = np.linalg.norm(deformed[rows, None] - deformed, axis=2)
    distance[distance == 0] = np.inf  # the handle itself, and others at its place
    nearest = np.minimum(distance.min(axis=1), size)
    displacement = rest - deformed
    strain = np.linalg.norm(displacement[rows, None] - displacement, axis=2) / distance
    first = np.argsort(-strain.max(axis=1))[:_MAX_CENTERS]
    doublings = np.arange(1 + np.ceil(np.log2(4 * size / nearest[first].min())))
    radii = nearest[first] / 4 * 2.0 ** doublings[:, None]
    radii = np.where(radii <= size, radii, 0)
    shells = deformed[rows[first]][:, None] + radii[..., None, None] * _DIRECTIONS
    keep = np.repeat(radii[..., None] > 0, len(_DIRECTIONS), axis=-1)
    pairs = np.argsort(-strain, axis=None)[: 2 * _MAX_PAIRS : 2]
    a, b = np.divmod(pairs, len(deformed))
    start, way = deformed[rows[a]], deformed[b] - deformed[rows[a]]
    between = np.concatenate([start + share * way for share in _WAY])
    length = np.linalg.norm(way, axis=1) / 4
    return (
        np.concatenate([shells[keep], between]),
        np.concatenate(
            [np.broadcast_to(radii[..., None], keep.shape)[keep] / 2, np.tile(length, len(_WAY))]
        ),
    )
