"""Host data as the kernels read it: the layouts of structs, and what fills them."""

from __future__ import annotations

import functools

import numpy as np


def _struct(members):
    """The dtype of a C struct, its padding at the end a member: rusticl 22.3 does not count it."""
    dtype = np.dtype(members, align=True)
    last = dtype.names[-1]
    padding = dtype.itemsize - dtype.fields[last][1] - dtype[last].itemsize
    return np.dtype([*members, ("padding", "i4", (padding // 4,))]) if padding else dtype


_TRANSFORM = ("f4", 12)  # columns for x, y, z, then the offset, three numbers each

# A control point: q, the factor of its weight, p - q less its mean; in local units.
CONTROL_POINT = _struct([("q", "f4", 3), ("c", "f4"), ("u", "f4", 3), ("unused", "f4")])
# Local displacements in the world: their unit, and their mean, which the kernels leave out.
WORLD = _struct([("scale", "f4"), ("mean_displacement", "f4", 3)])
# The points of a launch over a grid: the first and that past the last, the size of the grid, the
# index of its first point in the whole grid, the transform from such indices to the local frame.
GRID = _struct(
    [
        *[("first", "i8"), ("stop", "i8"), ("nx", "i4"), ("ny", "i4"), ("start", "i4", 3)],
        ("frame", *_TRANSFORM),
    ]
)
# Transforms of indices of a target, and of local displacements, to indices of a source; whether
# values continue where a cut has opened.
SOURCE = _struct(
    [("from_target", *_TRANSFORM), ("from_displacement", *_TRANSFORM), ("continued", "i4")]
)
# The lattice of first guesses for the inverse: center of its boxes, 1 / half the size of the first.
LATTICE = _struct([("center", "f4", 3), ("density", "f4", 3)])
# A sample of the map: v, and G(v) less the mean displacement.
SAMPLE = _struct([("v", "f4", 3), ("image", "f4", 3)])
# Nodes that give searches on a grid theirs: index of the first, nodes along x and y.
NODES = _struct([("first", "i4", 3), ("nx", "i4"), ("ny", "i4")])
# Cells of that lattice along each axis, and its levels, each twice as large as the one before.
LATTICE_CELLS, LATTICE_LEVELS = 20, 8
# From node to node so many points of the grid; 16 floats at each node.
NODE_STEP, NODE_BYTES = 4, 64
# Cells of a grid between nodes: those of a launch, the nodes around them, and a part of a list; a
# transform of slopes per index to those per local unit.
COARSE = _struct(
    [
        *[("first_listed", "i8"), ("listed", "i8"), ("first_cell", "i4", 3), ("cells", "i4", 3)],
        *[("first_node", "i4", 3), ("nodes", "i4", 3), ("to_slopes", *_TRANSFORM)],
    ]
)
# How far off cells may be: a transform of displacements to indices, and the square of a limit.
CHECK = _struct([("to_index", *_TRANSFORM), ("limit2", "f4")])
# An array of samples in space: points of the whole source along the axes, the first that is there
# and how many are; numbers at each.
ARRAY = _struct([("size", "i4", 3), ("first", "i4", 3), ("there", "i4", 3), ("components", "i4")])

# Slices of void distances: points along the axes, the first slice and how many are there, from and
# to which layer of cells something is wanted, how far from a face corners are that tell.
LAYERS = _struct(
    [
        *[("size", "i4", 3), ("first", "i4"), ("there", "i4"), ("start", "i4"), ("stop", "i4")],
        ("least", "f4"),
    ]
)
# Slices of an array: the size of all of it, the first slice that is there, from and to which slice
# the gradient is wanted; a transform of slopes per index to those per world unit.
SLICES = _struct(
    [
        *[("size", "i4", 3), ("first", "i4"), ("start", "i4"), ("stop", "i4")],
        ("to_world", *_TRANSFORM),
    ]
)


def planes(points):
    """Points (m, 3) as the kernels take them: (3, m) float32."""
    return np.ascontiguousarray(points.T, dtype=np.float32)


@functools.cache
def members(dtype):
    """The members of the C struct that a structured dtype is, of numbers and arrays of them."""
    types = {"f4": "float", "f8": "double", "i4": "int", "i8": "long"}
    types = {np.dtype(name): in_c for name, in_c in types.items()}
    text = []
    for name in dtype.names:
        base, shape = dtype[name].base, dtype[name].shape
        text.append(f"{types[base]} {name}{''.join(f'[{n}]' for n in shape)};")
    return " ".join(text)


def record(numbers):
    """A dict of names and numbers of numpy, as a structured array of one element."""
    arrays = {name: np.asarray(value) for name, value in numbers.items()}
    return filled(_struct([(name, a.dtype, a.shape) for name, a in arrays.items()]), **arrays)


def filled(dtype, **values):
    """A structured array of one element: a struct that a kernel takes by value."""
    result = np.zeros((), dtype)
    for name, value in values.items():
        result[name] = value
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
    """What tells where in the source of a `Sampling` points of its target come from: a SOURCE."""
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
    """An affine transform as `transformed` in grid.cl takes it."""
    return np.concatenate([np.asarray(matrix).T.ravel(), offset])


# Build constants of kernels that find cells of the lattice.
LATTICE_CONSTANTS = (
    ("LATTICE", members(LATTICE)),
    ("LATTICE_CELLS", LATTICE_CELLS),
    ("LATTICE_LEVELS", LATTICE_LEVELS),
)
# Build constants of all kernels of the map.
STRUCTS = (
    ("CONTROL_POINT", members(CONTROL_POINT)),
    ("WORLD", members(WORLD)),
    ("GRID", members(GRID)),
    ("SOURCE", members(SOURCE)),
    *LATTICE_CONSTANTS,
    ("SAMPLE", members(SAMPLE)),
    ("NODES", members(NODES)),
    ("NODE_STEP", NODE_STEP),
)
