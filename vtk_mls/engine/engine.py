"""The map on an OpenCL device: the questions of `protocol.Engine`, answered by kernels."""

from __future__ import annotations

import functools
import threading
from contextlib import ExitStack
from typing import NamedTuple

import numpy as np

from vtk_mls.base import buffer_pool, interpolation
from vtk_mls.base.progress import SILENT
from vtk_mls.base.sampling import Sampling
from vtk_mls.engine.device import devices
from vtk_mls.engine.launch import array_types, kernel_arguments
from vtk_mls.engine.launch.launcher import Launcher, RegionMap
from vtk_mls.engine.map.inverse import InverseSearch
from vtk_mls.engine.sample import differences, void_corners
from vtk_mls.engine.sample.sampler import samplers
from vtk_mls.queries import vector_fields


@functools.cache
def on(device):
    """The engine on `device`, made once."""
    return Engine(device)


def _question(method):
    """A question: one at a time is answered, in pieces that fit the memory."""
    in_pieces = _again_in_smaller_pieces(method)

    @functools.wraps(method)
    def ask(self, *arguments, **options):
        with self._lock:
            return in_pieces(self, *arguments, **options)

    return ask


def _again_in_smaller_pieces(method):
    """A method that is called anew with less memory where the device has not enough."""

    def answer(self, *arguments, **options):
        while True:
            try:
                with devices.driver_errors(self.device):
                    return method(self, *arguments, **options)
            except devices.OutOfDeviceMemory:
                if not self.memory.shrink():
                    raise

    return answer


class _Asked(NamedTuple):
    """A kernel that tells where points come from, and how many planes it writes."""

    kernel: str
    planes: int


_INDEX = _Asked("grid_source_index", 3)  # continuous indices of the whole source
_FRAME = _Asked("grid_source_frame", 12)  # these, and Jacobians


class Engine:
    """An engine, as `protocol.Engine` describes it, on one device.

    Attributes
    ----------
    NAME : str
        The device, for people.
    device : Device
    memory : Memory
    """

    def __init__(self, device):
        self.NAME = str(device)
        self.device = device
        self.launcher = Launcher(device)
        self.memory = self.launcher.memory
        self._lock = threading.RLock()  # a kernel's arguments belong to one launch at a time

    @_question
    def backward(self, deformation, points, progress=SILENT):
        return self._origins(deformation, points, progress)[0]

    @_question
    def void_distance(self, deformation, points, progress=SILENT):
        return self._origins(deformation, points, progress)[1]

    @_question
    def origins_from(self, deformation, points, starts, progress=SILENT):
        origins, void_distance = np.empty_like(points), np.empty(len(points))
        maps = self._maps(deformation)
        for part in progress.over(self.launcher.slabs(len(points), deformation, 48)):
            for map_ in maps:
                rows = _held(deformation.planes, map_.region, starts, part)
                origins[rows], void_distance[rows] = map_.origins(points[rows], starts[rows])
        return origins, void_distance

    @_question
    def jacobian(self, deformation, points, progress=SILENT, origins=None):
        result, numbers = np.empty((len(points), 3, 3)), None
        if origins is None and deformation.has_rivals:
            choosing, progress = progress.divided(1, 2)
            numbers = self._origins(deformation, points, choosing)[2]
        sided = points if origins is None else origins  # what tells the region
        maps = self._maps(deformation)
        for part in progress.over(self.launcher.slabs(len(points), deformation, 60)):
            for number, map_ in enumerate(maps):
                if numbers is None:
                    rows = _held(deformation.planes, map_.region, sided, part)
                else:
                    rows = part.start + np.flatnonzero(numbers[part] == number)
                known = None if origins is None else origins[rows]
                planes = map_.jacobian(points[rows], known)
                result[rows] = np.eye(3) + planes.T.reshape(-1, 3, 3)
        return result

    @_question
    def forward(self, deformation, points, progress=SILENT):
        displacement = np.empty((len(points), 3), np.float32)
        found = np.zeros(len(points), bool)
        searches = [
            InverseSearch(self.launcher, deformation, region) for region in deformation.regions
        ]
        for part in progress.over(self.launcher.search_slabs(len(points), deformation)):
            for search in searches:
                rows = _held(deformation.planes, search.map.region, points, part)
                displacement[rows], found[rows] = search.forward(points[rows])
        return displacement, found

    @_question
    def displacement_field(self, deformation, grid, progress=SILENT):
        displacement = buffer_pool.empty((grid.size, 3), np.float32)
        void_distance = buffer_pool.empty(grid.size if deformation.cuts else 0, np.float32)
        launches = self._launches(deformation)
        for part in progress.over(self.launcher.slabs(grid.size, deformation, 16)):
            with ExitStack() as buffers:
                out = buffers.enter_context(self.memory.written(displacement[part]))
                distance = None
                if deformation.cuts:
                    distance = buffers.enter_context(self.memory.exchanged(void_distance[part]))
                for map_, second_pass in launches:
                    outputs = [kernel_arguments.world(map_.control_points), out]
                    outputs += map_.void_outputs(distance)
                    map_.launch_on_grid(
                        *("grid_displacement", grid, part, *outputs),
                        second_pass=second_pass,
                        coarsely=True,
                    )
        void_distance = void_distance.reshape(grid.shape) if deformation.cuts else None
        return displacement.reshape(*grid.shape, 3), void_distance

    @_question
    def jacobian_field(self, deformation, grid, progress=SILENT):
        result = buffer_pool.empty((grid.size, 9), np.float32)
        launches = self._launches(deformation)
        slabs = self.launcher.slabs(grid.size, deformation, 36)
        rivals = self._rivals(deformation, slabs)
        for part in progress.over(slabs):
            with self.memory.written(result[part]) as out:
                for map_, second_pass in launches:
                    outputs = [out, *map_.void_outputs(rivals)]
                    map_.launch_on_grid(
                        "grid_jacobian", grid, part, *outputs, second_pass=second_pass
                    )
        return result.reshape(*grid.shape, 3, 3)

    @_question
    def resample(
        self,
        deformation,
        arrays,
        sampling,
        progress=SILENT,
        void_distance=None,
        covariant=None,
    ):
        target, covariant = sampling.target, covariant or {}
        results = [buffer_pool.empty(target.shape + a.shape[3:], a.dtype) for a in arrays]
        rows = [result.reshape(-1, *array.shape[3:]) for array, result in zip(arrays, results)]
        largest = max((a.itemsize * int(np.prod(a.shape[3:])) for a in arrays), default=0)
        arrays = samplers(self.launcher, arrays, sampling, covariant)
        asked = _FRAME if covariant else _INDEX
        for part, sources in self._sources(
            asked, deformation, sampling, largest, progress, void_distance
        ):
            for array, result in zip(arrays, rows):
                array.sample(sources, result[part])
        return results

    @_question
    def gradient(self, array, grid, progress=SILENT):
        if not array_types.is_for_device(array, self.device):
            return vector_fields.gradient(array, grid, progress)
        return differences.gradient(self.launcher, array, grid, progress)

    @_question
    def sample(self, array, index, method, background, source):
        if len(index) == 0 or not array_types.is_for_device(array, self.device):
            return interpolation.sample(array, index, method, background, source)
        result = np.empty((len(index), *array.shape[3:]), array.dtype)
        sampling = Sampling(source, interpolation=method, background=background)
        (sampler,) = samplers(self.launcher, [array], sampling, {})
        with self.memory.read(np.ascontiguousarray(index.T, np.float32)) as planes:
            sampler.sample(planes, result)
        return result

    @_question
    def void_by_corners(self, void_distance, least, progress=SILENT):
        return void_corners.void_by_corners(self.launcher, void_distance, least, progress)

    @_question
    def void_distance_listed(self, deformation, grid, numbers, progress=SILENT):
        result = np.empty(len(numbers), np.float32)
        launches = self._launches(deformation)
        for part in progress.over(self.launcher.slabs(len(numbers), deformation, 16)):
            with self.memory.exchanged(result[part]) as distance:
                for map_, second_pass in launches:
                    world = kernel_arguments.world(map_.control_points)
                    outputs = [world, None, *map_.void_outputs(distance)]
                    map_.launch_listed(
                        *("grid_displacement", grid, numbers[part], *outputs),
                        second_pass=second_pass,
                    )
        return result

    @_question
    def source_bounds(self, deformation, sampling, progress=SILENT):
        bounds = interpolation.NO_BOUNDS
        for part, index in self._sources(_INDEX, deformation, sampling, 0, progress):
            planes = self.memory.planes(index, part.stop - part.start)
            bounds = interpolation.joined_bounds(bounds, planes.T, sampling.source.whole)
        return bounds

    def _maps(self, deformation):
        return [RegionMap(self.launcher, deformation, region) for region in deformation.regions]

    def _launches(self, deformation):
        """The maps to launch on a grid, and whether as a rival."""
        maps = self._maps(deformation)
        rivals = [(map_, True) for map_ in maps] if deformation.has_rivals else []
        return [(map_, False) for map_ in maps] + rivals

    def _rivals(self, deformation, slabs):
        """A buffer for void distances that only tell which of rivals has a point; or None."""
        if not deformation.has_rivals:
            return None
        return self.memory.scratch("rivals", 4 * slabs[0].stop)

    def _origins(self, deformation, points, progress):
        """Origins of `points` (m, 3), and where cuts are in the rest frame void distances.

        And the numbers of the regions that they are from.
        """
        origins, numbers = np.empty_like(points), np.empty(len(points), np.int8)
        void_distance = np.full(len(points), np.inf)
        maps = list(enumerate(self._maps(deformation)))

        def take(number, map_, rows, second_pass):
            found, distance = map_.origins(points[rows])
            if second_pass:
                rows, found, distance = (
                    a[distance > void_distance[rows]] for a in (rows, found, distance)
                )
            origins[rows], numbers[rows] = found, number
            if distance is not None:
                void_distance[rows] = distance

        for part in progress.over(self.launcher.slabs(len(points), deformation, 32)):
            for number, map_ in maps:
                take(
                    number, map_, _held(deformation.moved_planes, map_.region, points, part), False
                )
            if deformation.has_rivals:
                expected = numbers[part].copy()
                for number, map_ in maps:
                    void = (void_distance[part] < 0) & (expected != number)
                    take(number, map_, part.start + np.flatnonzero(void), True)
        return origins, void_distance, numbers

    def _sources(self, asked, deformation, sampling, largest, progress, void_distance=None):
        """Parts of the target; a buffer with what is asked of where they come from, in planes.

        Void distances of the target are written, if there is an array for them. Beside there are
        buffers of the `largest` number of bytes for each point.
        """
        bytes_per_point = 4 * asked.planes
        slabs = self.launcher.sampled_slabs(
            sampling.target.size, deformation, bytes_per_point + 4 + largest
        )
        sources = self.memory.scratch("sources", bytes_per_point * slabs[0].stop)
        rivals = self._rivals(deformation, slabs)
        launches = [
            (map_, kernel_arguments.to_source(sampling, map_.control_points), second_pass)
            for map_, second_pass in self._launches(deformation)
        ]
        for part in progress.over(slabs):
            with ExitStack() as buffers:
                distance = rivals
                if deformation.cuts and void_distance is not None:
                    distance = buffers.enter_context(self.memory.exchanged(void_distance[part]))
                for map_, to_source, second_pass in launches:
                    outputs = [sources, *map_.void_outputs(distance)]
                    map_.launch_on_grid(
                        *(asked.kernel, sampling.target, part, to_source, *outputs),
                        second_pass=second_pass,
                        coarsely=True,
                    )
            yield part, sources


def _held(planes, region, points, part):
    """Rows of `points[part]` that are in `region`: a slice where that is all or nothing."""
    if not planes:
        return part
    here = region.holds(planes, points[part])
    if here.all():
        return part
    return part.start + np.flatnonzero(here) if here.any() else slice(0, 0)
