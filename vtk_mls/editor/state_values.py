"""A `State` as values of JSON, for autosave and session files."""

import base64
import functools
import zlib

import numpy as np

from vtk_mls import Grid
from vtk_mls.editor.state import State
from vtk_mls.model import options
from vtk_mls.model.shape_fields import CLASSES

_ARRAYS = "rest", "deformed", "anchored", "enabled", "path"
_GRID = "dimensions", "origin", "spacing", "direction"  # arguments of a Grid


def encoded(state):
    """The values of a state; TypeError for a shape without a format."""
    return {
        **options.values_of(state),
        **{name: getattr(state, name).tolist() for name in _ARRAYS},
        "weights": None if state.weights is None else state.weights.tolist(),
        "labels": list(state.labels),
        "cuts": [_encoded_value(cut) for cut in state.cuts],
        "handles": [_encoded_value(handle) for handle in state.handles],
        "mask": None if state.mask is None else _encoded_value(state.mask),
    }


def decoded(values):
    """The state of `encoded`; an error of any of the usual types if there is none."""
    if not isinstance(values, dict):
        raise TypeError("it is no object of JSON")
    weights, mask = values.get("weights"), values.get("mask")
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
    """The name of the class of a value, and its arguments; a grid is several."""
    if CLASSES.get(value.name) is not type(value):
        raise TypeError(f"a {type(value).__name__} has no format in an autosave file")
    arguments = []
    for field in value.fields:
        part = getattr(value, field.name)
        if field.kind == "shape":
            arguments.append(_encoded_shape(part))
        elif field.kind == "mask":
            packed = zlib.compress(np.packbits(part).tobytes())
            arguments.append(base64.b64encode(packed).decode("ascii"))
        elif field.kind == "grid":
            arguments += [np.asarray(getattr(part, name)).tolist() for name in _GRID]
        else:
            arguments.append(np.asarray(part).tolist())
    return [value.name, arguments]


_encoded_shape = functools.lru_cache(maxsize=64)(_encoded_value)  # it is the same at each edit


def _decoded_value(value):
    name, arguments = value
    shape, kinds = CLASSES[name], [field.kind for field in CLASSES[name].fields]
    if "shape" in kinds:
        arguments = [_decoded_value(arguments[0]), *arguments[1:]]
    if "grid" in kinds:
        arguments = _mask_and_grid(*arguments)
    return shape(*arguments)


def _mask_and_grid(bits, *axes):
    grid = Grid(*axes)
    try:
        packed = np.frombuffer(zlib.decompress(base64.b64decode(bits)), np.uint8)
    except zlib.error as error:
        raise ValueError(f"the mask of a segmentation is broken: {error}") from error
    return np.unpackbits(packed, count=grid.size).reshape(grid.shape), grid
