"""The largest share of a deformation that keeps a mesh valid."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from vtk_mls.queries.transform import Transform

STEPS = 100  # of a blend of 1


@dataclass(frozen=True)
class Blends:
    """Shares of a deformation.

    Attributes
    ----------
    blend : float
        That of the filter.
    whole : Transform
        At this blend.
    at : callable, optional
        `at(blend)`: that at another.
    """

    blend: float
    whole: Transform
    at: Callable[[float], Transform] | None = None


def largest_blend(blend, inverts, progress):
    """The largest blend at which no cell is inside out, in steps of 1 / `STEPS`.

    By bisection between 0, where nothing moves, and `blend`: at the result no cell is inside out,
    and at one step more some cell is. Cells that are inside out over a part of the way only can be
    missed.

    Parameters
    ----------
    blend : float
        Some cell is inside out there.
    inverts : callable
        `inverts(blend, progress)`: whether some cell is inside out.
    progress : Progress

    Returns
    -------
    float
        A multiple of 1 / `STEPS`.
    """
    low, high = 0, math.ceil(abs(blend) * STEPS)
    parts = iter(progress.divided(*[1] * (high.bit_length() + 1)))
    while high - low > 1:
        middle = (low + high) // 2
        if inverts(math.copysign(middle / STEPS, blend), next(parts)):
            high = middle
        else:
            low = middle
    return math.copysign(low / STEPS, blend)
