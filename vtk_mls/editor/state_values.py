"""A `State` as values of JSON, for autosave and session files."""

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
from vtk_mls.editor.matching.pairs import Pending
from vtk_mls.editor.state import State
from vtk_mls.model import options

# Class and arguments of values that consist of arrays of numbers.
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
_ARRAYS = "rest", "deformed", "anchored", "enabled", "path"
_GRID = "dimensions", "origin", "spacing", "direction"  # arguments of a Grid


def encoded(state):
    """The values of a state; TypeError for a shape without a format."""
    pending = state.pending
    return {
        **options.values_of(state),
        **{name: getattr(state, name).tolist() for name in _ARRAYS},
        "weights": None if state.weights is None else state.weights.tolist(),
        "labels": list(state.labels),
        "pending": pending and [pending.side, pending.position.tolist(), pending.label],
        "cuts": [_encoded_value(cut) for cut in state.cuts],
        "handles": [_encoded_value(handle) for handle in state.handles],
        "mask": None if state.mask is None else _encoded_value(state.mask),
    }


def decoded(values):
    """The state of `encoded`; an error of any of the usual types if there is none."""
    if not isinstance(values, dict):
        raise TypeError("it is no object of JSON")
    weights, mask, pending = (values.get(name) for name in ("weights", "mask", "pending"))
    state = State(
        values["rest"],
        values["deformed"],
        None if weights is None else np.array(weights, float),
        tuple(map(str, values["labels"])),
        values["anchored"],
        cuts=[_decoded_value(cut) for cut in values["cuts"]],
        # files of earlier versions lack them
        handles=[_decoded_value(handle) for handle in values.get("handles", ())],
        mask=None if mask is None else _decoded_value(mask),
        enabled=values.get("enabled"),
        path=values.get("path"),
        pending=None if pending is None else Pending(*pending),
        **{o.name: o.checked(values[o.name]) for o in options.OPTIONS if o.name in values},
    )
    columns = state.deformed, state.labels, state.anchored, state.enabled, state.weights
    if any(column is not None and len(column) != len(state) for column in columns):
        raise ValueError("its columns of pairs have different lengths")
    if state.path.shape[1:] != state.rest.shape:
        raise ValueError("its path must have a place for each handle")
    if not all(np.isfinite(x).all() for x in (state.rest, state.deformed, state.path)):
        raise ValueError("its positions must be finite")
    return state


def _encoded_value(value):
    """The name of the class of a value, and its arguments."""
    if isinstance(value, RegionHandle):
        return ["region", [_encoded_shape(value.shape), value.motion.tolist()]]
    for name, (kind, attributes) in _CLASSES.items():
        if type(value) is kind:
            arguments = (np.asarray(getattr(value, attribute)) for attribute in attributes)
            return [name, [argument.tolist() for argument in arguments]]
    raise TypeError(f"a {type(value).__name__} has no format in an autosave file")


def _decoded_value(value):
    name, arguments = value
    if name == "region":
        return RegionHandle(_decoded_value(arguments[0]), arguments[1])
    if name == "labels":
        return _labels(*arguments)
    return _CLASSES[name][0](*arguments)


@functools.lru_cache(maxsize=64)  # a shape is the same at each edit
def _encoded_shape(shape):
    if not isinstance(shape, Labels):
        return _encoded_value(shape)
    grid = shape.grid
    bits = base64.b64encode(zlib.compress(np.packbits(shape.mask).tobytes())).decode("ascii")
    axes = (np.asarray(getattr(grid, name)) for name in _GRID)
    return ["labels", [bits, *(values.tolist() for values in axes)]]


def _labels(bits, *axes):
    grid = Grid(*axes)
    try:
        packed = np.frombuffer(zlib.decompress(base64.b64decode(bits)), np.uint8)
    except zlib.error as error:
        raise ValueError(f"the mask of a segmentation is broken: {error}") from error
    return Labels(np.unpackbits(packed, count=grid.size).reshape(grid.shape), grid)
