"""Images, resampled backward, and joined before if they are blocks of one lattice.

Material that crosses a border between such blocks is found on the other side.
"""

import itertools
import math
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls.base import buffer_pool, interpolation
from vtk_mls.base.sampling import AUTOMATIC, corner_median
from vtk_mls.files import metadata
from vtk_mls.filters import derived_arrays, pipeline
from vtk_mls.filters.algorithm import run_all
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

_MAX_SHIFT = 1e-4  # voxels between points of one lattice


@dataclass(frozen=True)
class ImageOptions:
    """How the arrays of an image are resampled, and which are added."""

    directions: derived_arrays.DirectionArrays
    gradient_array: str  # point scalars whose gradient is added, or ""
    label_arrays: tuple  # names of arrays that are sampled nearest
    flags: frozenset  # `__this__` of arrays of 0 and 1
    hides_void: bool
    is_cached: bool  # whether a GPU keeps the arrays for later updates


def automatic_backgrounds(geometry, part_at):
    """The `corner_median` of each array of an image: a dict by `_key`.

    `geometry` is the ImageGeometry of the whole image; `part_at` gives a vtkImageData that holds
    the extent of a cell at a corner.
    """
    values, ends = {}, np.reshape(geometry.extent, (3, 2))
    for corner in itertools.product(*(sorted(set(pair)) for pair in ends.tolist())):
        cell = [
            (max(i - (i > low), low), min(i + (i == low), high))
            for i, (low, high) in zip(corner, ends.tolist())
        ]
        image = part_at(sum(cell, ()))
        part = ImageGeometry.of_image(image)
        for is_points, data, grid in (
            (True, image.GetPointData(), part.grid),
            (False, image.GetCellData(), part.grid.cells),
        ):
            last = np.subtract(grid.dimensions, 1)
            index = np.minimum(np.subtract(corner, part.extent[::2]), last)
            for number, array in enumerate(arrays.image_values(data, grid)):
                key = _key(is_points, data.GetAbstractArray(number), number)
                values.setdefault(key, []).append(array[tuple(index[::-1])])
    return {key: corner_median(found) for key, found in values.items()}


def backgrounds_of(image):
    """`automatic_backgrounds` of a whole vtkImageData."""
    return automatic_backgrounds(ImageGeometry.of_image(image), lambda extent: image)


def _key(is_points, array, index):
    return is_points, array.GetName() or index


class Resampling:
    """The resampling of one image, or of a part of it.

    `output`, a vtkImageData with the geometry of the target, is filled. `sampling` goes from the
    grid of the image to that of the output. `backgrounds` are `automatic_backgrounds` that replace
    those of `image`, which may be a part. `used_backgrounds`, pairs of name and number or tuple of
    numbers, are those that were used.
    """

    def __init__(self, options, deformation, image, output, sampling, backgrounds=None):
        self.options, self.deformation = options, deformation
        self.image, self.output = image, output
        self.sampling, self.target = sampling, sampling.target
        # at the points of the target, once they are mapped
        self._void_distance = self._gradient = None
        name = options.gradient_array
        self._scalars = derived_arrays.scalars(image, name) if name else None  # (nz, ny, nx)
        self.used_backgrounds, self._backgrounds = set(), backgrounds or {}
        if sampling.background == AUTOMATIC:
            self._backgrounds = backgrounds_of(image) | self._backgrounds
        self.labels = {*options.label_arrays, *metadata.load(image, metadata.LABEL_ARRAYS)}
        for data in (image.GetPointData(), image.GetCellData()):
            ids = data.GetGlobalIds(), data.GetPedigreeIds()
            self.labels.update(array.GetName() for array in ids if array is not None)

    def tasks(self):
        """Functions of a Progress, in their order."""
        cell_sampling = pipeline.cell_sampling(self.sampling)
        tasks = [
            partial(self._resample, source, result, sampling)
            for source, result, sampling in (
                (self.image.GetPointData(), self.output.GetPointData(), self.sampling),
                (self.image.GetCellData(), self.output.GetCellData(), cell_sampling),
            )
            if source.GetNumberOfArrays() > 0
        ]
        if self.deformation.cuts:  # the arrays of the void
            tasks += [self._mark_points, self._mark_cells]
        if self._scalars is not None:
            tasks.append(self._add_gradient)
        return tasks

    def _resample(self, source, result, sampling, progress):
        values = arrays.image_values(source, sampling.source)
        results, is_points = [None] * len(values), sampling is self.sampling
        directions = self.options.directions.of(source)

        def transform(index, direction, progress):
            results[index] = self._transformed(values[index], direction, sampling, progress)

        def fill(progress):
            chosen = [values[index] for index, _ in others]
            details = self._detailed(others, [v.dtype for v in chosen], sampling, is_points)
            filled = self._resampled(chosen, details, is_points, progress)
            for (index, _), array in zip(others, filled):
                results[index] = array

        tasks, others = [], []
        for index, array in enumerate(arrays.all_arrays(source)):
            direction = directions.get(array.GetName())
            if direction:
                tasks.append(partial(transform, index, direction))
            else:
                others.append((index, array))
        if others or (is_points and self._scalars is not None):
            tasks.append(fill)
        run_all(tasks, progress)
        arrays.set_values(result, results, source)

    def _detailed(self, indexed_arrays, dtypes, sampling, is_points):
        """A `Sampling` with the settings of each array, of pairs (index, vtkAbstractArray)."""
        methods, backgrounds, checked = [], [], {}
        for (index, array), dtype in zip(indexed_arrays, dtypes):
            method, background = self._method(array)
            if background is None and sampling.background == AUTOMATIC:
                background = self._automatic(_key(is_points, array, index))
                self.used_backgrounds.add((array.GetName(), background))
            elif background is None:
                background = sampling.background
                checked[f"array `{array.GetName()}`"] = dtype
                if not interpolation.is_in_range(background, dtype):
                    background = interpolation.cast(background, dtype).item()
            methods.append(method)
            backgrounds.append(background)
        sampling.warn_of_background(checked)
        versions = [self._version(array) for _, array in indexed_arrays]
        settings = {"interpolation": methods, "background": backgrounds, "versions": versions}
        return replace(sampling, **settings)

    def _resampled(self, values, sampling, is_points, progress):
        """Values (nz, ny, nx[, components]) at the target; with the gradient in the same pass."""
        void_distance = None
        if is_points and self.deformation.cuts:
            void_distance = buffer_pool.empty(self.target.shape, np.float32)
            self._void_distance = void_distance
        if not is_points or self._scalars is None:
            return self.deformation.resample(values, sampling, progress, void_distance)
        background = self.sampling.background
        if background == AUTOMATIC:
            background = self._automatic((True, self.options.gradient_array))
        methods = [*sampling.interpolation, self.sampling.interpolation]
        backgrounds = [*sampling.background, background]
        results, self._gradient = self.deformation.resample_with_gradient(
            values,
            self._scalars,
            replace(sampling, interpolation=methods, background=backgrounds),
            self.options.directions.is_unit,
            progress,
            void_distance,
        )
        return results

    def _automatic(self, key):
        """The automatic background of an array; 0 for labels."""
        return 0 if key[1] in self.labels else self._backgrounds[key]

    def _transformed(self, vectors, direction, sampling, progress):
        """Vectors (nz, ny, nx, 3) at the target, transformed with the map."""
        if direction == "tangent":
            result = self.deformation.resample_vectors(vectors, sampling, progress)
        else:
            unit = direction == "normal" or self.options.directions.is_unit
            result = self.deformation.resample_gradients(vectors, sampling, unit, progress)
        return result.astype(vectors.dtype)

    def _version(self, array):
        """A key for the contents of an array, or None."""
        if not self.options.is_cached:
            return None
        # with the image's time, as writers may call Modified of the image only
        return array.__this__, array.GetMTime(), self.image.GetMTime()

    def _method(self, array):
        """Interpolation and background of an array; None for that of the sampling."""
        if not arrays.is_numeric(array):
            return "nearest", -1
        if array.GetName() == arrays.GHOSTS:
            return "nearest", 0.0
        if array.__this__ in self.options.flags:
            background = self.sampling.background
            return "nearest", float(background != AUTOMATIC and abs(background) > 0)
        if array.GetName() in self.labels:
            return "nearest", None
        return self.sampling.interpolation, None

    def _mark_points(self, progress):
        if self._void_distance is None:
            self._void_distance = self.deformation.void_distance_field(self.target, progress)
        data = self.output.GetPointData()
        derived_arrays.add_void(data, self._void_distance)
        if self.options.hides_void:
            derived_arrays.hide(data, arrays.to_numpy(data.GetArray("Void")))

    def _mark_cells(self, progress):
        data = self.output.GetCellData()
        void_distance, self._void_distance = self._void_distance, None
        void = self.deformation.void_of_cells(self.target, void_distance, progress)
        arrays.add(data, "Void", void.at_center.ravel())
        if self.options.hides_void and derived_arrays.CAN_HIDE_CELLS:
            derived_arrays.hide(data, void.at_center | void.touched)

    def _add_gradient(self, progress):
        arrays.add(self.output.GetPointData(), "Gradient", self._gradient.reshape(-1, 3))


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
        groups = [*far, [*itertools.chain(*near), place]]
    return groups


def _joined(places):
    """One image of blocks that fill a box; None for others."""
    blocks, extents = zip(*places)
    first, extents = blocks[0], np.array(extents)
    low, high = extents[:, :, 0].min(axis=0), extents[:, :, 1].max(axis=0)
    if len({extent.tobytes() for extent in extents}) < len(places):
        return None  # several images of the same place
    geometry = ImageGeometry.of_grid(ImageGeometry.of_image(first).grid)
    extent = np.column_stack([low, high]).ravel().tolist()
    image = geometry.part(extent).apply_to(vtkImageData())
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
    sizes = np.maximum(extents[:, :, 1] - starts + (not is_cells), 1)
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
    data = arrays.all_arrays(image.GetPointData()) + arrays.all_arrays(image.GetCellData())
    return [array.__this__ for array in data]
