"""Host data as the kernels read it: float32 tables, vectors and transforms."""

from __future__ import annotations

import numpy as np

# A control point: q, the factor of its weight, p - q less its mean; in local units.
CONTROL_POINT = np.dtype([("q", "f4", 3), ("c", "f4"), ("u", "f4", 3), ("unused", "f4")])


def planes(points):
    """Points (m, 3) as the kernels take them: (3, m) float32."""
    return np.ascontiguousarray(points.T, dtype=np.float32)


def members(dtype):
    """The members of the C struct that a structured dtype of int32 and float32 is."""
    types = {np.dtype("f4"): "float", np.dtype("i4"): "int"}
    text = []
    for name in dtype.names:
        base, shape = dtype[name].base, dtype[name].shape
        text.append(f"{types[base]} {name}{''.join(f'[{n}]' for n in shape)};")
    return " ".join(text)


def record(numbers):
    """A dict of names and numbers, int32 or float32, as a structured array of one element."""
    arrays = {name: np.asarray(value) for name, value in numbers.items()}
    result = np.zeros((), [(name, a.dtype, a.shape) for name, a in arrays.items()])
    for name, array in arrays.items():
        result[name] = array
    return result


def control_points(points):
    """The table of `ControlPoints`: (n,) CONTROL_POINT."""
    table = np.zeros(len(points), CONTROL_POINT)
    table["q"] = points.local(points.deformed)
    table["c"] = points.weights / points.weights.mean()
    table["u"] = (points.rest - points.deformed - points.mean_displacement) / points.scale
    return table


def not_empty(table):
    """`table`, or one number for an empty one: OpenCL has no empty buffers."""
    return table if table.size else np.zeros(1, table.dtype)


def grid_points(grid, part, control_points):
    """Kernel arguments of the points `part` of `grid`, with the transform to the local frame."""
    frame = transform(
        grid.index_to_world / control_points.scale, control_points.local(grid.whole.origin)
    )
    nx, ny, _ = grid.dimensions
    bounds = np.int64(part.start), np.int64(part.stop)
    return *bounds, np.int32(nx), np.int32(ny), int4(grid.first), frame


def transform(matrix, offset):
    """An affine transform as `transformed` in grid.cl takes it."""
    packed = np.zeros(16, np.float32)
    packed[:12] = np.concatenate([np.asarray(matrix).T.ravel(), offset])
    return packed


def to_source(source, target, control_points, continued):
    """First arguments of the kernels that tell where in `source` points of `target` come from."""
    matrix, offset = target.whole.index_transform(source.whole)
    to_index = np.linalg.inv(source.index_to_world)
    return (
        transform(matrix, offset + to_index @ control_points.mean_displacement),
        transform(to_index * control_points.scale, np.zeros(3)),
        np.int32(continued),
    )


def float4(vector):
    packed = np.zeros(4, np.float32)
    packed[:3] = vector
    return packed


def int4(vector):
    packed = np.zeros(4, np.int32)
    packed[:3] = vector
    return packed
