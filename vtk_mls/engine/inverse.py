"""The search for the inverse of the map on an OpenCL device."""

from __future__ import annotations

import functools

import numpy as np

from vtk_mls import guesses
from vtk_mls.engine import kernel_arguments

# Points for each node of the lattice of first guesses, and nodes.
_POINTS_PER_NODE, _LEAST_NODES, _MOST_NODES = 64, 1 << 10, 1 << 18
# Samples of the map, where points begin that do not find their place otherwise.
_SAMPLES = 1 << 12
_STARTS = 4  # so many of them, one after the other, ...
_WORTH = 0.05  # ... while they find at least this share of what is lost
# What may be left of G(v) = x, in local units, after the quick search and after all.
_QUICK, _FOUND = 5e-6, 1e-5


class InverseSearch:
    """The inverse of the map in one region, at some of `points` (m, 3).

    Each place x, less drift, gets a way from it to the v with G(v) = x, in local units, and what is
    left of G(v) = x there. Many points find theirs quickly, from first guesses on a lattice over
    all of them. The others are looked for by Newton's method: from the map with p and q exchanged,
    and while that leads nowhere, from the places among samples that the map brings nearest to x.
    """

    def __init__(self, engine, deformation, region, points, progress):
        self.engine, self.deformation, self.region = engine, deformation, region
        box = guesses.bounds(points)
        self.box = guesses.usual_bounds(points, box)
        self.has_far = np.abs(region.control_points.local(box)).max() > guesses.FARTHEST
        self.guess = None
        nodes = min(len(points) // _POINTS_PER_NODE, _MOST_NODES)
        if nodes >= _LEAST_NODES:
            self.guess = self._guess(nodes, progress)

    def forward(self, points):
        """v - x (m, 3), world units, for x of `points` (m, 3); whether it was found (m,)."""
        control_points = self.region.control_points
        local = self.engine.local_points(control_points, points, control_points.mean_displacement)
        if self.guess is None:
            ways, left = self._careful(local)
            displacement = control_points.scale * ways.T - control_points.mean_displacement
        else:
            displacement, left = self._quick(local)
            lost = np.flatnonzero(~(left <= _QUICK))  # NaN, too
            ways, left[lost] = self._careful(np.ascontiguousarray(local[:, lost]))
            displacement[lost] = control_points.scale * ways.T - control_points.mean_displacement
        found = left <= _FOUND
        if self.has_far:
            found &= np.abs(local).max(axis=0) <= guesses.FARTHEST
        return displacement, found

    def _guess(self, nodes, progress):
        """Kernel arguments of a lattice with the ways at its nodes."""
        engine, control_points = self.engine, self.region.control_points
        lattice = guesses.Lattice.over(
            control_points.local(self.box - control_points.mean_displacement), nodes
        )
        local = kernel_arguments.planes(lattice.points())
        table = np.zeros((local.shape[1], 4), np.float32)
        for part in engine.search_slabs(len(table), self.deformation):
            ways, _ = self._newton(*self._begun(np.ascontiguousarray(local[:, part])))
            table[part, :3] = ways.T
            if progress is not None:
                progress(0.0)  # nothing is done yet, but abort is heard
        dimensions = np.array([*lattice.dimensions, 1], np.int32)
        density = kernel_arguments.float4(np.full(3, 1 / lattice.step))
        return engine.constant(table), dimensions, kernel_arguments.float4(lattice.low), density

    def _quick(self, local):
        """v - x (m, 3) float32, world units, for places `local` (3, m); what is left (m,)."""
        count, control_points = local.shape[1], self.region.control_points
        displacement, left = np.empty((count, 3), np.float32), np.empty(count, np.float32)
        frame = (
            np.float32(control_points.scale),
            kernel_arguments.float4(control_points.mean_displacement),
        )
        self._run("point_forward", local, [*self.guess, *frame], outputs=[displacement, left])
        return displacement, left

    def _careful(self, local):
        """Ways (3, m) from places `local` (3, m); what is left (m,)."""
        ways, left = self._newton(*self._begun(local))
        tried = np.full(len(left), -1, np.float32)
        for _ in range(_STARTS):
            lost = np.flatnonzero(left > _FOUND)
            if len(lost) == 0 or self._samples is None:
                break
            places, distance = np.ascontiguousarray(local[:, lost]), tried[lost]
            begin = np.empty_like(places)
            self._run("nearest_sample", places, self._samples, [distance], [begin])
            tried[lost] = distance
            again, rest = self._newton(places, begin)
            better = rest < left[lost]
            ways[:, lost[better]], left[lost[better]] = again[:, better], rest[better]
            if (rest <= _FOUND).mean() < _WORTH:
                break
        return ways, left

    def _newton(self, local, ways):
        """The ways that Newton's method finds from first guesses; what is left."""
        left = np.empty(local.shape[1], np.float32)
        self._run("point_inverse", local, changed=[ways], outputs=[left])
        return ways, left

    def _begun(self, local):
        """`local`, and the ways of the map with p and q exchanged."""
        control_points, other = self.region.control_points, self.region.exchanged.control_points
        ratio = control_points.scale / other.scale
        offset = (
            control_points.centre + control_points.mean_displacement - other.centre
        ) / other.scale
        there, ways = kernel_arguments.planes(local.T * ratio + offset), np.empty_like(local)
        self._run("point_displacement", there, outputs=[ways], region=self.region.exchanged)
        mean_displacement = (
            other.mean_displacement + control_points.mean_displacement
        ) / control_points.scale
        return local, (ways / ratio + mean_displacement[:, None]).astype(np.float32)

    @functools.cached_property
    def _samples(self):
        """Kernel arguments: number and table of samples all round; None if there are none."""
        control_points, planes = self.region.control_points, self.deformation.planes
        box = guesses.joined(self.box, guesses.bounds(control_points.deformed))
        v = guesses.Lattice.over(guesses.padded(box, 0.1), _SAMPLES).points()
        v = v[self.region.holds(planes, v)]
        if len(v) == 0:
            return None
        local = kernel_arguments.planes(control_points.local(v))
        slope = np.empty((9, len(v)), np.float32)
        self._run("point_jacobian", local, outputs=[slope])
        upright = np.linalg.det(np.eye(3) + slope.T.reshape(-1, 3, 3)) > 0
        if not upright.any():
            return None
        local = np.ascontiguousarray(local[:, upright])
        moved = np.empty_like(local)
        self._run("point_displacement", local, outputs=[moved])
        table = np.ascontiguousarray(np.concatenate([local, local + moved]).T)
        return np.int32(local.shape[1]), self.engine.constant(table)

    def _run(self, kernel, places, arguments=(), changed=(), outputs=(), region=None):
        """Launch a kernel of the map, here or in another region."""
        self.engine.run_at(
            kernel, self.deformation, region or self.region, places, arguments, changed, outputs
        )
