"""Newton's method for the inverse of a map, in float64."""

import numpy as np

from vtk_mls.base.linear_algebra import finite

_MAX_EVALUATIONS = 64
_CONVERGED = 1e-12  # residual that ends the iteration, as a fraction of the size
_MIN_SHARE = 0.01  # of a Newton step, by backtracking


def newton(evaluate, x, guess, size):
    """v (m, 3) with v + d(v) = x from a first guess of v, and the residuals |v + d(v) - x| (m,).

    `evaluate(v, rows)` returns the displacements d (k, 3) at v (k, 3) for `rows` (k,) of x, and a
    function without arguments for the Jacobians of v + d(v), (k, 3, 3). The tolerance is relative
    to the lengths `size` (m,). Backtracking halves a step that does not reduce the residual.
    """
    candidate, v = guess.copy(), guess.copy()
    residual, share, step = np.full(len(x), np.inf), np.ones(len(x)), np.zeros_like(x)
    tolerance = _CONVERGED * size
    active = np.arange(len(x))
    for _ in range(_MAX_EVALUATIONS):
        displacement, jacobians = evaluate(candidate[active], active)
        error = x[active] - candidate[active] - displacement
        distance = np.linalg.norm(error, axis=1)
        closer = distance < residual[active]
        v[active[closer]], residual[active[closer]] = candidate[active[closer]], distance[closer]
        share[active] = np.where(closer, 1, share[active] / 2)
        goes_on = (residual[active] > tolerance[active]) & (share[active] > _MIN_SHARE)
        if not goes_on.any():
            break
        new = goes_on & closer
        inverse = np.linalg.pinv(finite(jacobians()[new]))
        step[active[new]] = (inverse @ error[new][:, :, None])[:, :, 0]
        active = active[goes_on]
        candidate[active] = v[active] + share[active, None] * step[active]
    return v, residual
