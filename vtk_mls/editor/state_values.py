"""A `State` as values of JSON, for autosave and session files."""

from __future__ import annotations

import numpy as np

from vtk_mls.editor import json_values
from vtk_mls.editor.pairs import Pending
from vtk_mls.editor.state import State
from vtk_mls.model import options


def encoded(state):
    """The values of a state.

    Raises
    ------
    TypeError
        For a shape without a format.
    """
    pending = state.pending
    return {
        **options.values_of(state),
        "rest": state.rest.tolist(),
        "deformed": state.deformed.tolist(),
        "weights": None if state.weights is None else state.weights.tolist(),
        "labels": list(state.labels),
        "anchored": state.anchored.tolist(),
        "enabled": state.enabled.tolist(),
        "pending": pending and [pending.side, pending.position.tolist(), pending.label],
        "cuts": [json_values.encoded(cut) for cut in state.cuts],
        "handles": [json_values.encoded(handle) for handle in state.handles],
        "mask": None if state.mask is None else json_values.encoded(state.mask),
    }


def decoded(values):
    """The state of `encoded`.

    Raises
    ------
    ValueError, KeyError, TypeError, IndexError, RecursionError
        If there is none.
    """
    if not isinstance(values, dict):
        raise TypeError("it is no object of JSON")
    weights, mask, pending = (values.get(name) for name in ("weights", "mask", "pending"))
    state = State(
        values["rest"],
        values["deformed"],
        None if weights is None else np.array(weights, float),
        tuple(map(str, values["labels"])),
        values["anchored"],
        cuts=[json_values.decoded(cut) for cut in values["cuts"]],
        # files of earlier versions lack them
        handles=[json_values.decoded(handle) for handle in values.get("handles", ())],
        mask=None if mask is None else json_values.decoded(mask),
        enabled=values.get("enabled"),
        pending=None if pending is None else Pending(*pending),
        **{o.name: o.checked(values[o.name]) for o in options.OPTIONS if o.name in values},
    )
    columns = state.deformed, state.labels, state.anchored, state.enabled, state.weights
    if any(column is not None and len(column) != len(state) for column in columns):
        raise ValueError("its columns of pairs have different lengths")
    if not (np.isfinite(state.rest).all() and np.isfinite(state.deformed).all()):
        raise ValueError("its positions must be finite")
    return state
