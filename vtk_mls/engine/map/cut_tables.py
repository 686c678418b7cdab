"""Cuts as the kernels read them: build constants, and tables in the local frame of a region."""

from __future__ import annotations

import numpy as np

from vtk_mls.engine.launch.kernel_arguments import CUT_NUMBERS, PLANE, filled, not_empty, transform
from vtk_mls.model.regions import ON_PLANE


def cut_tables(deformation, region, grid=None, is_rival=False):
    """Build constants of the cuts of `deformation`; their numbers, then their tables.

    All in the local frame of `region`; planes also by index of `grid`. A rival has the points of
    other regions that are void.
    """
    control_points = region.control_points
    numbers = filled(
        CUT_NUMBERS,
        damping=deformation.nu / (2 * deformation.alpha),
        nu=deformation.nu,
        mean_displacement=control_points.mean_displacement / control_points.scale,
        affine=_local_affine(control_points),
        plane_count=len(deformation.planes),
        is_rival=is_rival,
    )
    shapes = {}
    for cut in deformation.obstacles:
        shapes.setdefault(type(cut), []).append(cut)
    shapes = dict(sorted(shapes.items(), key=lambda item: item[0].kernel))
    constants = [
        ("CUTS", 1),
        ("AT_REST", int(deformation.in_rest_frame and bool(shapes))),
        ("RIVALS", int(deformation.has_competing_regions)),
        ("ON_PLANE", f"{ON_PLANE}f"),
        ("SHAPE_FILES", " ".join(f"cut_{shape.kernel}.cl" for shape in shapes)),
        ("SHAPES(X)", " ".join(f"X({shape.kernel})" for shape in shapes)),
    ]
    for shape, cuts in shapes.items():
        constants += shape.constants(len(cuts)).items()
    seen = control_points.rest if deformation.in_rest_frame else control_points.deformed
    tables = [_shape_table(cuts, control_points, seen) for cuts in shapes.values()]
    planes = _plane_table(deformation, region, grid)
    return constants, numbers, [not_empty(table) for table in (planes, *tables)]


def _local_affine(control_points):
    """The affine map of control points from v to x, in the local frame, as a transform."""
    matrix, offset = control_points.affine
    moved = (matrix - np.eye(3)) @ control_points.center + offset
    return transform(matrix, moved / control_points.scale)


def _plane_table(deformation, region, grid):
    """The full cuts: (planes,) PLANE."""
    control_points = region.control_points
    table = np.zeros(len(deformation.planes), PLANE)
    table["side"] = region.sides
    for row, plane, moved in zip(table, deformation.planes, deformation.moved_planes):
        height = plane.height(control_points.center) / control_points.scale
        row["plane"] = [*plane.normal, height]
        if grid is not None:
            row["index_plane"] = [*moved.normal @ grid.index_to_world, moved.height(grid.origin)]
    return table


def _shape_table(cuts, control_points, seen):
    """Cuts of one shape, as `record_of` in cuts.cl finds them.

    Their number, where each record begins, and the records; ints are there by their bits. The cuts
    see the control points at `seen` (n, 3), world coordinates.
    """
    records = [_packed(cut.record(control_points, seen)) for cut in cuts]
    starts = np.cumsum([1 + len(cuts), *map(len, records)])[:-1]
    return np.concatenate([_packed([[len(cuts)], starts]), *records])


def _packed(arrays):
    """Arrays of floats or ints one behind the other, float32 with the bits of int32."""
    arrays = [np.asarray(array).ravel() for array in arrays]
    return np.concatenate(
        [a.astype(np.int32 if a.dtype.kind in "iu" else np.float32).view("f4") for a in arrays]
    )
