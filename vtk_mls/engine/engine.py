"""The map on an OpenCL device: the questions of `reference`, answered by the kernels in opencl/."""

from __future__ import annotations

import functools
import threading
import weakref
from contextlib import ExitStack

import numpy as np
import pyopencl as cl

from vtk_mls import sampling
from vtk_mls.engine import device as devices
from vtk_mls.engine import kernel_arguments
from vtk_mls.engine.cut_tables import cut_tables
from vtk_mls.engine.inverse import InverseSearch

# Control points times functions times points of one launch: some tenths of a second on two CPU
# cores, so that progress shows and abort is heard.
_WORK_PER_LAUNCH = 3e8
# Bytes of device memory with which it is no use to begin again.
_LEAST_MEMORY = 1 << 20
# Points whose source indices stay in the cache of a CPU between the two kernels of a resampling.
_CACHED = 1 << 18
_TAPS = {"nearest": 1, "linear": 2, "cubic": 4}
_C_TYPES = {
    **{"int8": "char", "uint8": "uchar", "int16": "short", "uint16": "ushort"},
    **{"int32": "int", "uint32": "uint", "int64": "long", "uint64": "ulong"},
    **{"float32": "float", "float64": "double"},
}
# float32 holds every value of these and their sums to the digits they have
_SUMMED_IN_FLOAT = ("int8", "uint8", "int16", "uint16", "float32")


@functools.cache
def on(device):
    """The engine on `device`, made once."""
    return Engine(device)


def _question(method):
    """One question at a time; driver errors as sentences; short of memory, in smaller pieces."""

    @functools.wraps(method)
    def ask(self, *arguments, **options):
        with self._lock:
            while True:
                try:
                    with devices.driver_errors(self.device):
                        return method(self, *arguments, **options)
                except devices.OutOfDeviceMemory:
                    if self.memory < _LEAST_MEMORY:
                        raise
                    self._kept = None
                    self.memory //= 4

    return ask


class Engine:
    """Launches the kernels on one device.

    Attributes
    ----------
    NAME : str
        The device, for people.
    memory : int
        Bytes of device memory to use, a share if MPI processes use it too; larger grids go through
        in slabs.
    """

    def __init__(self, device):
        self.NAME = str(device)
        self.device = device
        self.context, self.queue = devices.context(device), devices.queue(device)
        self._in_place = device.kind == "cpu"  # works on the host's arrays, without copies
        self.memory = device.handle.global_mem_size // 2 // devices.sharers(device)
        self._kernels = {}
        self._uploaded = weakref.WeakKeyDictionary()  # handle set -> buffers
        self._at_any_points = weakref.WeakKeyDictionary()  # region -> constants, arguments
        self._kept = None
        self._lock = threading.RLock()  # a kernel's arguments belong to one launch at a time

    # The questions

    @_question
    def backward(self, deformation, points, progress=None):
        """G(v) (m, 3) float64 at `points` v (m, 3) float64, world coordinates."""
        result = np.empty_like(points)
        for where, control_points, planes in self._at_points(
            "point_displacement", deformation, points, 3, progress
        ):
            result[where] = (
                points[where] + control_points.mean_displacement + control_points.scale * planes.T
            )
        return result

    @_question
    def jacobian(self, deformation, points, progress=None):
        """dG_i/dv_j (m, 3, 3) float64 at `points` v (m, 3)."""
        result = np.empty((len(points), 3, 3))
        for where, _, planes in self._at_points("point_jacobian", deformation, points, 9, progress):
            result[where] = np.eye(3) + planes.T.reshape(-1, 3, 3)
        return result

    @_question
    def forward(self, deformation, points, progress=None):
        """v - x with G(v) = x at `points` x (m, 3), (m, 3) float32; whether there is one (m,)."""
        displacement = np.empty((len(points), 3), np.float32)
        found = np.zeros(len(points), bool)
        searches = [
            InverseSearch(self, deformation, r, points, progress) for r in deformation.regions
        ]
        for part in _stepped(self.search_slabs(len(points), deformation), progress):
            for search in searches:
                where = _held(deformation, search.region, points, part)
                displacement[where], found[where] = search.forward(points[where])
        return displacement, found

    @_question
    def displacement_field(self, deformation, grid, progress=None):
        """G(v) - v (nz, ny, nx, 3) float32 at v of `grid`, world units; the void distance."""
        displacement = np.empty((grid.size, 3), dtype=np.float32)
        void_distance = np.empty(grid.size if deformation.cuts else 0, dtype=np.float32)
        for part in _stepped(self._slabs(grid.size, deformation, 16), progress):
            with ExitStack() as buffers:
                outputs = [buffers.enter_context(self._written(displacement[part]))]
                if deformation.cuts:
                    outputs.append(buffers.enter_context(self._written(void_distance[part])))
                for region in deformation.regions:
                    control_points = region.control_points
                    self._launch_grid(
                        "grid_displacement",
                        deformation,
                        region,
                        grid,
                        part,
                        np.float32(control_points.scale),
                        kernel_arguments.float4(control_points.mean_displacement),
                        *outputs,
                    )
        void_distance = void_distance.reshape(grid.shape) if deformation.cuts else None
        return displacement.reshape(*grid.shape, 3), void_distance

    @_question
    def jacobian_field(self, deformation, grid, progress=None):
        """(dG/dv)^T (nz, ny, nx, 3, 3) float32 at the points v of `grid`."""
        result = np.empty((grid.size, 9), dtype=np.float32)
        for part in _stepped(self._slabs(grid.size, deformation, 36), progress):
            with self._written(result[part]) as out:
                for region in deformation.regions:
                    self._launch_grid("grid_jacobian", deformation, region, grid, part, out)
        return result.reshape(*grid.shape, 3, 3)

    @_question
    def resample(
        self, deformation, arrays, source, target, methods, background, continued, progress=None
    ):
        """Each of `arrays` on the grid `source`, deformed, at the points of the grid `target`."""
        results = [np.empty(target.shape + a.shape[3:], a.dtype) for a in arrays]
        largest = max((a.itemsize * int(np.prod(a.shape[3:])) for a in arrays), default=0)
        sources = _Sources(self, arrays, source)
        slabs = self._slabs(
            target.size, deformation, 12 + largest, _CACHED if self._in_place else None
        )
        index = self._scratch(12 * (slabs[0].stop - slabs[0].start))
        for part in _stepped(slabs, progress):
            count = part.stop - part.start
            self._launch_source_index(deformation, source, target, part, continued, index)
            for number, (array, method, result) in enumerate(zip(arrays, methods, results)):
                rows = result.reshape(-1, *array.shape[3:])[part]
                if not self._can_sample(array.dtype):
                    planes = np.empty((3, count), np.float32)
                    cl.enqueue_copy(self.queue, planes, index)
                    where = planes.T.astype(np.float64)
                    rows[:] = sampling.sample(array, where, method, background, source)
                    continue
                for rest in sources.fitting(number, index, count):
                    self._sample(rest, array, source, method, background, rows)
        return results

    @_question
    def resample_gradients(
        self, deformation, vectors, source, target, method, continued, normalise, progress=None
    ):
        """J_G^T n(G(v)) (nz, ny, nx, 3) float32 for `vectors` n, float32; the void distance."""
        result = np.empty((target.size, 3), np.float32)
        void_distance = np.empty(target.size if deformation.cuts else 0, np.float32)
        sources = _Sources(self, [vectors], source)
        slabs = self._slabs(target.size, deformation, 64, _CACHED if self._in_place else None)
        planes = self._scratch(48 * (slabs[0].stop - slabs[0].start))
        for part in _stepped(slabs, progress):
            count, rows = part.stop - part.start, result[part]
            with ExitStack() as buffers:
                if deformation.cuts:
                    there = buffers.enter_context(self._written(void_distance[part]))
                for region in deformation.regions:
                    outputs = [planes]
                    if deformation.cuts:
                        outputs += [np.float32(region.control_points.scale), there]
                    self._launch_grid(
                        "grid_source_frame",
                        deformation,
                        region,
                        target,
                        part,
                        *kernel_arguments.to_source(
                            source, target, region.control_points, continued
                        ),
                        *outputs,
                    )
            for rest in sources.fitting(0, planes, count):
                self._sample(rest, vectors, source, method, 0.0, rows)
            with self._exchanged(rows) as moved:
                self._launch(
                    "covariant",
                    (("LANES", self.device.lanes),),
                    count,
                    np.int64(count),
                    planes,
                    np.int32(normalise),
                    moved,
                )
        void_distance = void_distance.reshape(target.shape) if deformation.cuts else None
        return result.reshape(*target.shape, 3), void_distance

    @_question
    def source_bounds(self, deformation, source, target, continued, progress=None):
        """Lowest and highest index (2, 3) of `source.whole` that points of `target` come from."""
        bounds = sampling.NO_BOUNDS
        slabs = self._slabs(target.size, deformation, 12, _CACHED if self._in_place else None)
        size = slabs[0].stop - slabs[0].start
        index, planes = self._scratch(12 * size), np.empty(3 * size, np.float32)
        for part in _stepped(slabs, progress):
            self._launch_source_index(deformation, source, target, part, continued, index)
            here = planes[: 3 * (part.stop - part.start)].reshape(3, -1)
            cl.enqueue_copy(self.queue, here, index)
            bounds = sampling.joined_bounds(bounds, here.T, source.whole.dimensions)
        return bounds

    # What the search for the inverse asks for

    def local_points(self, control_points, points, offset=0):
        """`points` (m, 3) less `offset` in the local frame of `control_points`, (3, m) float32."""
        centre = control_points.centre + offset
        if points.dtype == np.float64 and not self.device.has_float64:
            points, centre = (points - centre).astype(np.float32), np.zeros(3)
        local = np.empty((3, len(points)), np.float32)
        if len(points) == 0:
            return local
        double = points.dtype == np.float64
        constants = [("LANES", self.device.lanes), ("COORDINATE", "double" if double else "float")]
        if double:
            constants.append(("USE_FP64", 1))
        with self._read(np.ascontiguousarray(points)) as x, self._written(local) as out:
            self._launch(
                "local_points",
                tuple(constants),
                len(points),
                np.int64(len(points)),
                x,
                kernel_arguments.float4(centre),
                kernel_arguments.float4(centre - np.float32(centre)),
                points.dtype.type(1 / control_points.scale),
                out,
            )
        return local

    def search_slabs(self, count, deformation):
        """Slices of `count` places whose inverse is looked for."""
        return self._slabs(count, deformation, 64, _CACHED)

    def run_at(self, kernel, deformation, region, places, arguments=(), changed=(), outputs=()):
        """Launch a kernel of the map at `places` (3, m) of the local frame of `region`.

        After the places it takes `arguments`, arrays that it changes, and arrays that it writes.
        """
        count = places.shape[1]
        if count == 0:
            return
        with ExitStack() as buffers:
            read = buffers.enter_context(self._read(places))
            arrays = [*map(self._exchanged, changed), *map(self._written, outputs)]
            written = [buffers.enter_context(array) for array in arrays]
            self._launch_map(
                kernel,
                deformation,
                region,
                None,
                count,
                np.int64(count),
                read,
                *arguments,
                *written,
            )

    # Launching

    def _at_points(self, name, deformation, points, planes, progress):
        """Rows of `points`, the handle set there, and the kernel's planes (planes, m)."""
        slabs = self._slabs(len(points), deformation, 4 * (3 + planes))
        for part in _stepped(slabs, progress):
            for region in deformation.regions:
                where = _held(deformation, region, points, part)
                local = self.local_points(region.control_points, points[where])
                if local.shape[1] == 0:
                    continue
                result = np.empty((planes, local.shape[1]), np.float32)
                self.run_at(name, deformation, region, local, outputs=[result])
                yield where, region.control_points, result

    def _slabs(self, count, deformation, bytes_per_item, most=None):
        """Slices of `count` items that fit the memory and take a moment each."""
        cost = max(
            len(c) * (1 + c.kind.functions(c))
            for c in (region.control_points for region in deformation.regions)
        )
        limit = min(
            _WORK_PER_LAUNCH / cost,
            self.memory / 4 / bytes_per_item,
            self.device.handle.max_mem_alloc_size / bytes_per_item,
            most or count,
        )
        step = max(1024, int(limit) // 1024 * 1024)
        return [slice(start, min(count, start + step)) for start in range(0, count, step)]

    def _launch_grid(self, name, deformation, region, grid, part, *arguments):
        lattice = kernel_arguments.lattice(grid, part, region.control_points)
        count = part.stop - part.start
        self._launch_map(name, deformation, region, grid.whole, count, *lattice, *arguments)

    def _launch_source_index(self, deformation, source, target, part, continued, index):
        """Where in `source.whole` the points `part` of `target` come from: three planes."""
        for region in deformation.regions:
            self._launch_grid(
                "grid_source_index",
                deformation,
                region,
                target,
                part,
                *kernel_arguments.to_source(source, target, region.control_points, continued),
                index,
            )

    def _launch_map(self, name, deformation, region, grid, count, *arguments):
        constants, shared = self._map(deformation, region, grid)
        self._launch(name, constants, count, *shared, *arguments)

    def _launch(self, name, constants, count, *arguments):
        """Launch a kernel for `count` points."""
        kernel = self._kernels.get((name, constants))
        if kernel is None:
            kernel = self._kernels[name, constants] = devices.kernel(self.device, name, constants)
        items = -(-count // dict(constants)["LANES"])
        local = 64 if self.device.kind == "gpu" else 16
        kernel(self.queue, (-(-items // local) * local,), (local,), *arguments)

    def _map(self, deformation, region, grid):
        """Build constants and shared kernel arguments of the map in a region."""
        if grid is not None:
            return self._described(deformation, region, grid)
        if region not in self._at_any_points:  # a region belongs to one deformation
            self._at_any_points[region] = self._described(deformation, region, grid)
        return self._at_any_points[region]

    def _described(self, deformation, region, grid):
        """The same, made anew: those of cuts depend on the grid."""
        control_points, alpha = region.control_points, deformation.alpha
        kind = control_points.kind
        numbers = kernel_arguments.record(
            {
                "count": np.int32(len(control_points)),
                "alpha": np.float32(alpha),
                **kind.numbers(control_points),
            }
        )
        constants = [
            ("TWICE_ALPHA", int(2 * alpha) if 2 * alpha in (1, 2, 3, 4, 6) else 0),
            ("FIT", kind.kernel),
            ("CONTROL_POINT", kernel_arguments.members(kernel_arguments.CONTROL_POINT)),
            ("MAP_NUMBERS", kernel_arguments.members(numbers.dtype)),
            *self._sums(self.device.has_float64 and kind.needs_float64(alpha)),
            *kind.constants().items(),
        ]
        if control_points not in self._uploaded:
            tables = kernel_arguments.control_points(control_points), kind.table(control_points)
            self._uploaded[control_points] = [
                self.constant(kernel_arguments.not_empty(table)) for table in tables
            ]
        arguments = [numbers, *self._uploaded[control_points]]
        if deformation.cuts:
            extra, numbers, tables = cut_tables(deformation, region, grid)
            constants += extra
            arguments += [numbers, *map(self.constant, tables)]
        return tuple(constants), arguments

    def _sums(self, double):
        """Build constants of kernels that sum in double or in float."""
        if double:
            return [("LANES", self.device.double_lanes), ("SUM", "double"), ("USE_FP64", 1)]
        return [("LANES", self.device.lanes), ("SUM", "float")]

    def _can_sample(self, dtype):
        return dtype.name in _C_TYPES and (
            dtype.name in _SUMMED_IN_FLOAT or self.device.has_float64
        )

    def _sample(self, part, array, source, method, background, result):
        """Launch the resample kernel for one array and one part of a slab."""
        index, first, stop, values, there = part
        count = stop - first
        in_float = array.dtype.name in _SUMMED_IN_FLOAT
        value = _C_TYPES[array.dtype.name]
        cast = f"convert_{value}_sat_rte" if array.dtype.kind in "iu" else f"convert_{value}"
        constants = (
            *self._sums(double=not in_float),
            *(("VALUE", value), ("CAST", cast), ("TAPS", _TAPS[method])),
            ("OFFSET", "int" if array.size < 2**31 else "long"),
        )
        components = int(np.prod(array.shape[3:]))
        fill = sampling.cast(np.float64(background), array.dtype)
        with self._written(result[first:stop]) as out:
            self._launch(
                "resample",
                constants,
                count,
                np.int64(count),
                index,
                *(
                    kernel_arguments.int4(n)
                    for n in (source.whole.dimensions, there.first, there.dimensions)
                ),
                np.int32(components),
                array.dtype.type(fill),
                values,
                out,
            )

    # Memory: a CPU device works in place on the host's arrays

    def _scratch(self, size):
        """A buffer of at least `size` bytes, kept for the next call."""
        if self._kept is None or self._kept.size < size:
            self._kept = cl.Buffer(self.context, cl.mem_flags.READ_WRITE, size)
        return self._kept

    def constant(self, array):
        """`array` on the device, to read as long as the buffer is kept."""
        flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
        return cl.Buffer(self.context, flags, hostbuf=array)

    def _read(self, array):
        """A context manager: `array` on the device, to read."""
        return _Shared(self, array, cl.mem_flags.READ_ONLY, there=True, back=False)

    def _written(self, array):
        """A context manager: `array` on the device, to write; back on the host at the end."""
        return _Shared(self, array, cl.mem_flags.WRITE_ONLY, there=False, back=True)

    def _exchanged(self, array):
        """A context manager: `array` on the device, to change; back on the host at the end."""
        return _Shared(self, array, cl.mem_flags.READ_WRITE, there=True, back=True)


def _stepped(slabs, progress):
    """`slabs`, one after the other, with the progress after each."""
    for part in slabs:
        yield part
        if progress is not None:
            progress(part.stop / slabs[-1].stop)


def _held(deformation, region, points, part):
    """Rows of `points[part]` that are in `region`: a slice where that is all or nothing."""
    if not deformation.planes:
        return part
    here = region.holds(deformation.planes, points[part])
    if here.all():
        return part
    return part.start + np.flatnonzero(here) if here.any() else slice(0, 0)


class _Shared:
    """A host array as a device buffer, for as long as the context lasts."""

    def __init__(self, engine, array, access, there, back):
        self.engine, self.array, self.back = engine, array, back
        flags = cl.mem_flags
        if engine._in_place:
            access |= flags.USE_HOST_PTR
        elif there:
            access |= flags.COPY_HOST_PTR
        host = {"hostbuf": array} if there or engine._in_place else {"size": array.nbytes}
        self.buffer = cl.Buffer(engine.context, access, **host)

    def __enter__(self):
        return self.buffer

    def __exit__(self, *_):
        queue = self.engine.queue
        if self.back and not self.engine._in_place:
            cl.enqueue_copy(queue, self.array, self.buffer)
        elif self.back:
            mapped, _ = cl.enqueue_map_buffer(
                queue,
                self.buffer,
                cl.map_flags.READ,
                0,
                self.array.shape,
                self.array.dtype,
            )
            mapped.base.release(queue)
        queue.finish()
        self.buffer.release()


class _Sources:
    """The arrays to resample on the device: whole, or the slices that a slab needs."""

    def __init__(self, engine, arrays, grid):
        self.engine, self.arrays, self.grid = engine, arrays, grid
        self.whole = {}

    def fitting(self, number, index, count):
        """Parts (index buffer, first, stop, values, their grid) that together make the slab."""
        array = self.arrays[number]
        engine = self.engine
        if engine._in_place or self._fits(sum(a.nbytes for a in self.arrays)):
            if number not in self.whole:
                self.whole[number] = engine._read(array)
            yield index, 0, count, self.whole[number].buffer, self.grid
            return
        planes = np.empty((3, count), np.float32)
        cl.enqueue_copy(engine.queue, planes, index)
        parts = [(0, count)]
        while parts:
            first, stop = parts.pop()
            low, high = _slices_needed(planes[2, first:stop], self.grid)
            slices = array[low:high]
            if not self._fits(slices.nbytes):
                if stop - first == 1:
                    raise devices.DeviceError(
                        f"a few slices of the image ({slices.nbytes} bytes) do not fit the memory "
                        f"of {engine.NAME}; use another `device`"
                    )
                middle = (first + stop) // 2
                parts += [(middle, stop), (first, middle)]
                continue
            own = np.ascontiguousarray(planes[:, first:stop])
            with engine._read(own) as moved, engine._read(slices) as values:
                nx, ny, _ = self.grid.dimensions
                there = self.grid.part((0, 0, low), (nx, ny, high - low))
                yield moved, first, stop, values, there

    def _fits(self, size):
        limit = self.engine.device.handle.max_mem_alloc_size
        return size <= self.engine.memory / 2 and size <= limit


def _slices_needed(z, grid):
    """First and past-the-last slice that interpolation at the indices `z` can touch."""
    z = z[(z >= -0.5) & (z <= grid.whole.dimensions[2] - 0.5)] - grid.first[2]
    if len(z) == 0:
        return 0, 1
    count = grid.dimensions[2]
    low, high = np.clip((int(z.min()) - 1, int(z.max()) + 2), 0, count - 1)
    return int(low), int(high) + 1
