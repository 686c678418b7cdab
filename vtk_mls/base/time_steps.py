"""Time steps of data."""

import numpy as np

_ROUNDING = 0.01  # steps; files round times to float32, or to a few decimal digits


def step_at(steps, time):
    """The index in sorted `steps` of a time: of the last that is not after it, or the first.

    A step that is after it by rounding only, by less than a hundredth of the step, counts. None is
    before all steps.
    """
    if time is None or not steps:
        return 0
    rounding = _ROUNDING * np.diff(steps, prepend=steps[0])
    return max(int(np.sum(np.subtract(steps, rounding) <= time)) - 1, 0)
