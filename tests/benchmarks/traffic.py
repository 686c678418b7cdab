"""How many bytes an update moves for a voxel, counted where buffers of host arrays are made.

An array that kernels read or write passes once over the memory; what one kernel leaves for the next
passes twice, in slabs that fit the caches of a CPU.
"""

from __future__ import annotations

from collections import Counter
from contextlib import contextmanager

import contestants

from vtk_mls.engine.launch.memory import Memory

_READ, _WRITTEN, _KEPT = "read", "written", "for kernels only"
# What each method of `Memory` that takes an array, or a use and a size, lets pass.
_METHODS = {
    "input_buffer": (_READ,),
    "output_buffer": (_WRITTEN,),
    "inout_buffer": (_READ, _WRITTEN),
    "constant": (_KEPT,),
    "scratch": (_KEPT,),
}


@contextmanager
def counted():
    """Bytes of buffers that are made meanwhile, by what they are for."""
    sizes, usual = Counter(), {name: getattr(Memory, name) for name in _METHODS}

    def counting(name):
        def method(self, *arguments):
            size = arguments[1] if name == "scratch" else arguments[0].nbytes
            sizes.update(dict.fromkeys(_METHODS[name], size))
            return usual[name](self, *arguments)

        return method

    for name in _METHODS:
        setattr(Memory, name, counting(name))
    try:
        yield sizes
    finally:
        for name, method in usual.items():
            setattr(Memory, name, method)


def table(n):
    """Updates of `MLSDeform` from image to image, as rows of a table of the benchmark."""
    rows = {}
    for name, update in contestants.updates(n):
        update()
        with counted() as sizes:
            update()
        rows[name] = {what: sizes[what] / n**3 for what in (_READ, _WRITTEN, _KEPT)}
    return rows
