"""Images that are blocks of one lattice, joined to one image.

Material that crosses a border between such blocks is found on the other side.
"""

import math
from itertools import chain
from typing import NamedTuple

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls.files import metadata
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

_MAX_SHIFT = 1e-4  # voxels between points of one lattice


class LatticeBlock(NamedTuple):
    """A block of a joined image."""

    image: vtkImageData  # joined
    extent: tuple  # of the block, in the indices of the joined image
    same_arrays: dict  # `__this__` of the arrays of the block by that of the joined arrays


def lattice_blocks(blocks):
    """The `LatticeBlock` of each of `blocks` that is a part of a joined image, by its `__this__`.

    Blocks, vtkDataSets, are joined if they touch or overlap, have the same arrays with the same
    values where they overlap, and fill a box together. Images with ghosts, with arrays that are not
    numeric, or with the extent of another one, are not joined.
    """
    result = {}
    for places in _lattices(blocks):
        for connected in _connected(places):
            joined = _joined(connected) if len(connected) > 1 else None
            if joined is None:
                continue
            for block, extent in connected:
                same = dict(zip(_addresses(joined), _addresses(block)))
                extent = tuple(extent.ravel().tolist())
                result[block.__this__] = LatticeBlock(joined, extent, same)
    return result


def _lattices(blocks):
    """For each lattice and set of arrays, a list of blocks and their extents (3, 2) on it."""
    lattices = []
    for block in blocks:
        signature = _signature(block)
        if signature is None:
            continue
        grid = ImageGeometry.of_image(block).grid
        for reference, other_signature, places in lattices:
            extent = _extent_on(reference, grid)
            if other_signature == signature and extent is not None:
                places.append((block, extent))
                break
        else:
            extent = np.column_stack([(0, 0, 0), np.array(grid.dimensions) - 1])
            lattices.append((grid, signature, [(block, extent)]))
    return [places for _, _, places in lattices]


def _signature(block):
    """Names and types of the arrays of an image; None if it cannot be joined to others."""
    if not isinstance(block, vtkImageData) or block.GetNumberOfPoints() == 0:
        return None
    signature = [metadata.load(block, metadata.LABEL_ARRAYS)]
    for attributes, count in (
        (block.GetPointData(), block.GetNumberOfPoints()),
        (block.GetCellData(), block.GetNumberOfCells()),
    ):
        for array in arrays.all_arrays(attributes):
            is_sound = arrays.is_numeric(array) and array.GetNumberOfTuples() == count
            if not is_sound or array.GetName() == arrays.GHOSTS:
                return None
            kind = array.GetName(), array.GetDataType(), array.GetNumberOfComponents()
            signature.append((attributes.GetClassName(), *kind))
    return signature


def _extent_on(reference, grid):
    """The extent (3, 2) of a grid in the indices of another one; None if it has other points."""
    ends = np.array([grid.origin, grid.at(np.array(grid.dimensions)[None] - 1)[0]])
    is_parallel = np.allclose(grid.direction, reference.direction, rtol=0, atol=1e-6)
    if not is_parallel or not np.allclose(grid.spacing, reference.spacing, rtol=1e-6, atol=0):
        return None
    indices = np.linalg.solve(reference.index_to_world, (ends - reference.origin).T)
    rounded = np.round(indices)
    return rounded.astype(int) if np.abs(indices - rounded).max() <= _MAX_SHIFT else None


def _connected(places):
    """Lists of places that touch each other, or are direct neighbors."""
    groups = []
    for place in places:
        low, high = place[1].T
        near, far = [], []
        for group in groups:
            touches = (((low <= e[:, 1] + 1) & (e[:, 0] <= high + 1)).all() for _, e in group)
            (near if any(touches) else far).append(group)
        groups = [*far, [*chain(*near), place]]
    return groups


def _joined(places):
    """One image of blocks that fill a box; None for others."""
    blocks, extents = zip(*places)
    first, extents = blocks[0], np.array(extents)
    low, high = extents[:, :, 0].min(axis=0), extents[:, :, 1].max(axis=0)
    if len({extent.tobytes() for extent in extents}) < len(places):
        return None  # several images of the same place
    geometry = ImageGeometry.of_grid(ImageGeometry.of_image(first).grid)
    image = vtkImageData()
    geometry.part(np.column_stack([low, high]).ravel().tolist()).apply_to(image)
    has_cells = any(block.GetCellData().GetNumberOfArrays() for block in blocks)
    is_flat = (extents[:, :, 0] == extents[:, :, 1]) & (low < high)
    if has_cells and is_flat.any():  # cells of a slice are no cells of a volume
        return None
    for name, is_cells in (("GetPointData", False), ("GetCellData", True))[: 1 + has_cells]:
        data = [getattr(block, name)() for block in blocks]
        values = _values(data, extents - low[None, :, None], is_cells)
        if values is None:
            return None
        arrays.set_values(getattr(image, name)(), values, data[0])
    metadata.store(image, metadata.LABEL_ARRAYS, metadata.load(first, metadata.LABEL_ARRAYS))
    return image


def _values(data, extents, is_cells):
    """The values of each joined array, as `image_values` has them; None if blocks do not fit."""
    starts = extents[:, :, 0]
    sizes = extents[:, :, 1] - starts + (not is_cells)
    sizes = np.maximum(sizes, 1)
    shape = tuple((starts + sizes).max(axis=0)[::-1].tolist())
    if math.prod(shape) > sizes.prod(axis=1).sum():
        return None  # they leave some of the box open
    filled = np.zeros(shape, bool)
    results = None
    for attributes, start, size in zip(data, starts, sizes):
        region = tuple(slice(s, s + n) for s, n in zip(start[::-1], size[::-1]))
        parts = [arrays.to_numpy(array) for array in arrays.all_arrays(attributes)]
        parts = [part.reshape(*size[::-1], *part.shape[1:]) for part in parts]
        if results is None:
            results = [np.zeros(shape + part.shape[3:], part.dtype) for part in parts]
        overlap = filled[region]
        for result, part in zip(results, parts):
            if not np.array_equal(result[region][overlap], part[overlap], equal_nan=True):
                return None
            result[region] = part
        filled[region] = True
    return results if filled.all() else None


def _addresses(image):
    """`__this__` of all arrays."""
    data = arrays.all_arrays(image.GetPointData()) + arrays.all_arrays(image.GetCellData())
    return [array.__this__ for array in data]
