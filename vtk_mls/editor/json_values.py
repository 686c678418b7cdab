"""Cuts, handles and masks as values of JSON, for autosave files."""

from __future__ import annotations

import base64
import functools
import zlib

import numpy as np

from vtk_mls import (
    Ball,
    BallMask,
    Capsule,
    CurveHandle,
    Grid,
    HalfPlane,
    Labels,
    Plane,
    RegionHandle,
    Solid,
    Surface,
)

# Class and arguments of each value that is made of numbers.
_CLASSES = {
    "plane": (Plane, ("point", "normal")),
    "half-plane": (HalfPlane, ("point", "normal", "inward")),
    "surface": (Surface, ("points", "triangles")),
    "ball": (Ball, ("center", "radius")),
    "capsule": (Capsule, ("a", "b", "radius")),
    "solid": (Solid, ("points", "triangles")),
    "curve": (CurveHandle, ("rest", "deformed")),
    "ball-mask": (BallMask, ("center", "radius", "falloff")),
}


def encoded(value):
    """The name of the class of a value, and its arguments.

    Raises
    ------
    TypeError
        If the class has no format.
    """
    if isinstance(value, RegionHandle):
        return ["region", [_encoded_shape(value.shape), value.motion.tolist()]]
    for name, (kind, attributes) in _CLASSES.items():
        if type(value) is kind:
            numbers = (np.asarray(getattr(value, attribute)).tolist() for attribute in attributes)
            return [name, [*numbers]]
    raise TypeError(f"a {type(value).__name__} has no format in an autosave file")


def decoded(value):
    """The value of `encoded`."""
    name, arguments = value
    if name == "region":
        return RegionHandle(decoded(arguments[0]), arguments[1])
    if name == "labels":
        return _labels(*arguments)
    return _CLASSES[name][0](*arguments)


@functools.lru_cache(maxsize=64)  # a shape is the same at each edit
def _encoded_shape(shape):
    if not isinstance(shape, Labels):
        return encoded(shape)
    grid = shape.grid
    bits = base64.b64encode(zlib.compress(np.packbits(shape.mask).tobytes())).decode("ascii")
    numbers = [
        np.asarray(getattr(grid, name)).tolist()
        for name in ("dimensions", "origin", "spacing", "direction")
    ]
    return ["labels", [bits, *numbers]]


def _labels(bits, *numbers):
    grid = Grid(*numbers)
    try:
        packed = np.frombuffer(zlib.decompress(base64.b64decode(bits)), np.uint8)
    except zlib.error as error:
        raise ValueError(f"the mask of a segmentation is broken: {error}") from error
    return Labels(np.unpackbits(packed, count=grid.size).reshape(grid.shape), grid)
