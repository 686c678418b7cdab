"""Memory of an OpenCL device: host arrays as buffers, and what fits."""

from __future__ import annotations

import ctypes
from collections import OrderedDict

import numpy as np
import pyopencl as cl

from vtk_mls.engine.device import devices

# Bytes of device memory with which it is no use to begin again.
_LEAST = 1 << 20


class Memory:
    """Makes buffers of host arrays. A CPU device works in place on these, without copies.

    Attributes
    ----------
    limit : int
        Bytes of device memory to use, a share if MPI processes use it too; larger grids go through
        in slabs.
    in_place : bool
        Whether the device works on the host's arrays.
    """

    def __init__(self, device):
        self.device = device
        self.context, self.queue = devices.context(device), devices.queue(device)
        self.in_place = device.kind == "cpu"
        # Intel's runtime copies what a buffer is made of if it does not begin at a multiple of 128
        # bytes, as few arrays do
        self._takes_addresses = _takes_addresses(device.handle)
        self.limit = device.handle.global_mem_size // 2 // devices.sharers(device)
        self._kept = {}
        self._resident = OrderedDict()  # arrays by their version, the last used at the end

    def shrink(self):
        """Use a quarter of the memory from now on; whether that is of any use."""
        if self.limit < _LEAST:
            return False
        self._kept.clear()
        self._resident.clear()
        self.limit //= 4
        return True

    def fits(self, size):
        """Whether an array of `size` bytes can be on the device beside what is made of it."""
        return size <= self.limit / 2 and size <= self.device.handle.max_mem_alloc_size

    def scratch(self, use, size):
        """A buffer of at least `size` bytes, kept for the next call with the same `use`."""
        kept = self._kept.get(use)
        if kept is None or kept.size < size:
            self._kept.pop(use, None)  # before there are two
            kept = self._kept[use] = cl.Buffer(self.context, cl.mem_flags.READ_WRITE, size)
        return kept

    def constant(self, array):
        """`array` on the device, to read as long as the buffer is kept."""
        flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
        return cl.Buffer(self.context, flags, hostbuf=array)

    def resident(self, array, version):
        """`array` on the device, kept for the next call with an equal version of it.

        So are others, of which those that were not used for longest make room.
        """
        key = version, array.dtype, array.shape
        kept = self._resident.pop(key, None)
        if kept is None:
            others = self._resident.values
            while others() and array.nbytes + sum(each.size for each in others()) > self.limit / 2:
                self._resident.popitem(last=False)
            kept = self.constant(array)
        self._resident[key] = kept
        return kept

    def planes(self, buffer, count, planes=3):
        """The first `planes * count` floats of a buffer on the host, (planes, count)."""
        planes = np.empty((planes, count), np.float32)
        cl.enqueue_copy(self.queue, planes, buffer)
        return planes

    def read(self, array):
        """A context manager: `array` on the device, to read."""
        return self._shared(array, cl.mem_flags.READ_ONLY, there=True, back=False)

    def written(self, array):
        """A context manager: `array` on the device, to write; back on the host at the end."""
        return self._shared(array, cl.mem_flags.WRITE_ONLY, there=False, back=True)

    def exchanged(self, array):
        """A context manager: `array` on the device, to change; back on the host at the end."""
        return self._shared(array, cl.mem_flags.READ_WRITE, there=True, back=True)

    def _shared(self, array, access, there, back):
        if self.in_place and self._takes_addresses:
            return _Address(self, array)
        return _Buffer(self, array, access, there, back)


class _Address:
    """A host array as a kernel's argument, where the device takes any address of the host."""

    def __init__(self, memory, array):
        self.memory, self.array = memory, array
        assert array.flags.c_contiguous
        # of bytes that may be written, which pyopencl wants also of those that are only read
        place = (ctypes.c_char * array.nbytes).from_address(array.ctypes.data)
        self.argument = cl.SVM(place)

    def __enter__(self):
        return self.argument

    def __exit__(self, *_):
        self.memory.queue.finish()


class _Buffer:
    """A host array as a device buffer, for as long as the context lasts."""

    def __init__(self, memory, array, access, there, back):
        self.memory, self.array, self.back = memory, array, back
        flags = cl.mem_flags
        if memory.in_place:
            access |= flags.USE_HOST_PTR
        elif there:
            access |= flags.COPY_HOST_PTR
        host = {"hostbuf": array} if there or memory.in_place else {"size": array.nbytes}
        self.argument = cl.Buffer(memory.context, access, **host)

    def __enter__(self):
        return self.argument

    def __exit__(self, *_):
        queue = self.memory.queue
        if self.back and not self.memory.in_place:
            cl.enqueue_copy(queue, self.array, self.argument)
        elif self.back:
            mapped, _ = cl.enqueue_map_buffer(
                queue,
                self.argument,
                cl.map_flags.READ,
                0,
                self.array.shape,
                self.array.dtype,
            )
            mapped.base.release(queue)
        queue.finish()
        self.argument.release()


def _takes_addresses(device):
    """Whether kernels of an OpenCL device take addresses of the host."""
    try:
        can = device.svm_capabilities
    except cl.Error:  # before OpenCL 2
        return False
    return bool(can & cl.device_svm_capabilities.FINE_GRAIN_SYSTEM)
