"""The number of steps in which a deformation does not fold at sampled points."""

from dataclasses import replace

import numpy as np

from vtk_mls.base.grid import Grid
from vtk_mls.base.messages import warn
from vtk_mls.base.progress import SILENT
from vtk_mls.model.options import MAX_STEPS

# The smallest determinant of a step that is accepted: the more steps, the nearer to 1 all are.
MIN_DETERMINANT = 0.1
_LATTICE = 20  # points along each axis of a box or grid; their middles are sampled, too
_MARGIN = 0.5  # around the handles, as a fraction of their box
_MAX_POINTS = 1 << 18
# Next to handles, as fractions of the way to each of the nearest others: on the way and on the
# other side, and beside the way.
_FRACTIONS = -0.25, 0.1, 0.25, 0.5
_LATERAL = 0.15, 0.35, 0.6
_NEIGHBORS = 4
_MAX_HANDLES = 1024  # the first to fold: those with the longest steps relative to the distance


def enough_steps(engine, deformation, where=None, progress=SILENT):
    """The number of steps with no determinant below `MIN_DETERMINANT`, and the smallest one.

    The number is doubled up to `MAX_STEPS`; then the smallest determinant may be below. `where` is
    a Grid or points (m, 3) of the deformed space, by default a box around the handles.
    """
    counts = [2**i for i in range(MAX_STEPS.bit_length())]
    for count, part in zip(counts, progress.divided(*counts)):
        candidate = replace(deformation, steps=count)
        smallest = smallest_determinant(engine, candidate, where, part)
        if smallest > MIN_DETERMINANT or candidate.steps_used >= MAX_STEPS:
            break
    if smallest <= MIN_DETERMINANT:
        warn(
            f"The deformation may fold in {candidate.steps_used} steps: a determinant is "
            f"{smallest:.3g}; handles should not go through the same place at the same time"
        )
    return candidate.steps_used, smallest


def smallest_determinant(engine, deformation, where=None, progress=SILENT):
    """The smallest determinant of the Jacobian of a step, as of `enough_steps`.

    It is sampled at points of the deformed space, which are followed through all steps, and for
    each step at points near the handles.
    """
    whole, near = progress.divided(3, 1)
    smallest = engine.least_determinant(deformation, _points(deformation, where), whole).min()
    if deformation.in_rest_frame and deformation.obstacles:
        return float(smallest)  # positions after all steps decide what cuts separate
    for k in near.over(range(deformation.steps_used)):
        points = np.concatenate(
            [
                _near_handles(region.control_points.steps(deformation.steps_used)[k].handles)
                for region in deformation.regions
            ]
        )
        if len(points) > 0:
            found = engine.least_determinant(deformation, points, SILENT, k)
            smallest = min(smallest, found.min())
    return float(smallest)


def _points(deformation, where):
    """Samples (m, 3) of a Grid, of points, or of a box around the handles."""
    if isinstance(where, Grid):
        size = np.array(where.dimensions) - 1
        step = np.maximum(size / (_LATTICE - 1), 1)
        return where.at(_lattice(np.zeros(3), size, step))
    if where is not None:
        return where[:: -(-len(where) // _MAX_POINTS)]
    places = np.concatenate(deformation.handle_set.positions)
    low, high = places.min(axis=0), places.max(axis=0)
    margin = _MARGIN * ((high - low).max() or 1)
    low, high = low - margin, high + margin
    return _lattice(low, high, np.full(3, (high - low).max() / (_LATTICE - 1)))


def _lattice(low, high, step):
    """Points (m, 3) from `low` to `high`, and the middles between them."""
    axes = [np.arange(a, b + s / 2, s) for a, b, s in zip(low, high, step)]
    middles = [axis[:-1] + s / 2 if len(axis) > 1 else axis for axis, s in zip(axes, step)]
    return np.concatenate([_product(axes), _product(middles)])


def _product(axes):
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def _near_handles(handles):
    """Points (m, 3) of the later stage of a step between close handles, and on the other side."""
    rest, deformed = handles.positions
    if len(deformed) < 2:
        return np.zeros((0, 3))
    rows = np.arange(len(deformed))[:: -(-len(deformed) // (4 * _MAX_HANDLES))]
    distance = np.linalg.norm(deformed[rows, None] - deformed, axis=2)
    distance[distance == 0] = np.inf  # the handle itself, and others at its place
    count = min(_NEIGHBORS, len(deformed) - 1)
    nearest = np.argpartition(distance, count - 1, axis=1)[:, :count]
    moved = np.linalg.norm(rest - deformed, axis=1)[rows]
    first = np.argsort(distance.min(axis=1) / np.maximum(moved, 1e-300))[:_MAX_HANDLES]
    start = deformed[rows[first]][:, None]
    away = deformed[nearest[first]] - start
    on_way = [start + share * away for share in _FRACTIONS]
    length = np.linalg.norm(away, axis=2, keepdims=True)
    sides = np.concatenate([np.eye(3), -np.eye(3)])
    lateral = [start + away / 2 + share * length * side for share in _LATERAL for side in sides]
    return np.concatenate(on_way + lateral).reshape(-1, 3)
