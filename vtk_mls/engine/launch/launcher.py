"""Kernels of an OpenCL device: built at their first use, launched in slabs; and its memory."""

import ctypes
import weakref
from collections import OrderedDict
from contextlib import contextmanager

import numpy as np
import pyopencl as cl

from vtk_mls.base import buffer_pool
from vtk_mls.engine.device import devices

MIN_LIMIT = 1 << 20  # bytes of device memory below which work is not retried
# Control points times functions times points of one launch: some tenths of a second on two CPU
# cores, so that progress is reported and an abort takes effect.
_MAX_WORK = 3e8
_POINTS_OF_SEGMENT = 4  # control points that take as long as a segment


class Launcher:
    """Launches kernels on one device.

    `tables` has buffers with the tables of a map by ControlPoints, and `lattices` lattices of the
    inverse by Region, for as long as deformations exist.
    """

    def __init__(self, device):
        self.device, self.memory = device, Memory(device)
        self.tables, self.lattices = weakref.WeakKeyDictionary(), weakref.WeakKeyDictionary()

    def slabs(self, count, deformation, bytes_per_item, max_count=None):
        """Slices of `count` items, each within the limits of memory and of work."""
        cost = max(
            (len(c) + _POINTS_OF_SEGMENT * len(c.handles.segments)) * (1 + c.kind.functions(c))
            for c in (region.control_points for region in deformation.regions)
        )
        cost *= deformation.steps_used
        if deformation.map_tolerance > 0:
            cost /= 4  # most points are interpolated, as a rule
        limit = min(
            _MAX_WORK / cost,
            self.memory.limit / 4 / bytes_per_item,
            self.device.handle.max_mem_alloc_size / bytes_per_item,
            max_count or count,
        )
        step = max(1024, count if limit >= count else int(limit) // 1024 * 1024)
        return [slice(start, min(count, start + step)) for start in range(0, count, step)]

    def launch(self, name, constants, count, *arguments):
        """Launch a kernel for `count` points."""
        kernel = devices.kernel(self.device, name, constants)
        items = -(-count // dict(constants)["LANES"])
        local = 64 if self.device.kind == "gpu" else 16
        kernel(self.memory.queue, (-(-items // local) * local,), (local,), *arguments)


class Memory:
    """Makes buffers of host arrays. A CPU device uses host arrays without copies: `in_place`.

    `limit` is the number of bytes of device memory to use, divided among MPI processes that share
    the device. Larger grids are processed in slabs.
    """

    def __init__(self, device):
        self.device = device
        self.context, self.queue = devices.context(device), devices.queue(device)
        self.in_place = device.kind == "cpu"
        # Intel's runtime copies the host array of a buffer unless its address is a multiple of 128
        # bytes, as few are: it takes the address itself.
        self._has_host_addresses = _has_host_addresses(device.handle)
        self.limit = device.handle.global_mem_size // 2 // devices.sharers(device)
        self._scratch = {}  # buffers by use
        self._resident = OrderedDict()  # buffers by version of the array, the last used at the end

    def shrink(self):
        """Quarter the limit and free cached buffers; False if the limit is too small for that."""
        if self.limit < MIN_LIMIT:
            return False
        self._scratch.clear()
        self._resident.clear()
        self.limit //= 4
        return True

    def fits(self, size):
        """Whether an array of `size` bytes fits the device together with its results."""
        return size <= self.limit / 2 and size <= self.device.handle.max_mem_alloc_size

    def scratch(self, use, size):
        """A buffer of at least `size` bytes, cached for the next call with the same `use`."""
        buffer = self._scratch.get(use)
        if buffer is None or buffer.size < size:
            del buffer
            self._scratch.pop(use, None)  # freed before the larger one is allocated
            buffer = cl.Buffer(self.context, cl.mem_flags.READ_WRITE, size)
            self._scratch[use] = buffer
        return buffer

    def pooled(self, size):
        """A buffer of `size` bytes, on a CPU in memory that earlier ones have left.

        Its memory is that of another buffer as soon as it is freed, so kernels must have ended
        by then.
        """
        access = cl.mem_flags.READ_WRITE
        if not self.in_place:
            return cl.Buffer(self.context, access, size)
        array = buffer_pool.empty(size, np.uint8)
        return cl.Buffer(self.context, access | cl.mem_flags.USE_HOST_PTR, hostbuf=array)

    def constant(self, array):
        """A read-only copy of `array` on the device."""
        flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
        return cl.Buffer(self.context, flags, hostbuf=array)

    def resident(self, array, version):
        """A copy of `array` on the device, cached for the next call with an equal `version`.

        Buffers that were not used for longest are freed to make room.
        """
        key = version, array.dtype, array.shape
        buffer = self._resident.pop(key, None)
        if buffer is None:
            others = self._resident.values()
            while others and array.nbytes + sum(other.size for other in others) > self.limit / 2:
                self._resident.popitem(last=False)
            buffer = self.constant(array)
        self._resident[key] = buffer
        return buffer

    def planes(self, buffer, count):
        """A host copy (3, count) of the first floats of a buffer."""
        planes = np.empty((3, count), np.float32)
        cl.enqueue_copy(self.queue, planes, buffer)
        return planes

    def input_buffer(self, array):
        """A context manager: a buffer of `array` that kernels read."""
        return self._buffer(array, cl.mem_flags.READ_ONLY, copy_in=True, copy_out=False)

    def output_buffer(self, array):
        """A context manager: a buffer that kernels write, copied to `array` at the end."""
        return self._buffer(array, cl.mem_flags.WRITE_ONLY, copy_in=False, copy_out=True)

    def inout_buffer(self, array):
        """A context manager: a buffer of `array` that kernels change, copied back at the end."""
        return self._buffer(array, cl.mem_flags.READ_WRITE, copy_in=True, copy_out=True)

    def argument(self, array, access=cl.mem_flags.READ_ONLY, copy_in=True):
        """An array as an argument of kernels that read it, for as long as both exist."""
        if self.in_place and self._has_host_addresses:
            assert array.flags.c_contiguous
            # pyopencl requires a writable buffer, also for input
            return cl.SVM((ctypes.c_char * array.nbytes).from_address(array.ctypes.data))
        if self.in_place:
            access |= cl.mem_flags.USE_HOST_PTR
        elif copy_in:
            access |= cl.mem_flags.COPY_HOST_PTR
        host = {"hostbuf": array} if copy_in or self.in_place else {"size": array.nbytes}
        return cl.Buffer(self.context, access, **host)

    @contextmanager
    def _buffer(self, array, access, copy_in, copy_out):
        argument = self.argument(array, access, copy_in)
        is_buffer = not isinstance(argument, cl.SVM)
        try:
            yield argument
        finally:
            if copy_out and is_buffer and self.in_place:
                values = 0, array.shape, array.dtype
                mapped, _ = cl.enqueue_map_buffer(self.queue, argument, cl.map_flags.READ, *values)
                mapped.base.release(self.queue)
            elif copy_out and is_buffer:
                cl.enqueue_copy(self.queue, array, argument)
            self.queue.finish()
            if is_buffer:
                argument.release()


def _has_host_addresses(device):
    """Whether kernels of an OpenCL device accept addresses of the host."""
    try:
        capabilities = device.svm_capabilities
    except cl.Error:  # before OpenCL 2
        return False
    return bool(capabilities & cl.device_svm_capabilities.FINE_GRAIN_SYSTEM)
