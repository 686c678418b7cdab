"""Memory of results that nobody has any more, for the next ones.

A drag makes arrays of the same sizes again and again. For new ones the system clears all of their
memory first, which takes as long as filling them.
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import DTypeLike, NDArray

# Bytes of an array that is worth it, and of all that are kept.
_LEAST, _MOST = 1 << 20, 1 << 28
# So many arrays are made of other memory before what is kept is let go: those of a few updates.
_PATIENCE = 32

_kept: list[_Memory] = []
_lock = threading.Lock()


class _Memory:
    """Bytes that nobody has."""

    def __init__(self, array: NDArray[np.uint8]) -> None:
        self.array, self.patience = array, _PATIENCE


class _Owner:
    """Has the memory of an array, and keeps it for the next when that and its views are gone."""

    def __init__(self, memory: NDArray[np.uint8]) -> None:
        self._memory = memory
        self.__array_interface__ = memory.__array_interface__

    def __del__(self) -> None:
        # at any time, in any thread: what is busy is not waited for
        if self._memory.nbytes <= _MOST and _lock.acquire(blocking=False):
            try:
                _kept.append(_Memory(self._memory))
                while sum(memory.array.nbytes for memory in _kept) > _MOST:
                    del _kept[0]
            finally:
                _lock.release()


def empty(shape: int | tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
    """An array with any values, as `numpy.empty` makes it, of kept memory if there is some."""
    dtype = np.dtype(dtype)
    size = int(np.prod(shape, dtype=np.int64)) * dtype.itemsize
    if size < _LEAST:
        return np.empty(shape, dtype)
    memory = _taken(size)
    if memory is None:
        memory = np.empty(size, np.uint8)
    return np.asarray(_Owner(memory)).view(dtype).reshape(shape)


def _taken(size: int) -> NDArray[np.uint8] | None:
    """Kept memory of `size` bytes; None if there is none."""
    with _lock:
        # the last that was kept may still be in the processor's cache
        found = next((memory for memory in reversed(_kept) if memory.array.nbytes == size), None)
        for memory in _kept:
            memory.patience -= 1
        _kept[:] = [each for each in _kept if each is not found and each.patience > 0]
    return found and found.array
