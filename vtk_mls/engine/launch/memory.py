"""Memory of an OpenCL device: buffers of host arrays, and limits of their size."""

import ctypes
from collections import OrderedDict

import numpy as np
import pyopencl as cl

from vtk_mls.base import buffer_pool
from vtk_mls.engine.device import devices

MIN_LIMIT = 1 << 20  # bytes of device memory below which work is not retried


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

    def planes(self, buffer, count, planes=3):
        """A host copy (planes, count) of the first `planes * count` floats of a buffer."""
        planes = np.empty((planes, count), np.float32)
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

    def _buffer(self, array, access, copy_in, copy_out):
        if self.in_place and self._has_host_addresses:
            return _Address(self, array)
        return _Buffer(self, array, access, copy_in, copy_out)


class _Address:
    """A host array as a kernel argument, where the device accepts any address of the host."""

    def __init__(self, memory, array):
        self.memory, self.array = memory, array
        assert array.flags.c_contiguous
        # pyopencl requires a writable buffer, also for input
        address = (ctypes.c_char * array.nbytes).from_address(array.ctypes.data)
        self.argument = cl.SVM(address)

    def __enter__(self):
        return self.argument

    def __exit__(self, *_):
        self.memory.queue.finish()


class _Buffer:
    """A host array as a device buffer, for as long as the context lasts."""

    def __init__(self, memory, array, access, copy_in, copy_out):
        self.memory, self.array, self.copy_out = memory, array, copy_out
        flags = cl.mem_flags
        if memory.in_place:
            access |= flags.USE_HOST_PTR
        elif copy_in:
            access |= flags.COPY_HOST_PTR
        host = {"hostbuf": array} if copy_in or memory.in_place else {"size": array.nbytes}
        self.argument = cl.Buffer(memory.context, access, **host)

    def __enter__(self):
        return self.argument

    def __exit__(self, *_):
        queue = self.memory.queue
        if self.copy_out and not self.memory.in_place:
            cl.enqueue_copy(queue, self.array, self.argument)
        elif self.copy_out:
            values = 0, self.array.shape, self.array.dtype
            mapped, _ = cl.enqueue_map_buffer(queue, self.argument, cl.map_flags.READ, *values)
            mapped.base.release(queue)
        queue.finish()
        self.argument.release()


def _has_host_addresses(device):
    """Whether kernels of an OpenCL device accept addresses of the host."""
    try:
        capabilities = device.svm_capabilities
    except cl.Error:  # before OpenCL 2
        return False
    return bool(capabilities & cl.device_svm_capabilities.FINE_GRAIN_SYSTEM)
