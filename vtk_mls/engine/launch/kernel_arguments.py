"""Data in the layout of the kernels, whose structs and constants opencl/base/structs.h describes,
and build constants of kernels that read arrays.
"""

import re

import numpy as np

from vtk_mls.base.resources import resource

_TYPES = {"int": "i4", "long": "i8", "float": "f4", "float4": "(4,)f4"}
_C_TYPES = {
    **{"int8": "char", "uint8": "uchar", "int16": "short", "uint16": "ushort"},
    **{"int32": "int", "uint32": "uint", "int64": "long", "uint64": "ulong"},
    **{"float32": "float", "float64": "double"},
}
# float32 is exact enough for values of these types and their sums
_SUMMED_IN_FLOAT = ("int8", "uint8", "int16", "uint16", "float32")
FLOAT64 = (("USE_FP64", 1),)  # build constants


def _dtype(members):
    fields = []
    for type_name, declared in re.findall(r"(\w+) ([^;]+);", members):
        for name, size in re.findall(r"(\w+)(?:\[(\d+)\])?", declared):
            fields.append((name, _TYPES[type_name], (int(size),) if size else ()))
    return np.dtype(fields, align=True)


_TEXT = re.sub("//.*", "", (resource("opencl") / "base" / "structs.h").read_text())
CONSTANTS = {name: int(value) for name, value in re.findall(r"(\w+) = (\d+)", _TEXT)}
STRUCTS = {
    name: _dtype(members)
    for members, name in re.findall(r"typedef struct \{(.*?)\} (\w+);", _TEXT, re.DOTALL)
}


def filled(name, **values):
    """A structured array of one element: a struct that a kernel takes by value."""
    result = np.zeros((), STRUCTS[name])
    for member, value in values.items():
        result[member] = value
    return result


def planes(points):
    """The coordinate planes of points (m, 3): (3, m) float32."""
    return np.ascontiguousarray(points.T, dtype=np.float32)


def control_points(points):
    """The control_point_t of `ControlPoints` (n,): means of regions, points, then proxies."""
    handles = points.handles
    q = points.local(handles.deformed)
    u = (handles.rest - handles.deformed - points.mean_displacement) / points.scale
    proxies = handles.region >= 0
    table = np.zeros(handles.term_count + proxies.sum(), STRUCTS["control_point_t"])
    for name, values in (("q", q), ("u", u)):
        table[name] = np.concatenate([handles.means(values), values[proxies]])
    totals = np.bincount(handles.region[proxies], handles.weights[proxies])
    table["c"] = np.concatenate([totals, handles.weights[~proxies], handles.weights[proxies]])
    table["c"] /= mean_weight(points)
    return table


def mean_weight(points):
    """The mean weight of control points and segments, which the kernels have as 1."""
    handles = points.handles
    return np.concatenate([handles.weights, handles.segments.weights]).mean()


def world(control_points):
    """The world_t of `ControlPoints`."""
    mean = control_points.mean_displacement
    return filled("world_t", scale=control_points.scale, mean_displacement=mean)


def grid_points(grid, part, control_points):
    """The points `part` of `grid`, with the transform to the local frame: a grid_t."""
    origin = control_points.local(grid.whole.origin)
    frame = transform(grid.index_to_world / control_points.scale, origin)
    nx, ny, _ = grid.dimensions
    return filled(
        "grid_t", first=part.start, stop=part.stop, nx=nx, ny=ny, start=grid.first, frame=frame
    )


def to_source(sampling, control_points):
    """Transforms from the target of a `Sampling` to its source: a source_t."""
    source = sampling.source.whole
    matrix, offset = sampling.target.whole.index_transform(source)
    to_index = source.world_to_index
    return filled(
        "source_t",
        from_target=transform(matrix, offset + to_index @ control_points.mean_displacement),
        from_displacement=transform(to_index * control_points.scale, np.zeros(3)),
        continued=sampling.continues,
    )


def transform(matrix, offset):
    """An affine transform in the layout of `transformed` in types.cl: (12,)."""
    return np.concatenate([np.asarray(matrix).T.ravel(), offset])


def is_for_device(array, device):
    """Whether kernels of a device can read an array."""
    name = array.dtype.name
    sums = name in _SUMMED_IN_FLOAT or device.has_float64
    return name in _C_TYPES and sums


def c_type(array):
    """The type of its elements in OpenCL C."""
    return _C_TYPES[array.dtype.name]


def array_constants(array, device):
    """Build constants of kernels that read an array."""
    in_float = array.dtype.name in _SUMMED_IN_FLOAT
    return (
        ("LANES", device.lanes if in_float else device.double_lanes),
        *(() if in_float else FLOAT64),
        ("VALUE", c_type(array)),
        ("IS_INTEGER", int(array.dtype.kind in "iu")),
        offset(array),
    )


def offset(array):
    """The build constant for offsets in an array."""
    return "OFFSET", "int" if array.size < 2**31 else "long"
