"""Reuse of the memory of large results.

A drag makes arrays of the same sizes again and again. The system clears new memory first, which
takes as long as filling it.
"""

import threading

import numpy as np

MIN_BYTES = 1 << 18  # smaller arrays are not pooled
# Bytes of two cache lines. Kernels write a line as a whole, and Intel's OpenCL copies arrays of
# buffers that begin elsewhere.
ALIGNMENT = 128
MAX_IDLE_BYTES = 1 << 29  # of all idle buffers together
MAX_IDLE_CALLS = 32  # calls of `empty` after which an idle buffer is freed

# Idle buffers, the oldest first, each with the number of calls when it became idle.
_idle = []
_calls = 0
_lock = threading.Lock()


class _Owner:
    """The base of an array; returns its buffer to the pool when the array and its views are gone.

    numpy lets a view refer to this object, while it would skip arrays in between.
    """

    def __init__(self, buffer):
        self._buffer = buffer
        self.__array_interface__ = buffer.__array_interface__

    def __del__(self):
        # Runs at any time in any thread, also while this thread holds the lock: never waits.
        if self._buffer.nbytes <= MAX_IDLE_BYTES and _lock.acquire(blocking=False):
            try:
                _idle.append((self._buffer, _calls))
                while sum(buffer.nbytes for buffer, _ in _idle) > MAX_IDLE_BYTES:
                    del _idle[0]
            finally:
                _lock.release()


def empty(shape, dtype):
    """An uninitialized array, as `numpy.empty` returns it, in an idle buffer if one fits."""
    dtype = np.dtype(dtype)
    size = int(np.prod(shape, dtype=np.int64)) * dtype.itemsize
    if size < MIN_BYTES:
        return np.empty(shape, dtype)
    buffer = _take(size)
    if buffer is None:
        memory = np.empty(size + ALIGNMENT, np.uint8)
        start = -memory.ctypes.data % ALIGNMENT
        buffer = memory[start : start + size]
    return np.asarray(_Owner(buffer)).view(dtype).reshape(shape)


def _take(size):
    """The last idle buffer of `size` bytes, which may still be in the cache; None without one."""
    global _calls
    with _lock:
        _calls += 1
        fitting = [i for i, (buffer, _) in enumerate(_idle) if buffer.nbytes == size]
        buffer = _idle.pop(fitting[-1])[0] if fitting else None
        _idle[:] = [entry for entry in _idle if _calls - entry[1] < MAX_IDLE_CALLS]
        return buffer
