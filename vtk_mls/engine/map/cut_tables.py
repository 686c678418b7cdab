"""Cuts in the layout of the kernels: build constants, and tables in the local frame of a region."""

import numpy as np

from vtk_mls.engine.launch.kernel_arguments import STRUCTS, filled, transform
from vtk_mls.model.regions import ON_PLANE

FRAMES = "deformed_frame.cl", "rest_frame.cl"
NO_CUTS = ("CUTS", 0), ("CUT_FILE", "no_cuts.cl"), ("AT_REST", 0), ("FRAME_FILE", FRAMES[0])


def cut_tables(deformation, region, grid=None, second_pass=False):
    """Build constants of the cuts of a deformation, the cut_params_t, and a table (m,) float32.

    The table has the planes, then all obstacles, in the local frame of `region`; planes also in
    indices of `grid`. See on_grid.cl for the second pass.
    """
    control_points = region.control_points
    matrix, offset = control_points.affine  # from v to x
    moved = (matrix - np.eye(3)) @ control_points.center + offset
    params = filled(
        "cut_params_t",
        damping=deformation.nu / (2 * deformation.alpha),
        nu=deformation.nu,
        on_plane=ON_PLANE,
        mean_displacement=control_points.mean_displacement / control_points.scale,
        affine=transform(matrix, moved / control_points.scale),
        plane_count=len(deformation.planes),
        regions_compete=deformation.has_competing_regions,
        second_pass=second_pass,
    )
    shapes = {}
    for cut in deformation.obstacles:
        shapes.setdefault(type(cut), []).append(cut)
    shapes = dict(sorted(shapes.items(), key=lambda item: item[0].kernel))
    is_at_rest = deformation.in_rest_frame and bool(shapes)
    constants = [
        *(("CUTS", 1), ("CUT_FILE", "cuts.cl")),
        *(("AT_REST", int(is_at_rest)), ("FRAME_FILE", FRAMES[is_at_rest])),
        ("SHAPE_FILES", " ".join(f"cut_{shape.kernel}.cl" for shape in shapes)),
        ("SHAPES(X)", " ".join(f"X({shape.kernel})" for shape in shapes)),
    ]
    for shape, cuts in shapes.items():
        constants += shape.constants(len(cuts)).items()
    # where cuts see the handles: once, or in each step if they stay
    if deformation.in_rest_frame:
        anchors = [control_points.handles.term_anchors[0]]
    else:
        steps = control_points.steps(deformation.steps_used)
        anchors = [step.handles.term_anchors[1] for step in steps]
    joined = [
        _joined([_shape_table(cuts, control_points, places) for cuts in shapes.values()])
        for places in anchors
    ]
    planes = _plane_table(deformation, region, grid).view(np.float32)
    params["obstacle_start"] = len(planes)
    params["obstacle_stride"] = len(joined[0]) if len(joined) > 1 else 0
    return constants, params, np.concatenate([planes, *joined])


def _plane_table(deformation, region, grid):
    """The full cuts: (planes,) plane_t."""
    control_points = region.control_points
    table = np.zeros(len(deformation.planes), STRUCTS["plane_t"])
    table["side"] = region.sides
    for row, plane, moved in zip(table, deformation.planes, deformation.moved_planes):
        height = plane.height(control_points.center) / control_points.scale
        row["plane"] = [*plane.normal, height]
        if grid is not None:
            row["index_plane"] = [*moved.normal @ grid.index_to_world, moved.height(grid.origin)]
    return table


def _shape_table(cuts, control_points, positions):
    """The table of one shape, as `record_of` in cuts.cl reads it: (m,) float32.

    Number of cuts, start of each record, and the records; ints are stored by their bits. The cuts
    see the control points at `positions` (n, 3), world coordinates.
    """
    records = [_packed(cut.record(control_points, positions)) for cut in cuts]
    offsets = np.cumsum([1 + len(cuts), *map(len, records)])[:-1]
    return np.concatenate([_packed([[len(cuts)], offsets]), *records])


def _joined(tables):
    """The start of each table, and the tables, as `cuts_of` in cuts.cl reads them: (m,) float32."""
    offsets = np.cumsum([len(tables), *map(len, tables)])[:-1] if tables else []
    return np.concatenate([_packed([offsets]), *tables])


def _packed(arrays):
    """Arrays of floats or ints, concatenated: float32, ints by their bits."""
    arrays = [np.asarray(array).ravel() for array in arrays]
    types = [np.int32 if array.dtype.kind in "iu" else np.float32 for array in arrays]
    return np.concatenate([a.astype(type_).view("f4") for a, type_ in zip(arrays, types)])
