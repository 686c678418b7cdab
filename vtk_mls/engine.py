"""The map on an OpenCL device: the questions of `reference`, answered by the kernels in opencl/."""

from __future__ import annotations

import functools
import threading
import weakref

import numpy as np
import pyopencl as cl

from vtk_mls import device as devices
from vtk_mls import interpolation
from vtk_mls.handles import MONOMIAL_COUNT, ROTATION_KINDS

# Control points times functions times points of one launch: some tenths of a second on two CPU
# cores, so that progress shows and abort is heard.
_WORK_PER_LAUNCH = 3e8
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


class Engine:
    """Launches the kernels on one device.

    Attributes
    ----------
    NAME : str
        The device, for people.
    memory : int
        Bytes of device memory to use; larger grids go through in slabs.
    """

    def __init__(self, device):
        self.NAME = str(device)
        self.device = device
        self.queue = devices.queue(device)
        self._in_place = device.kind == "cpu"  # works on the host's arrays, without copies
        self.memory = device.handle.global_mem_size // 2
        self._kernels = {}
        self._uploaded = weakref.WeakKeyDictionary()  # handle set -> buffers
        self._kept = None
        self._lock = threading.RLock()  # a kernel's arguments belong to one launch at a time

    # The questions

    def backward(self, deformation, points, progress=None):
        """G(v) (m, 3) float64 at `points` v (m, 3) float64, world coordinates."""
        handles = deformation.handles
        result = np.empty_like(points)
        for part, planes in self._at_points("point_displacement", deformation, points, 3, progress):
            result[part] = points[part] + handles.drift + handles.scale * planes.T
        return result

    def jacobian(self, deformation, points, progress=None):
        """dG_i/dv_j (m, 3, 3) float64 at `points` v (m, 3)."""
        result = np.empty((len(points), 3, 3))
        for part, planes in self._at_points("point_jacobian", deformation, points, 9, progress):
            result[part] = np.eye(3) + planes.T.reshape(-1, 3, 3)
        return result

    def displacement_field(self, deformation, grid, progress=None):
        """G(v) - v (nz, ny, nx, 3) float32 at the points v of `grid`, world units."""
        handles = deformation.handles
        result = np.empty((grid.size, 3), dtype=np.float32)
        with self._lock:
            for part in _stepped(self._slabs(grid.size, deformation, 12), progress):
                with self._written(result[part]) as out:
                    self._launch_map(
                        "grid_displacement",
                        deformation,
                        part.stop - part.start,
                        *_lattice(grid, part, handles),
                        np.float32(handles.scale),
                        _float4(handles.drift),
                        out,
                    )
        return result.reshape(*grid.shape, 3)

    def resample(self, deformation, arrays, source, target, methods, background, progress=None):
        """Each of `arrays` on the grid `source`, deformed, at the points of the grid `target`."""
        handles = deformation.handles
        matrix, offset = target.index_transform(source)
        turn = np.linalg.inv(source.index_to_world)
        to_source = _transform(matrix, offset + turn @ handles.drift)
        turn = _transform(turn * handles.scale, np.zeros(3))
        results = [np.empty(target.shape + a.shape[3:], a.dtype) for a in arrays]
        largest = max((a.itemsize * int(np.prod(a.shape[3:])) for a in arrays), default=0)
        with self._lock:
            sources = _Sources(self, arrays)
            slabs = self._slabs(
                target.size, deformation, 12 + largest, _CACHED if self._in_place else None
            )
            index = self._scratch(12 * (slabs[0].stop - slabs[0].start))
            for part in _stepped(slabs, progress):
                count = part.stop - part.start
                self._launch_map(
                    "grid_source_index",
                    deformation,
                    count,
                    *_lattice(target, part, handles),
                    to_source,
                    turn,
                    index,
                )
                for number, (array, method, result) in enumerate(zip(arrays, methods, results)):
                    rows = result.reshape(-1, *array.shape[3:])[part]
                    if not self._can_sample(array.dtype):
                        planes = np.empty((3, count), np.float32)
                        cl.enqueue_copy(self.queue, planes, index)
                        where = planes.T.astype(np.float64)
                        rows[:] = interpolation.sample(array, where, method, background)
                        continue
                    for rest in sources.fitting(number, index, count):
                        self._sample(rest, array, source, method, background, rows)
        return results

    # Launching

    def _at_points(self, name, deformation, points, planes, progress):
        """Slices of `points` with the kernel's planes (planes, m) there."""
        handles = deformation.handles
        with self._lock:
            slabs = self._slabs(len(points), deformation, 4 * (3 + planes))
            for part in _stepped(slabs, progress):
                local = np.ascontiguousarray(handles.local(points[part]).T, dtype=np.float32)
                count = local.shape[1]
                result = np.empty((planes, count), np.float32)
                with self._read(local) as v, self._written(result) as out:
                    self._launch_map(name, deformation, count, np.int64(count), v, out)
                yield part, result

    def _slabs(self, count, deformation, bytes_per_item, most=None):
        """Slices of `count` items that fit the memory and take a moment each."""
        handles = deformation.handles
        cost = len(handles) * (1 if deformation.kind in ROTATION_KINDS else len(handles.basis) + 1)
        limit = min(
            _WORK_PER_LAUNCH / cost,
            self.memory / 4 / bytes_per_item,
            self.device.handle.max_mem_alloc_size / bytes_per_item,
            most or count,
        )
        step = max(1024, int(limit) // 1024 * 1024)
        return [slice(start, min(count, start + step)) for start in range(0, count, step)]

    def _launch_map(self, name, deformation, count, *arguments):
        constants, shared = self._map(deformation)
        self._launch("map.cl", constants, name, -(-count // self.device.lanes), *shared, *arguments)

    def _launch(self, file, constants, name, items, *arguments):
        kernel = self._kernels.get((file, constants, name))
        if kernel is None:
            program = devices.program(self.device, file, constants)
            kernel = self._kernels[file, constants, name] = cl.Kernel(program, name)
        local = 64 if self.device.kind == "gpu" else 16
        kernel(self.queue, (-(-items // local) * local,), (local,), *arguments)

    def _map(self, deformation):
        """Build constants and shared kernel arguments of the map of `deformation`."""
        handles, alpha = deformation.handles, deformation.alpha
        rotation = deformation.kind in ROTATION_KINDS
        twice = int(2 * alpha) if 2 * alpha in (1, 2, 3, 4, 6) else 0
        constants = [("LANES", self.device.lanes), ("TWICE_ALPHA", twice)]
        if rotation:
            constants += [("ROTATION", 1), ("SIMILARITY", int(deformation.kind == "similarity"))]
        else:
            constants += [("FUNCTIONS", MONOMIAL_COUNT[handles.degree])]
        if handles not in self._uploaded:
            self._uploaded[handles] = [self._constant(table) for table in _tables(handles)]
        return tuple(constants), (
            np.int32(len(handles)),
            np.float32(alpha),
            np.int32(handles.rotation_rank),
            _float4(handles.flip_axis),
            *self._uploaded[handles],
        )

    def _can_sample(self, dtype):
        return dtype.name in _C_TYPES and (
            dtype.name in _SUMMED_IN_FLOAT or self.device.has_float64
        )

    def _sample(self, part, array, source, method, background, result):
        """Launch the resample kernel for one array and one part of a slab."""
        index, first, stop, values, slice_ = part
        count = stop - first
        in_float = array.dtype.name in _SUMMED_IN_FLOAT
        value, total = _C_TYPES[array.dtype.name], "float" if in_float else "double"
        cast = f"convert_{value}_sat_rte" if array.dtype.kind in "iu" else f"convert_{value}"
        constants = (
            *(("LANES", self.device.lanes), ("VALUE", value), ("SUM", total)),
            *(("CAST", cast), ("TAPS", _TAPS[method])),
            ("OFFSET", "int" if array.size < 2**31 else "long"),
        )
        if not in_float:
            constants += (("USE_FP64", 1),)
        components = int(np.prod(array.shape[3:]))
        fill = interpolation.cast(np.float64(background), array.dtype)
        with self._written(result[first:stop]) as out:
            self._launch(
                "resample.cl",
                constants,
                "resample",
                -(-count // self.device.lanes),
                np.int64(count),
                index,
                *(np.int32(n) for n in source.dimensions),
                np.int32(slice_),
                np.int32(components),
                array.dtype.type(fill),
                values,
                out,
            )

    # Memory: a CPU device works in place on the host's arrays

    def _scratch(self, size):
        """A buffer of at least `size` bytes, kept for the next call."""
        if self._kept is None or self._kept.size < size:
            self._kept = cl.Buffer(self.queue.context, cl.mem_flags.READ_WRITE, size)
        return self._kept

    def _constant(self, array):
        flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
        return cl.Buffer(self.queue.context, flags, hostbuf=array)

    def _read(self, array):
        """A context manager: `array` on the device, to read."""
        return _Shared(self, array, cl.mem_flags.READ_ONLY, back=False)

    def _written(self, array):
        """A context manager: `array` on the device, to write; back on the host at the end."""
        return _Shared(self, array, cl.mem_flags.WRITE_ONLY, back=True)


def _stepped(slabs, progress):
    """`slabs`, one after the other, with the progress after each."""
    for part in slabs:
        yield part
        if progress is not None:
            progress(part.stop / slabs[-1].stop)


class _Shared:
    """A host array as a device buffer, for as long as the context lasts."""

    def __init__(self, engine, array, access, back):
        self.engine, self.array, self.back = engine, array, back
        flags = cl.mem_flags
        if engine._in_place:
            access |= flags.USE_HOST_PTR
        elif not back:
            access |= flags.COPY_HOST_PTR
        host = {"size": array.nbytes} if back and not engine._in_place else {"hostbuf": array}
        self.buffer = cl.Buffer(engine.queue.context, access, **host)

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

    def __init__(self, engine, arrays):
        self.engine, self.arrays = engine, arrays
        self.whole = {}

    def fitting(self, number, index, count):
        """Parts (index buffer, first, stop, values, first slice) that together make the slab."""
        array = self.arrays[number]
        engine = self.engine
        if engine._in_place or self._fits(sum(a.nbytes for a in self.arrays)):
            if number not in self.whole:
                self.whole[number] = engine._read(array)
            yield index, 0, count, self.whole[number].buffer, 0
            return
        planes = np.empty((3, count), np.float32)
        cl.enqueue_copy(engine.queue, planes, index)
        parts = [(0, count)]
        while parts:
            first, stop = parts.pop()
            low, high = _slices_needed(planes[2, first:stop], len(array))
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
                yield moved, first, stop, values, low

    def _fits(self, size):
        limit = self.engine.device.handle.max_mem_alloc_size
        return size <= self.engine.memory / 2 and size <= limit


def _slices_needed(z, count):
    """First and past-the-last slice that interpolation at the indices `z` can touch."""
    z = z[(z >= -0.5) & (z <= count - 0.5)]
    if len(z) == 0:
        return 0, 1
    return max(0, int(z.min()) - 1), min(count, int(z.max()) + 3)


def _tables(handles):
    """What the kernels read of a handle set, float32: points, basis values, basis coefficients."""
    count, functions = len(handles), MONOMIAL_COUNT[handles.degree]
    points = np.zeros((count, 8), np.float32)
    points[:, 0:3] = handles.local(handles.deformed)
    points[:, 3] = handles.weights / handles.weights.mean()
    points[:, 4:7] = (handles.rest - handles.deformed - handles.drift) / handles.scale
    values = np.zeros((count, functions), np.float32)
    values[:, : len(handles.basis)] = handles.basis.values - handles.basis.values.mean(axis=0)
    coefficients = np.zeros((functions, functions), np.float32)
    coefficients[: len(handles.basis)] = handles.basis.coefficients
    return points, values, coefficients


def _lattice(grid, part, handles):
    """Kernel arguments of the points `part` of `grid`, with their way to the local frame."""
    frame = _transform(grid.index_to_world / handles.scale, handles.local(grid.origin))
    nx, ny, _ = grid.dimensions
    return np.int64(part.start), np.int64(part.stop), np.int32(nx), np.int32(ny), frame


def _transform(matrix, offset):
    """An affine transform as `transformed` in lattice.cl takes it."""
    packed = np.zeros(16, np.float32)
    packed[:12] = np.concatenate([np.asarray(matrix).T.ravel(), offset])
    return packed


def _float4(vector):
    packed = np.zeros(4, np.float32)
    packed[:3] = vector
    return packed
