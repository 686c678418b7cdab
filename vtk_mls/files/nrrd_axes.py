"""The axes of NRRD files: in space, of components, and of time.

An axis is time if its kind says so; or if it is the last of four that have a spacing each, or are
directions in a space of four dimensions, and no kind says another thing (ITK and pynrrd write
these).
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

_SPATIAL, _UNKNOWN = ("domain", "space"), ("???", "none")
NOT_COMPONENTS = (*_SPATIAL, *_UNKNOWN, "time")  # for ITK
_DEFAULTS = {"kinds": "???", "spacings": "nan", "axis mins": "nan", "centers": "cell"}
_WRONG = "it must have three axes in space, or two in a plane, and at most one of components"


@dataclass
class Axis:
    """An axis; `spacing` and `low` are NaN, and `step` in space is None, if they are not stated."""

    kind: str
    spacing: float
    low: float
    center: str
    step: np.ndarray | None


def read(fields, count):
    """The axes, fastest first."""
    has_directions, columns = "space directions" in fields, []
    for name, default in _DEFAULTS.items():
        words = fields[name].split() if name in fields else [default] * count
        if len(words) != count and not has_directions:
            raise ValueError(f"its {name} must be {count}, one for each axis")
        columns.append(words if len(words) == count else [default] * count)
    texts = re.findall(r"none|\([^)]*\)", fields.get("space directions", ""))
    if has_directions and len(texts) != count:
        raise ValueError(_WRONG)
    steps = [None if text == "none" else vector(text) for text in texts] or [None] * count
    return [
        Axis(kind, float(spacing), float(low), center.lower(), step)
        for kind, spacing, low, center, step in zip(*columns, steps)
    ]


def time_of(axes, fields):
    """The index of the axis of time, the first time and the step; None without such an axis.

    In a space of four dimensions, axes and origin get those of the first three.
    """
    kinds = [axis.kind.lower() for axis in axes]
    has_directions = any(axis.step is not None for axis in axes)
    in_spacetime = [i for i, axis in enumerate(axes) if np.size(axis.step) == 4]
    spacings = [axis.spacing for axis in axes]
    if "time" in kinds:
        index = kinds.index("time")
    elif len(in_spacetime) == 4:
        index = in_spacetime[-1]
    elif len(axes) == 4 and np.isfinite(spacings).all() and not has_directions:
        index = 3
        if not {*kinds} <= {*_SPATIAL, *_UNKNOWN}:
            return None
    else:
        return None
    start, step = axes[index].low, spacings[index]
    if index in in_spacetime and len(in_spacetime) == 4:
        others = np.array([axes[i].step for i in in_spacetime if i != index])
        if axes[index].step[:3].any() or others[:, 3].any():
            raise ValueError("its axis of time must not be turned into space")
        origin = [*vector(fields.get("space origin", "0,0,0")).tolist(), 0.0, 0.0, 0.0, 0.0]
        start, step = origin[3], axes[index].step[3]
        fields["space origin"] = ",".join(map(repr, origin[:3]))
        for i in in_spacetime:
            axes[i].step = axes[i].step[:3]
    return index, start if np.isfinite(start) else 0.0, step if np.isfinite(step) else 1.0


def geometry(axes, fields):
    """Origin (3,), steps (3, 3) as columns, and the axis of components or None; without time."""
    steps = _steps(axes, "space directions" in fields)
    component_axes = [i for i, step in enumerate(steps) if step is None]
    origin = _origin(axes, steps, fields)
    steps = [step for step in steps if step is not None]
    shapes = {step.shape for step in [origin, *steps]}
    is_flat = len(steps) == 2 and shapes == {(2,)}
    is_solid = len(steps) == 3 and shapes == {(3,)}
    if not (is_flat or is_solid) or len(component_axes) > 1:
        raise ValueError(_WRONG)
    if is_flat:
        steps = [np.append(step, 0) for step in steps] + [np.zeros(3)]
        origin = np.append(origin, 0)
    return origin, np.transpose(steps), component_axes[0] if component_axes else None


def _steps(axes, has_directions):
    """The step in space along each axis, None for components.

    If kinds do not say it, axes with a spacing are in space if they are three in all; otherwise the
    first three are, as in ITK.
    """
    if has_directions:
        steps = [axis.step for axis in axes]
        return [None if step is None or np.isnan(step).all() else step for step in steps]
    spatial = [i for i, axis in enumerate(axes) if axis.kind.lower() in _SPATIAL]
    unknown = [i for i, axis in enumerate(axes) if axis.kind.lower() in _UNKNOWN]
    with_spacing = [i for i in unknown if np.isfinite(axes[i].spacing)]
    if len(spatial) + len(with_spacing) == 3:
        unknown = with_spacing
    spatial = sorted([*spatial, *unknown[: max(3 - len(spatial), 0)]])
    steps = [None] * len(axes)
    for i, unit in zip(spatial, np.eye(max(len(spatial), 2))):
        steps[i] = unit * np.nan_to_num(axes[i].spacing, nan=1, posinf=1, neginf=1)
    return steps


def _origin(axes, steps, fields):
    """Position of the first value: the middle of its cell, unless `centers` says node."""
    size = next((len(step) for step in steps if step is not None), 3)
    if "space origin" in fields:
        origin = vector(fields["space origin"])
        return np.zeros(size) if np.isnan(origin).all() else origin
    if "space directions" in fields:
        return np.zeros(size)
    pairs = [(axis, step) for axis, step in zip(axes, steps) if step is not None]
    origin = [axis.low + (axis.center != "node") * step.sum() / 2 for axis, step in pairs]
    return np.where(np.isnan(origin), 0.0, origin)


def vector(text):
    """The numbers of a text such as "(1,0,0)"."""
    return np.array([float(number) for number in text.strip("() ").split(",")])
