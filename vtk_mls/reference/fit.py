"""The map at points in float64: the weighted fit of Eq. 2, of one step or of several."""

import numpy as np

from vtk_mls.base.linear_algebra import finite
from vtk_mls.model.limits import limited, limited_jacobians
from vtk_mls.reference.weights import WeightedPoints


def fit_of(deformation, control_points, v, at=None):
    """The fit of all steps of control points at each of the points v (m, 3)."""
    steps = control_points.steps(deformation.steps_used)
    if len(steps) == 1:
        return StepFit(deformation, control_points, v, at)
    return ComposedFit(deformation, steps, v, at)


class ComposedFit:
    """The fits of several steps, each at the points to which the steps after it have led."""

    def __init__(self, deformation, steps, v, at):
        self.fits, self.legs = [], []  # for each step, the points and their images, (m, 3) each
        for step in reversed(steps):
            fit = StepFit(deformation, step, v, at)
            self.fits.append(fit)
            self.legs += fit.legs
            v = fit.legs[0][1]

    def displacement(self):
        return self.legs[-1][1] - self.legs[0][0]

    def jacobians(self):
        """As of `StepFit`, by the chain rule."""
        total_v, total_x = self.fits[0].jacobians()
        for fit in self.fits[1:]:
            d_dv, d_dx = fit.jacobians()
            total_v, total_x = d_dv @ total_v, d_dv @ total_x + d_dx
        return total_v, total_x

    def least_determinant(self):
        """The smallest determinant (m,) of the Jacobians of the steps."""
        return np.min([np.linalg.det(fit.jacobians()[0]) for fit in self.fits], axis=0)


def jacobian_of(fit):
    """dG/dv of the fixed point x = G(v; damping at x), from both parts of the Jacobian of a fit."""
    d_dv, d_dx = fit.jacobians()
    if not d_dx.any():
        return d_dv
    return np.linalg.pinv(finite(np.eye(3) - d_dx)) @ d_dv


class StepFit:
    """The weighted fit of Eq. 2 at each of the points v (m, 3), of one step.

    A single point is evaluated twice: for one point numpy.einsum sums in another order, and rounds
    differently.
    """

    def __init__(self, deformation, control_points, v, at=None):
        self.count, self.v, self.limits = len(v), v, deformation.limits
        if self.count == 1:
            v, at = np.repeat(v, 2, axis=0), at and at.rows([0, 0])
        self.weighted = WeightedPoints(deformation, control_points, v, at)
        self.fit = control_points.kind.fit(self.weighted)
        self._at = deformation, control_points, v, at

    @property
    def legs(self):
        """The points and their images."""
        return [(self.v, self.v + self.displacement())]

    def jacobians(self):
        """dl/dv at fixed origins x, and dl/dx: (m, 3, 3) each.

        The weights enter the optimal fit only through each control point's residual, so their part
        of the derivative is the sum of dw_i times the influence of control point i.
        """
        weighted, fit = self.weighted, self.fit
        if len(self._at[1].handles.segments) > 0:
            weighted = WeightedPoints(*self._at, with_slopes=True)
            fit = weighted.control_points.kind.fit(weighted)
        influence = fit.influence()
        d_dv, d_dx = (
            # the derivative of l through the weights
            np.einsum("mic,mia->mca", influence, slopes)
            for slopes in (weighted.dw, weighted.dw_dx)
        )
        d_dv = fit.linear + d_dv - np.eye(3)
        at_rest = self.weighted.at_rest[:, None, None]
        d_dv, d_dx = (np.where(at_rest, 0, j)[: self.count] for j in (d_dv, d_dx))
        if self.limits:
            before = self._unlimited_displacement()
            d_dv, d_dx = limited_jacobians(self.limits, self.v, before, d_dv, d_dx)
        return np.eye(3) + d_dv, d_dx

    def displacement(self):
        """G(v) - v = l(v) - v, Eq. 4 (rotations) and Eq. 26 (affine and polynomial), limited."""
        return limited(self.limits, self.v, self._unlimited_displacement())

    def _unlimited_displacement(self):
        at_rest = self.weighted.at_rest[:, None]
        return np.where(at_rest, 0, self.fit.displacement)[: self.count]
