"""The search for the inverse of the map on an OpenCL device."""

from __future__ import annotations

import functools

import numpy as np

from vtk_mls import guesses
from vtk_mls.engine import kernel_arguments
from vtk_mls.engine.launcher import RegionMap

# Points for each node of the grid of first guesses, and nodes.
_POINTS_PER_NODE, _LEAST_NODES, _MOST_NODES = 64, 1 << 10, 1 << 18
# Samples of the map, from which Newton's method starts again where it fails.
_SAMPLES = 1 << 12
_STARTS = 4  # so many of them, one after the other, ...
_WORTH = 0.05  # ... while they solve for at least this share of the remaining points
# Residual tolerances of Broyden's method and of the whole search, local units.
_QUICK, _FOUND = 5e-6, 1e-5


class InverseSearch:
    """Solves G(v) = x in one region, for x among `points` (m, 3).

    Unknowns are displacements v - x, in local units, where x is less the mean displacement. With
    many points, Broyden's method starts from first guesses interpolated on a grid over all of them.
    The points for which it does not converge, and all if they are few, are solved for by Newton's
    method with backtracking: from the map with p and q exchanged, and if that fails, where the cuts
    belong to the material from other `motions`, then from the samples of the map whose images are
    nearest to x.
    """

    def __init__(self, launcher, deformation, region, points, progress):
        self.launcher, self.deformation = launcher, deformation
        self.map = RegionMap(launcher, deformation, region)
        self.exchanged = RegionMap(launcher, deformation.exchanged_frame, region.exchanged)
        box = guesses.bounds(points)
        self.box = guesses.usual_bounds(points, box)
        self.has_far = np.abs(region.control_points.local(box)).max() > guesses.FARTHEST
        self.guess = None
        nodes = min(len(points) // _POINTS_PER_NODE, _MOST_NODES)
        if nodes >= _LEAST_NODES:
            self.guess = self._guess(nodes, progress)

    def forward(self, points):
        """v - x (m, 3), world units, for x of `points` (m, 3); whether it was found (m,)."""
        control_points = self.map.control_points
        local = self.map.local_points(points, control_points.mean_displacement)
        if self.guess is None:
            solved, residual = self._newton_restarted(local)
            displacement = self._in_world(solved)
        else:
            displacement, residual = self._broyden(local)
            lost = np.flatnonzero(~(residual <= _QUICK))  # NaN, too
            solved, residual[lost] = self._newton_restarted(np.ascontiguousarray(local[:, lost]))
            displacement[lost] = self._in_world(solved)
        found = residual <= _FOUND
        if self.has_far:
            found &= np.abs(local).max(axis=0) <= guesses.FARTHEST
        return displacement, found

    def _in_world(self, displacement):
        """v - x (m, 3), world units, of local displacements (3, m)."""
        control_points = self.map.control_points
        return control_points.scale * displacement.T - control_points.mean_displacement

    def _guess(self, nodes, progress):
        """Kernel arguments: displacements at the nodes of a grid over all points."""
        control_points = self.map.control_points
        box = control_points.local(self.box - control_points.mean_displacement)
        grid = guesses.cubic_grid(box, nodes)
        local = kernel_arguments.planes(grid.points())
        table = np.zeros((local.shape[1], 4), np.float32)
        for part in progress.over(self.launcher.search_slabs(len(table), self.deformation)):
            points = np.ascontiguousarray(local[:, part])
            displacement, _ = self._newton(points, self._exchanged_displacement(points))
            table[part, :3] = displacement.T
        return (
            self.map.memory.constant(table),
            kernel_arguments.filled(
                kernel_arguments.GUESS,
                dimensions=grid.dimensions,
                low=grid.origin,
                density=1 / grid.spacing,
            ),
        )

    def _broyden(self, local):
        """v - x (m, 3) float32, world units, for x `local` (3, m); the residuals (m,)."""
        count, control_points = local.shape[1], self.map.control_points
        displacement, residual = np.empty((count, 3), np.float32), np.empty(count, np.float32)
        arguments = [*self.guess, kernel_arguments.world(control_points)]
        outputs = [displacement, residual]
        self.map.launch_at("point_forward", local, arguments, outputs=outputs)
        return displacement, residual

    def _newton_restarted(self, local):
        """Displacements (3, m) for x `local` (3, m), from several starts; the residuals (m,)."""
        displacement, residual = self._newton(local, self._exchanged_displacement(local))

        def lost():
            return np.flatnonzero(residual > _FOUND)

        def restart(rows, points, start):
            again, remaining = self._newton(points, start)
            better = remaining < residual[rows]
            displacement[:, rows[better]] = again[:, better]
            residual[rows[better]] = remaining[better]
            return remaining <= _FOUND

        if self.deformation.in_rest_frame and len(rows := lost()) > 0:
            points = np.ascontiguousarray(local[:, rows])
            for motion in self._motions(points):
                restart(rows, points, motion)
        tried = np.full(len(residual), -1, np.float32)
        for _ in range(_STARTS):
            if len(rows := lost()) == 0 or self._samples is None:
                break
            points, distance = np.ascontiguousarray(local[:, rows]), tried[rows]
            start = np.empty_like(points)
            self.map.launch_at("nearest_sample", points, self._samples, [distance], [start])
            tried[rows] = distance
            if restart(rows, points, start).mean() < _WORTH:
                break
        return displacement, residual

    def _motions(self, local):
        """The `motions` (3, m) of x `local` (3, m), one after the other."""
        control_points = self.map.control_points
        rest = control_points.local(control_points.rest - control_points.mean_displacement)
        deformed = control_points.local(control_points.deformed)
        return map(kernel_arguments.planes, guesses.motions(rest, deformed, local.T))

    def _newton(self, local, displacement):
        """Displacements (3, m) by Newton's method, from those that are given; the residuals."""
        residual = np.empty(local.shape[1], np.float32)
        self.map.launch_at("point_inverse", local, changed=[displacement], outputs=[residual])
        return displacement, residual

    def _exchanged_displacement(self, local):
        """Displacements (3, m) of the map with p and q exchanged, at x `local` (3, m)."""
        control_points, other = self.map.control_points, self.exchanged.control_points
        ratio = control_points.scale / other.scale
        offset = (
            control_points.centre + control_points.mean_displacement - other.centre
        ) / other.scale
        points = kernel_arguments.planes(local.T * ratio + offset)
        displacement = np.empty_like(local)
        self.exchanged.launch_at("point_displacement", points, outputs=[displacement])
        mean_displacement = (
            other.mean_displacement + control_points.mean_displacement
        ) / control_points.scale
        return (displacement / ratio + mean_displacement[:, None]).astype(np.float32)

    @functools.cached_property
    def _samples(self):
        """Kernel arguments: number and table of samples with det(J) > 0; None if there are none."""
        control_points, planes = self.map.control_points, self.deformation.moved_planes
        box = guesses.joined(self.box, guesses.bounds(control_points.deformed))
        v = guesses.cubic_grid(guesses.padded(box, 0.1), _SAMPLES).points()
        v = v[self.map.region.holds(planes, v)]
        if len(v) == 0:
            return None
        local = kernel_arguments.planes(control_points.local(v))
        slope = np.empty((9, len(v)), np.float32)
        self.map.launch_at("point_jacobian", local, outputs=[slope])
        usable = np.linalg.det(np.eye(3) + slope.T.reshape(-1, 3, 3)) > 0
        displacement = self.map.at_local_points("point_displacement", self.map.displacements, local)
        if self.deformation.in_rest_frame:
            usable &= displacement[3] >= 0
        if not usable.any():
            return None
        table = kernel_arguments.samples(local[:, usable], (local + displacement[:3])[:, usable])
        return np.int32(len(table)), self.map.memory.constant(table)
