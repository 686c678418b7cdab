"""Data in the layout of the kernels: structs of structs.h, and functions that fill them."""

from __future__ import annotations

import numpy as np

from vtk_mls.queries import void_cells


def _struct(members):
    """The dtype of a C struct, its padding at the end a member: rusticl 22.3 does not count it."""
    dtype = np.dtype(members, align=True)
    last = dtype.names[-1]
    padding = dtype.itemsize - dtype.fields[last][1] - dtype[last].itemsize
    return np.dtype([*members, ("padding", "i4", (padding // 4,))]) if padding else dtype


_TRANSFORM = ("f4", 12)

CONTROL_POINT = _struct([("q", "f4", 3), ("c", "f4"), ("u", "f4", 3)])
REGION = _struct(
    [
        *[("end", "f4", 3), ("along", "f4", 3), ("radius", "f4"), ("anchor", "f4", 3)],
        *[("step", "f4"), ("to_index", *_TRANSFORM), ("size", "i4", 3), ("first", "i4")],
        *[("first_proxy", "i4"), ("proxy_count", "i4"), ("moments", "f4", 9), ("spread", "f4")],
    ]
)
SEGMENT = _struct(
    [
        *[("q", "f4", 3), ("along_q", "f4", 3), ("u", "f4", 3), ("along_u", "f4", 3)],
        *[("c", "f4"), ("density", "f4")],
    ]
)
LIMIT = _struct(
    [
        *[("form", "i4"), ("slides", "i4"), ("low", "f4", 3), ("high", "f4", 3)],
        *[("radius", "f4"), ("falloff", "f4"), ("to_index", *_TRANSFORM), ("size", "i4", 3)],
        ("first", "i4"),
    ]
)
MAP_PARAMS = _struct(
    [
        *[
            ("count", "i4"),
            ("region_count", "i4"),
            ("segment_count", "i4"),
            ("limit_count", "i4"),
            ("step_count", "i4"),
            ("alpha", "f4"),
            ("smoothing2", "f4"),
            ("rank", "i4"),
        ],
        ("flip_axis", "f4", 3),
    ]
)
STEP = _struct(
    [
        *[("control_point", "i4"), ("kind_value", "i4"), ("region", "i4"), ("segment", "i4")],
        *[("rank", "i4"), ("flip_axis", "f4", 3)],
    ]
)
WORLD = _struct([("scale", "f4"), ("mean_displacement", "f4", 3)])
LOCAL_FRAME = _struct([("center", "f4", 3), ("center_rest", "f4", 3)])
GRID = _struct(
    [
        *[("first", "i8"), ("stop", "i8"), ("nx", "i4"), ("ny", "i4"), ("start", "i4", 3)],
        ("frame", *_TRANSFORM),
    ]
)
SOURCE = _struct(
    [("from_target", *_TRANSFORM), ("from_displacement", *_TRANSFORM), ("continued", "i4")]
)
LATTICE = _struct([("center", "f4", 3), ("density", "f4", 3)])
SAMPLE = _struct([("v", "f4", 3), ("image", "f4", 3)])
NODES = _struct([("first", "i4", 3), ("nx", "i4"), ("ny", "i4")])
NODE = _struct([("x", "f4", 4), ("by_i", "f4", 4), ("by_j", "f4", 4), ("by_k", "f4", 4)])
COARSE = _struct(
    [
        *[("first_listed", "i8"), ("listed", "i8"), ("first_cell", "i4", 3), ("cells", "i4", 3)],
        *[("first_node", "i4", 3), ("nodes", "i4", 3), ("to_slopes", *_TRANSFORM)],
    ]
)
CHECK = _struct([("to_index", *_TRANSFORM), ("limit2", "f4")])
ARRAY = _struct([("size", "i4", 3), ("first", "i4", 3), ("stored", "i4", 3), ("components", "i4")])
LAYERS = _struct(
    [
        *[("size", "i4", 3), ("first", "i4"), ("stored", "i4"), ("start", "i4"), ("stop", "i4")],
        *[("min_distance", "f4"), ("far_factor", "f4")],
    ]
)
SLICES = _struct(
    [
        *[("size", "i4", 3), ("first", "i4"), ("start", "i4"), ("stop", "i4")],
        ("to_world", *_TRANSFORM),
    ]
)
PLANE = _struct([("plane", "f4", 4), ("index_plane", "f4", 4), ("side", "f4")])
CUT_PARAMS = _struct(
    [
        *[("damping", "f4"), ("nu", "f4"), ("on_plane", "f4"), ("mean_displacement", "f4", 3)],
        *[("affine", *_TRANSFORM), ("plane_count", "i4"), ("regions_compete", "i4")],
        *[("second_pass", "i4"), ("obstacle_stride", "i4")],
    ]
)
# The structs of structs.h, where their members are described.
STRUCTS = {
    "control_point_t": CONTROL_POINT,
    "region_t": REGION,
    "segment_t": SEGMENT,
    "limit_t": LIMIT,
    "map_params_t": MAP_PARAMS,
    "step_t": STEP,
    "world_t": WORLD,
    "local_frame_t": LOCAL_FRAME,
    "grid_t": GRID,
    "source_t": SOURCE,
    "lattice_t": LATTICE,
    "sample_t": SAMPLE,
    "nodes_t": NODES,
    "node_t": NODE,
    "coarse_t": COARSE,
    "check_t": CHECK,
    "array_t": ARRAY,
    "layers_t": LAYERS,
    "slices_t": SLICES,
    "plane_t": PLANE,
    "cut_params_t": CUT_PARAMS,
}
# The constants of structs.h, where they are described.
NODE_STEP, COARSE_STEP, FINE_STEP = 4, 4, 2
LATTICE_CELLS, LATTICE_LEVELS = 20, 8
CELL_ROWS, CELL_LAYERS = 4, 16
INACCURATE, OTHER_REGION, SEPARATED = 1, 2, 4
BOX_MASK, IMAGE_MASK, PLANE_FACE, IMAGE_FACE = range(4)
CONSTANTS = {
    "NODE_STEP": NODE_STEP,
    "COARSE_STEP": COARSE_STEP,
    "FINE_STEP": FINE_STEP,
    "LATTICE_CELLS": LATTICE_CELLS,
    "LATTICE_LEVELS": LATTICE_LEVELS,
    "CELL_ROWS": CELL_ROWS,
    "CELL_LAYERS": CELL_LAYERS,
    "VOID": void_cells.VOID,
    "TOUCHED": void_cells.TOUCHED,
    "UNKNOWN": void_cells.UNKNOWN,
    "BOX_MASK": BOX_MASK,
    "IMAGE_MASK": IMAGE_MASK,
    "PLANE_FACE": PLANE_FACE,
    "IMAGE_FACE": IMAGE_FACE,
    "INACCURATE": INACCURATE,
    "OTHER_REGION": OTHER_REGION,
    "SEPARATED": SEPARATED,
}


def local_frame(center):
    """The LOCAL_FRAME of a center (3,) float64."""
    return filled(LOCAL_FRAME, center=center, center_rest=center - np.float32(center))


def planes(points):
    """The coordinate planes of points (m, 3): (3, m) float32."""
    return np.ascontiguousarray(points.T, dtype=np.float32)


def filled(dtype, **values):
    """A structured array of one element: a struct that a kernel takes by value."""
    result = np.zeros((), dtype)
    for name, value in values.items():
        result[name] = value
    return result


def control_points(points):
    """The table of `ControlPoints`: means of regions, points, then proxies: (n,) CONTROL_POINT."""
    handles = points.handles
    q = points.local(points.deformed)
    u = (points.rest - points.deformed - points.mean_displacement) / points.scale
    proxies = handles.region >= 0
    table = np.zeros(handles.term_count + proxies.sum(), CONTROL_POINT)
    for name, values in (("q", q), ("u", u)):
        table[name] = np.concatenate([handles.means(values), values[proxies]])
    totals = np.bincount(handles.region[proxies], points.weights[proxies])
    table["c"] = np.concatenate([totals, points.weights[~proxies], points.weights[proxies]])
    table["c"] /= mean_weight(points)
    return table


def mean_weight(points):
    """The mean weight of control points and segments, which the kernels have as 1."""
    return np.concatenate([points.weights, points.handles.segments.weights]).mean()


def not_empty(table):
    """`table`, or one number for an empty one: OpenCL has no empty buffers."""
    return table if table.size else np.zeros(1, table.dtype)


def world(control_points):
    """The WORLD of `ControlPoints`."""
    return filled(
        WORLD,
        scale=control_points.scale,
        mean_displacement=control_points.mean_displacement,
    )


def grid_points(grid, part, control_points):
    """The points `part` of `grid`, with the transform to the local frame: a GRID."""
    frame = transform(
        grid.index_to_world / control_points.scale, control_points.local(grid.whole.origin)
    )
    nx, ny, _ = grid.dimensions
    return filled(
        GRID, first=part.start, stop=part.stop, nx=nx, ny=ny, start=grid.first, frame=frame
    )


def to_source(sampling, control_points):
    """Transforms from the target of a `Sampling` to its source: a SOURCE."""
    source = sampling.source.whole
    matrix, offset = sampling.target.whole.index_transform(source)
    to_index = source.world_to_index
    return filled(
        SOURCE,
        from_target=transform(matrix, offset + to_index @ control_points.mean_displacement),
        from_displacement=transform(to_index * control_points.scale, np.zeros(3)),
        continued=sampling.continues,
    )


def samples(v, image):
    """A table of samples of the map, from planes (3, n): (n,) SAMPLE."""
    table = np.zeros(v.shape[1], SAMPLE)
    table["v"], table["image"] = v.T, image.T
    return table


def transform(matrix, offset):
    """An affine transform in the layout of `transformed` in types.cl: (12,)."""
    return np.concatenate([np.asarray(matrix).T.ravel(), offset])
