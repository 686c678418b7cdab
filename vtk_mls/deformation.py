"""The deformation: a validated value that answers questions about its map."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base import validation
from vtk_mls.base.grid import Grid
from vtk_mls.base.progress import ProgressLike
from vtk_mls.engine.device.device_check import CUTS, FIELDS
from vtk_mls.engine.dispatch import engine_for
from vtk_mls.model.map_parameters import MapParameters
from vtk_mls.model.options import named
from vtk_mls.queries import fold_free, handle_warnings
from vtk_mls.queries.certificate import NO_FOLDS
from vtk_mls.queries.transform import Transform, question

# Of the field by which images are checked for folds; ParaView's, too small to see.
_CHECK_TOLERANCE = named("map_tolerance").interactive_default


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Deformation(Transform, MapParameters):
    """A moving-least-squares deformation of space, given by control points.

    The backward map G gives for each point v of the deformed space the origin of its material
    (Eq. 2 of the paper). It interpolates the control points, G(q_i) = p_i, unless `smoothing` is
    set, and is the identity if p = q.

    Parameters
    ----------
    rest : (n, 3) array_like, world coordinates
        p, the control points in the undeformed space.
    deformed : (n, 3) array_like, world coordinates
        q, the control points in the deformed space. Control points with the same q count as one,
        at their weighted mean p.
    kind : {"affine", "rigid", "similarity", "polynomial", "spline", "auto", "tps"}
        The maps that are fitted around each point: affine (Eq. 5 to 7), rotations (Eq. 8 to 22),
        rotations with a uniform factor (end of section 2), polynomials (Eq. 23 to 26). Or one
        polyharmonic spline, without cuts and rigid regions, through up to 5,000 control points.
        "auto" is the spline with all settings automatic, or, with up to four control points,
        cuts or rigid regions, "rigid"; "tps" is the spline of order 1.
    alpha : float, > 0
        Weights are ``1 / (|q_i - v|^2 + smoothing^2)^alpha``: a larger alpha makes control points
        act more locally. The paper's examples have 1. In space only alpha > 3/2 is local: a shell
        of control points at distance r has about r^2 of them. For alpha <= 1/2 the map has a kink
        at each control point.
    smoothing : float, >= 0, world units, or "auto"
        0 interpolates the control points. Above 0 the map passes close to them. The diagonal of the
        equations of a spline gets ``smoothing^order / weight``; "auto", for splines, predicts
        control points left out best.
    degree : {1, 2, 3}
        Degree of the polynomial kind.
    order : {1, 2, 3} or "auto"
        Order of the spline: r, r^2 log r or r^3. "auto" predicts control points left out best.
    softening : float, >= 0, world units, or "auto"
        In a spline r is ``sqrt(r^2 + softening^2)``, so that it is smooth at the control points.
        "auto" is 0 for a given order, and chosen with an automatic one.
    steps : int or "auto"
        Number of steps in which p goes to q, 1 to 256, each with its own map: G is composed of
        them. It meets the control points, and the smaller the steps, the fewer folds it has. "auto"
        takes as many as sampled points around the handles need (`without_folds`), along a path
        where these would be more than 16 (`path_used`). A field or image on a whole grid adds
        steps, for later questions, too, where the map folds at the corner or center of a voxel.
        Polynomials of degree 2 and 3 may fold in any steps.
    path : (k, n, 3) array_like, world coordinates, optional
        Intermediate places of the control points on the way from p to q, for turns that p and q do
        not tell. The steps are a multiple of k + 1. Curves go straight, regions along a screw.
    weights : (n,) array_like, > 0, optional
        Factor of the weight of each control point; 1 by default.
    handles : sequence of CurveHandle and RegionHandle
        Curves and rigid regions beside the control points, which may be empty then.
    cuts : sequence of Plane, HalfPlane and Surface
        Surfaces that keep control points from acting on the material behind them (section 4). A
        side of a Plane without control points stays at rest. A control point exactly on a Plane or
        HalfPlane belongs to the side of its normal.
    mask : BallMask, BoxMask or ImageMask, optional
        Where the deformation acts: G(v) = v + m (l(v) - v) with m from 0 to 1. Where m = 0
        everything stays as it was, to the bit. Control points in a fall-off are not met, as
        `residuals` tells.
    constraints : sequence of FixedFace and SlidingFace
        Planes and surfaces of the deformed space that stay, or along which material slides.
    nu : float, > 1
        Damping exponent of Eq. 28: how fast influence decreases with the length of the detour.
    cut_frame : {"rest", "deformed"}
        "rest": cuts are in the undeformed space and move with the material; the rest positions of
        material and control points decide what a cut separates. "deformed": cuts are fixed in the
        deformed space, as in the paper; material that reaches a cut is lost.
    map_tolerance : float, >= 0
        Largest error of displacements on grids, in spacings of the grid; 0 computes every point.
        Above 0, `displacement_field`, `resample`, `source_bounds`, `resample_gradients` and
        `corrected_gradient` interpolate the map from every fourth point in all cells where a check
        finds the error small enough. Cells near control points and cuts, and grids with few or
        flat layers, are computed exactly. Void distances keep their sign. The same bound holds for
        the change of the map from each point to the next, and so for the Jacobians of gradients.
    device : str, optional
        "gpu" or "cpu" for the first of its kind, "0:1" for platform 0 and device 1, "reference"
        for the float64 numpy specification. By default the environment variable VTK_MLS_DEVICE,
        else the first GPU, else the fastest CPU driver, else the specification with a warning.

    Raises
    ------
    ValueError, TypeError
        For a bad argument, naming it. Methods also raise `DeviceError` if the device is not
        available, and `Aborted`.

    Notes
    -----
    Control points that do not determine a map get the one nearest to the identity: a single
    control point (or several with a common displacement) translates; control points on a line turn
    without twist about it; on a plane they do not change the direction across it; too few for a
    degree fit only the polynomials that they distinguish.

    Kernels compute in float32, in a local frame, to about 1e-6 of the extent of the control
    points. `backward` returns the full float64 precision of `points`.

    Methods take `progress`, a callable that is called with the fraction done, from 0 to 1. A true
    return value stops the computation with `Aborted`.
    """

    def residuals(self, progress: ProgressLike = None) -> NDArray[np.float64]:
        """How far the map is from each control point: G(q_i) - p_i.

        It is 0 to rounding, unless `smoothing`, the mask or a constraint keeps the map from it, or
        several control points have the same q.

        Returns
        -------
        (n, 3) float64, world units
        """
        return self.backward(self.deformed, progress) - self.rest

    @functools.cached_property
    def steps_used(self) -> int:
        """The number of steps: `steps`, or as many as automatic steps have found necessary."""
        if self.steps:
            return super().steps_used
        found = fold_free.in_enough_steps(self._engine_for(), self)
        if len(found.path) > len(self.path):
            vars(self).update(regions=found.regions, _rigid_path=found.path)
        return found.steps_used

    @property
    def path_used(self) -> NDArray[np.float64]:
        """The path (k, n, 3), world coordinates: `path`, or a rigid one that needs fewer steps.

        Automatic steps that would be more than 16 go along it. There is none with curves, regions
        or more than 1,000 control points. `steps_used` and `path_used` make the same map again.
        """
        _ = self.steps_used
        return vars(self).get("_rigid_path", self.path)

    @property
    def smallest_determinant(self) -> float:
        """The smallest determinant of the Jacobian of the map that was computed.

        The deformation folds if it is not above 0. It is that of samples around the handles and,
        with automatic steps, of all voxels of the last field or image that may fold, at their
        corners and centers.
        """
        return min(self._sampled_determinant, self._checked[1].smallest)

    @functools.cached_property
    def smallest_step_determinant(self) -> float:
        """The smallest determinant of the Jacobian of a single step, at the same samples.

        Automatic steps are doubled until it is above 0.1 at those samples that came near a fold in
        fewer steps: a composition of steps that do not fold does not fold.
        """
        return fold_free.smallest_step_determinant(self._engine, self)

    @functools.cached_property
    def _sampled_determinant(self):
        return fold_free.smallest_determinant(self._engine, self)

    @property
    def _checked(self):
        """The grid that was checked for folds last, and its FoldCheck."""
        return vars(self).get("_last_check", (None, NO_FOLDS))

    def _field(self, grid, progress):
        if self.steps or grid.is_part:  # the parts of a grid must fit together
            return super()._field(grid, progress)
        return self._checked_field(grid, self.map_tolerance, progress)

    def _prepare(self, grid, progress):
        if self.steps or grid.is_part or grid.is_same(self._checked[0]):
            return progress
        checking, progress = progress.divided(1, 2)
        self._checked_field(grid, max(self.map_tolerance, _CHECK_TOLERANCE), checking)
        return progress

    def _check_folds(self, grid, progress):
        if self.steps or grid.is_part:
            return super()._check_folds(grid, progress)
        self._prepare(grid, progress)
        return self._checked[1]

    def _checked_field(self, grid, tolerance, progress):
        """The field on a grid, in twice as many steps until the map folds at no voxel."""
        present = self
        if tolerance != self.map_tolerance:
            present = self.in_steps(self.steps_used, tolerance)
        field, folds, used = fold_free.checked_field(self._field_engine, present, grid, progress)
        self._take_steps(used)
        vars(self).update(_last_check=(grid, folds))
        return field

    def _add_steps(self, points: NDArray[np.float64]) -> bool:
        """Double automatic steps until the map folds at no material point (m, 3); whether it did.

        At most 256 steps.
        """
        return self._take_steps(fold_free.unfolded(self._engine, self, points))

    def _take_steps(self, other):
        """Take as many steps as another deformation; whether these are more."""
        if other.steps_used == self.steps_used:
            return False
        for name in ("_sampled_determinant", "smallest_step_determinant", "_last_check"):
            vars(self).pop(name, None)
        vars(self).update(steps_used=other.steps_used, regions=other.regions)
        return True

    def without_folds(
        self, where: Grid | ArrayLike | None = None, progress: ProgressLike = None
    ) -> Deformation:
        """The deformation in as many `steps` as `where` needs: doubled until the determinants of
        all steps are above 0.1 at sampled points, at most 256. It can still fold between them. The
        control points have a `path` where straight ways need more than 16 steps.

        Parameters
        ----------
        where : Grid or (m, 3) array_like, world coordinates of the deformed space, optional
            A box around the handles by default.
        progress : callable, optional
        """
        if where is not None and not isinstance(where, Grid):
            where = validation.points("where", where)
            if len(where) == 0:
                raise ValueError("`where` must have at least one point, got none")
        with question(progress) as part:
            found = fold_free.in_enough_steps(self._engine, replace(self), where, part)
            return replace(self, steps=found.steps_used, path=found.path)

    @property
    def overlapping_regions(self) -> list[tuple[int, int]]:
        """Pairs of rows of `handles`: rigid regions that overlap where they were moved to."""
        return handle_warnings.overlapping_regions(self.handles)

    @property
    def _engine(self):
        _ = self.steps_used  # before a question about the regions, which may get a path
        return self._engine_for()

    @property
    def _field_engine(self):
        _ = self.steps_used
        return self._engine_for(FIELDS)

    def _engine_for(self, *needed):
        points = [region.control_points for region in self.regions]
        needs_float64 = any(p.kind.is_wrong_in_float32(p) for p in points)
        kinds = {p.kind.name for p in points}
        return engine_for(self.device, needs_float64, {*needed, *kinds, *[CUTS][: len(self.cuts)]})

    def _material_samples(self, grid):
        return self.handle_set.positions
