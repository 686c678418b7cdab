"""The structs and constants of opencl/base/structs.h, which describes them."""

from __future__ import annotations

import re

import numpy as np

from vtk_mls.base.resources import resource

_TYPES = {"int": "i4", "long": "i8", "float": "f4", "float4": "(4,)f4"}


def _dtype(members):
    """The dtype of the members of a C struct."""
    fields = []
    for type_name, declared in re.findall(r"(\w+) ([^;]+);", members):
        for name, size in re.findall(r"(\w+)(?:\[(\d+)\])?", declared):
            fields.append((name, _TYPES[type_name], (int(size),) if size else ()))
    return np.dtype(fields, align=True)


_TEXT = re.sub("//.*", "", (resource("opencl") / "base" / "structs.h").read_text())
CONSTANTS = {name: int(value) for name, value in re.findall(r"(\w+) = (\d+)", _TEXT)}
STRUCTS = {
    name: _dtype(members)
    for members, name in re.findall(r"typedef struct \{(.*?)\} (\w+);", _TEXT, re.DOTALL)
}


def filled(name, **values):
    """A structured array of one element: a struct that a kernel takes by value."""
    result = np.zeros((), STRUCTS[name])
    for member, value in values.items():
        result[member] = value
    return result
