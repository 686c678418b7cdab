"""The engine of OpenCL devices: implements `protocol.Engine` with kernels."""

import functools
import threading
from contextlib import ExitStack

import numpy as np
import pyopencl as cl

from vtk_mls.base import buffer_pool, interpolation, lazy
from vtk_mls.base.progress import SILENT
from vtk_mls.engine.device import devices
from vtk_mls.engine.launch import kernel_arguments
from vtk_mls.engine.launch.launcher import Launcher
from vtk_mls.engine.map.inverse import InverseSearch
from vtk_mls.engine.map.region_map import RegionMap
from vtk_mls.engine.sample import grid_kernels
from vtk_mls.engine.sample.sampler import NO_VECTORS, Sampler, samplers
from vtk_mls.queries import vector_fields
from vtk_mls.queries.inverses import direct_inverses

_MAX_SEARCHED = 1 << 18  # points of one search for forward images
# Points whose source indices stay in the cache of a CPU between the two kernels of a resampling.
_MAX_CACHED = 1 << 19


@lazy.cached
def on(device):
    """The engine on `device`, created once."""
    return Engine(device)


def _exclusive(method):
    """A method that one thread runs at a time, repeated with less memory if the device has too
    little."""

    @functools.wraps(method)
    def run(self, *arguments, **options):
        with self._lock:
            while True:
                try:
                    return method(self, *arguments, **options)
                except cl.Error as error:
                    failure = devices.failure(self.device, error)
                    is_too_large = isinstance(failure, devices.OutOfDeviceMemory)
                    if not (is_too_large and self.memory.shrink()):
                        raise failure from error

    return run


class Engine:
    """A `protocol.Engine` on one device."""

    def __init__(self, device):
        self.NAME = str(device)
        self.device = device
        self.launcher = Launcher(device)
        self.memory = self.launcher.memory
        self._lock = threading.RLock()  # a kernel's arguments belong to one launch at a time

    @_exclusive
    def backward(self, deformation, points, progress=SILENT):
        return self._origins(deformation, points, progress)[0]

    @_exclusive
    def void_distance(self, deformation, points, progress=SILENT):
        return self._origins(deformation, points, progress)[1]

    @_exclusive
    def origins_from(self, deformation, points, starts, progress=SILENT):
        origins, void_distance = np.empty_like(points), np.empty(len(points))
        maps = self._maps(deformation)
        for part in progress.over(self.launcher.slabs(len(points), deformation, 48)):
            for map_ in maps:
                rows = _rows_in(map_.region, deformation.planes, starts, part)
                origins[rows], void_distance[rows] = map_.origins(points[rows], starts[rows])
        return origins, void_distance

    @_exclusive
    def jacobian(self, deformation, points, progress=SILENT, origins=None):
        result, region_indices = np.empty((len(points), 3, 3)), None
        if origins is None and deformation.has_competing_regions:
            choosing, progress = progress.divided(1, 2)
            region_indices = self._origins(deformation, points, choosing)[2]
        region_points = points if origins is None else origins  # these determine the region
        maps = self._maps(deformation)
        for part in progress.over(self.launcher.slabs(len(points), deformation, 60)):
            for i, map_ in enumerate(maps):
                if region_indices is None:
                    rows = _rows_in(map_.region, deformation.planes, region_points, part)
                else:
                    rows = part.start + np.flatnonzero(region_indices[part] == i)
                planes = map_.jacobian(points[rows], None if origins is None else origins[rows])
                result[rows] = np.eye(3) + planes.T.reshape(-1, 3, 3)
        return result

    @_exclusive
    def least_determinant(self, deformation, points, progress=SILENT):
        if deformation.steps_used == 1 and deformation.cuts:
            return np.linalg.det(self.jacobian(deformation, points, progress))
        result = np.empty(len(points))
        maps = self._maps(deformation)
        for part in progress.over(self.launcher.slabs(len(points), deformation, 60)):
            for map_ in maps:
                rows = _rows_in(map_.region, deformation.moved_planes, points, part)
                result[rows] = map_.at_points("step_determinant", 1, points[rows])[0]
        return result

    @_exclusive
    def forward(self, deformation, points, progress=SILENT):
        displacement = np.empty((len(points), 3), np.float32)
        found = np.zeros(len(points), bool)
        searches = [
            InverseSearch(self.launcher, deformation, region) for region in deformation.regions
        ]
        backward = functools.partial(self.backward, deformation)
        for part in progress.over(self.launcher.slabs(len(points), deformation, 64, _MAX_SEARCHED)):
            for search in searches:
                rows = _rows_in(search.map.region, deformation.planes, points, part)
                displacement[rows], found[rows] = search.forward(points[rows])
            rows, direct = direct_inverses(backward, deformation, points[part])
            displacement[part.start + rows], found[part.start + rows] = direct, True
        return displacement, found

    @_exclusive
    def displacement_field(self, deformation, grid, progress=SILENT):
        displacement = buffer_pool.empty((grid.size, 3), np.float32)
        void_distance = buffer_pool.empty(grid.size if deformation.cuts else 0, np.float32)
        launches = self._launches(deformation)
        for part in progress.over(self.launcher.slabs(grid.size, deformation, 16)):
            with ExitStack() as buffers:
                out = buffers.enter_context(self.memory.output_buffer(displacement[part]))
                distance = None
                if deformation.cuts:
                    distance = buffers.enter_context(self.memory.inout_buffer(void_distance[part]))
                for map_, second_pass in launches:
                    outputs = [kernel_arguments.world(map_.control_points), out]
                    outputs += map_.void_outputs(distance)
                    arguments = "grid_displacement", grid, part, *outputs
                    map_.launch_on_grid(*arguments, second_pass=second_pass, coarsely=True)
        void_distance = void_distance.reshape(grid.shape) if deformation.cuts else None
        return displacement.reshape(*grid.shape, 3), void_distance

    @_exclusive
    def jacobian_field(self, deformation, grid, progress=SILENT):
        result = buffer_pool.empty((grid.size, 9), np.float32)
        launches = self._launches(deformation)
        slabs = self.launcher.slabs(grid.size, deformation, 36)
        competing = self._competing_distances(deformation, slabs)
        for part in progress.over(slabs):
            with self.memory.output_buffer(result[part]) as out:
                for map_, second_pass in launches:
                    arguments = "grid_jacobian", grid, part, out, *map_.void_outputs(competing)
                    map_.launch_on_grid(*arguments, second_pass=second_pass)
        return result.reshape(*grid.shape, 3, 3)

    @_exclusive
    def resample(
        self, deformation, arrays, sampling, progress=SILENT, void_distance=None, covariant=None
    ):
        target = sampling.target
        results = [buffer_pool.empty(target.shape + a.shape[3:], a.dtype) for a in arrays]
        rows = [result.reshape(-1, *array.shape[3:]) for array, result in zip(arrays, results)]
        largest = max((a.itemsize * int(np.prod(a.shape[3:])) for a in arrays), default=0)
        arrays = [*zip(samplers(self.launcher, arrays, sampling, covariant or {}), rows)]
        vectors = [(array, rows) for array, rows in arrays if array.covariant is not None]
        for part, sources in self._sources(
            deformation, sampling, largest, progress, void_distance, vectors
        ):
            for array, rows in arrays:
                if array.covariant is None:
                    array.sample(sources, rows[part])
        return results

    @_exclusive
    def gradient(self, array, grid, progress=SILENT):
        if not kernel_arguments.is_for_device(array, self.device):
            return vector_fields.gradient(array, grid, progress)
        return grid_kernels.gradient(self.launcher, array, grid, progress)

    @_exclusive
    def sample(self, array, index, method, background, source, version=None):
        if len(index) == 0 or not kernel_arguments.is_for_device(array, self.device):
            return interpolation.sample(array, index.astype(float), method, background, source)
        result = np.empty((len(index), *array.shape[3:]), array.dtype)
        fits = self.memory.in_place or self.memory.fits(array.nbytes)
        sampler = Sampler(self.launcher, array, source, fits, method, background, version=version)
        with self.memory.input_buffer(np.ascontiguousarray(index.T, np.float32)) as planes:
            sampler.sample(planes, result)
        return result

    @_exclusive
    def void_by_corners(self, void_distance, min_distance, progress=SILENT):
        return grid_kernels.void_by_corners(self.launcher, void_distance, min_distance, progress)

    @_exclusive
    def doubtful_voxels(self, displacement, axes, progress=SILENT):
        return grid_kernels.doubtful_voxels(self.launcher, displacement, axes, progress)

    @_exclusive
    def void_distance_listed(self, deformation, grid, indices, progress=SILENT):
        result = np.empty(len(indices), np.float32)
        launches = self._launches(deformation)
        for part in progress.over(self.launcher.slabs(len(indices), deformation, 16)):
            with self.memory.inout_buffer(result[part]) as distance:
                for map_, second_pass in launches:
                    world = kernel_arguments.world(map_.control_points)
                    outputs = [world, None, *map_.void_outputs(distance)]
                    arguments = "grid_displacement", grid, indices[part], *outputs
                    map_.launch_listed(*arguments, second_pass=second_pass)
        return result

    @_exclusive
    def source_index(self, deformation, sampling, progress=SILENT):
        index = np.empty((3, sampling.target.size), np.float32)
        for part, planes in self._sources(deformation, sampling, 0, progress):
            index[:, part] = self.memory.planes(planes, part.stop - part.start)
        return index.T

    def _maps(self, deformation):
        return [RegionMap(self.launcher, deformation, region) for region in deformation.regions]

    def _launches(self, deformation):
        """The maps to launch on a grid, and whether it is the second pass.

        The second pass computes void points of other regions.
        """
        maps = self._maps(deformation)
        second = [(map_, True) for map_ in maps] if deformation.has_competing_regions else []
        return [(map_, False) for map_ in maps] + second

    def _competing_distances(self, deformation, slabs):
        """A buffer for void distances, if competing regions need it to choose; else None."""
        if not deformation.has_competing_regions:
            return None
        return self.memory.scratch("competing distances", 4 * slabs[0].stop)

    def _origins(self, deformation, points, progress):
        """Origins of `points` (m, 3), void distances (m,), and indices of their regions (m,).

        Void distances are infinite where G(v) suffices for them.
        """
        origins, region_indices = np.empty_like(points), np.empty(len(points), np.int8)
        void_distance = np.full(len(points), np.inf)
        maps = list(enumerate(self._maps(deformation)))

        def update(i, map_, rows, second_pass):
            found, distance = map_.origins(points[rows])
            if second_pass:
                better = distance > void_distance[rows]
                rows, found, distance = rows[better], found[better], distance[better]
            origins[rows], region_indices[rows] = found, i
            if distance is not None:
                void_distance[rows] = distance

        for part in progress.over(self.launcher.slabs(len(points), deformation, 32)):
            for i, map_ in maps:
                rows = _rows_in(map_.region, deformation.moved_planes, points, part)
                update(i, map_, rows, False)
            if deformation.has_competing_regions:
                first_pass = region_indices[part].copy()
                for i, map_ in maps:
                    void = (void_distance[part] < 0) & (first_pass != i)
                    update(i, map_, part.start + np.flatnonzero(void), True)
        return origins, void_distance, region_indices

    def _sources(self, deformation, sampling, largest, progress, void_distance=None, vectors=()):
        """Slices of the target, each with a buffer of source indices in planes.

        Void distances of the target are written to `void_distance` if it is given. `largest` is
        the number of bytes per point of the results of the caller. `vectors` are covariant ones:
        a Sampler and the rows of the result for each.
        """
        target = sampling.target
        max_count = _MAX_CACHED if self.memory.in_place else None
        slabs = self.launcher.slabs(target.size, deformation, 12 + 4 + largest, max_count)
        sources = self.memory.scratch("sources", 12 * slabs[0].stop)
        competing = self._competing_distances(deformation, slabs)
        launches = [
            (map_, kernel_arguments.to_source(sampling, map_.control_points), second_pass)
            for map_, second_pass in self._launches(deformation)
        ]

        def launch(part, index, distance, vectors=NO_VECTORS):
            arguments, constants = vectors
            # limits are not applied between nodes to what turns vectors
            coarsely = not (deformation.limits and vectors is not NO_VECTORS)
            for map_, to_source, second_pass in launches:
                outputs = [to_source, index, *map_.void_outputs(distance), *arguments]
                options = {"second_pass": second_pass, "coarsely": coarsely, "constants": constants}
                map_.launch_on_grid("grid_source_index", target, part, *outputs, **options)

        for part in progress.over(slabs):
            with ExitStack() as buffers:
                distance = competing
                if deformation.cuts and void_distance is not None:
                    distance = buffers.enter_context(self.memory.inout_buffer(void_distance[part]))
                if not any(array.fits for array, _ in vectors):
                    launch(part, sources, distance)
                for array, rows in vectors:
                    array.transform(launch, part, sources, distance, competing, rows[part])
            yield part, sources


def _rows_in(region, planes, points, part):
    """Rows of `points[part]` that are in `region`: a slice if all or none are."""
    if not planes:
        return part
    mask = region.holds(planes, points[part])
    if mask.all():
        return part
    return part.start + np.flatnonzero(mask) if mask.any() else slice(0, 0)
