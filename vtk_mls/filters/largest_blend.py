"""The largest share of a deformation that keeps a mesh valid."""

import math
from typing import NamedTuple

STEPS = 100  # of a blend of 1


class Blends(NamedTuple):
    """Shares of a deformation."""

    blend: float  # that of the filter
    whole: object  # the Transform at this blend
    at: object = None  # a function that gives the Transform at another


def largest_blend(blend, inverts, progress):
    """The largest blend at which no cell is inside out, a multiple of 1 / `STEPS`.

    By bisection between 0, where nothing moves, and `blend`, where some cell is inside out: at the
    result none is, and at one step more some is. Cells that are inside out over a part of the way
    only can be missed. `inverts(blend, progress)` says whether some cell is inside out.
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
