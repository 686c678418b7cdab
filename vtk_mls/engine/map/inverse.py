"""The search for the inverse of the map on an OpenCL device."""

import itertools

import numpy as np

from vtk_mls.engine.launch import kernel_arguments
from vtk_mls.engine.launch.kernel_arguments import CONSTANTS, filled
from vtk_mls.engine.map.region_map import RegionMap
from vtk_mls.queries import inverses

# Tolerances of the residuals of Broyden's method and of the whole search, local units.
_BROYDEN_TOLERANCE, _TOLERANCE = 5e-6, 1e-5
# The lattice of first guesses.
_CORNERS = np.array(list(itertools.product((0, 1), repeat=3)))[:, ::-1]  # along x first
_LATTICE_CELLS, _LATTICE_LEVELS = CONSTANTS["LATTICE_CELLS"], CONSTANTS["LATTICE_LEVELS"]
_NODES = _LATTICE_CELLS + 1  # along each axis of a level
_LEVEL_CELLS, _LEVEL_NODES = _LATTICE_CELLS**3, _NODES**3


class InverseSearch:
    """Solves G(v) = x in one region.

    Unknowns are displacements v - x in local units; the mean displacement is subtracted from x.
    Broyden's method starts from first guesses interpolated on a lattice. Where it does not
    converge, and beyond the lattice, Newton's method with backtracking starts from the map with p
    and q swapped. Where that fails, it restarts with cuts in the rest frame from other `motions`,
    then from the samples of the map with the images nearest to x. Several steps are inverted one
    after the other by Newton's method.

    The result for a point does not depend on the other points: points with equal coordinates get
    the same v to the bit, in every call.
    """

    def __init__(self, launcher, deformation, region):
        self.launcher, self.deformation = launcher, deformation
        self.map = RegionMap(launcher, deformation, region)
        if deformation.steps_used > 1:
            return
        self.swapped_map = RegionMap(launcher, deformation.with_deformed_cuts, region.swapped)
        if region not in launcher.lattices:
            launcher.lattices[region] = Lattice(inverses.usual_box(region.control_points))
        self.lattice = launcher.lattices[region]

    def forward(self, points):
        """v - x (m, 3), world units, for x of `points` (m, 3); whether it was found (m,)."""
        local = self.map.local_points(points, self.map.control_points.mean_displacement)
        if self.deformation.steps_used > 1:
            displacement, residual = self._newton(local, np.zeros_like(local))
            return self._in_world(displacement), residual <= _TOLERANCE
        displacement, residual = self._broyden(local)
        rows = np.flatnonzero(~(residual <= _BROYDEN_TOLERANCE))  # NaN, too
        unresolved = local.take(rows, axis=1)
        solved, residual[rows] = self._newton_restarted(unresolved)
        displacement[rows] = self._in_world(solved)
        residual[rows[np.abs(unresolved).max(axis=0) > inverses.FARTHEST]] = np.inf
        return displacement, residual <= _TOLERANCE

    def _in_world(self, displacement):
        """v - x (m, 3), world units, of local displacements (3, m)."""
        control_points = self.map.control_points
        return control_points.scale * displacement.T - control_points.mean_displacement

    def _broyden(self, local):
        """v - x (m, 3) float32, world units, for x `local` (3, m); the residuals (m,)."""
        count, control_points = local.shape[1], self.map.control_points
        displacement, residual = np.empty((count, 3), np.float32), np.empty(count, np.float32)
        nodes = self.lattice.unsolved_nodes(self._lattice_cells(local))
        if len(nodes) > 0:
            x = self.lattice.positions(nodes)
            guesses, _ = self._newton(x, self._swapped_displacement(x))
            self.lattice.set_displacements(nodes, guesses)
        table = self.lattice.buffer(self.map.memory)
        arguments = [self.lattice.record, table, kernel_arguments.world(control_points)]
        outputs = [displacement, residual]
        self.map.launch_at("point_forward", [local], arguments, outputs=outputs)
        return displacement, residual

    def _lattice_cells(self, local):
        """The cells of the lattice that x `local` (3, m) are in: (m,) int32."""
        count, memory = local.shape[1], self.map.memory
        cells = np.empty(count, np.int32)
        if count == 0:
            return cells
        constants = (("LANES", self.launcher.device.lanes),)
        with memory.input_buffer(local) as x, memory.output_buffer(cells) as out:
            arguments = np.int64(count), x, self.lattice.record, out
            self.launcher.launch("lattice_cells", constants, count, *arguments)
        return cells

    def _newton_restarted(self, local):
        """Displacements (3, m) for x `local` (3, m), from several starts; the residuals (m,)."""
        displacement, residual = self._newton(local, self._swapped_displacement(local))

        def unresolved():
            return np.flatnonzero(residual > _TOLERANCE)

        def restart(rows, points, start):
            solution, new_residual = self._newton(points, start)
            better = new_residual < residual[rows]
            displacement[:, rows[better]] = solution[:, better]
            residual[rows[better]] = new_residual[better]
            return new_residual <= _TOLERANCE

        if self.deformation.in_rest_frame and len(rows := unresolved()) > 0:
            points, control_points = local.take(rows, axis=1), self.map.control_points
            rest, deformed = control_points.handles.positions
            rest = control_points.local(rest - control_points.mean_displacement)
            for motion in inverses.motions(rest, control_points.local(deformed), points.T):
                restart(rows, points, kernel_arguments.planes(motion))
        rows = unresolved()
        rows = rows[np.abs(local.take(rows, axis=1)).max(axis=0) <= inverses.FARTHEST]  # not NaN
        levels = inverses.levels(self.lattice.box, local[:, rows].T)
        for level in np.unique(levels):
            remaining = rows[levels == level]
            for wider in range(inverses.EXTRA_LEVELS + 1):
                remaining = self._restart_from_samples(level + wider, local, remaining, restart)
        return displacement, residual

    def _restart_from_samples(self, level, local, rows, restart):
        """Restart at `rows` of x `local` (3, m) from samples of a level; the rows not found."""
        if level not in self.lattice.samples:
            box = inverses.doubled(self.lattice.box, level)
            self.lattice.samples[level] = self._sampled(box)
        samples = self.lattice.samples[level]
        last_distance2 = np.full(len(rows), -1, np.float32)
        for _ in range(inverses.MAX_RESTARTS):
            if samples is None or len(rows) == 0:
                break
            points = local.take(rows, axis=1)
            start = np.empty_like(points)
            self.map.launch_at("nearest_sample", [points], samples, [last_distance2], [start])
            is_unresolved = ~restart(rows, points, start)
            rows, last_distance2 = rows[is_unresolved], last_distance2[is_unresolved]
        return rows

    def _newton(self, local, displacement):
        """Displacements (3, m) by Newton's method from given ones, and the residuals (m,)."""
        residual = np.empty(local.shape[1], np.float32)
        self.map.launch_at("point_inverse", [local], changed=[displacement], outputs=[residual])
        return displacement, residual

    def _swapped_displacement(self, local):
        """Displacements (3, m) of the map with p and q swapped, at x `local` (3, m)."""
        control_points, other = self.map.control_points, self.swapped_map.control_points
        ratio = control_points.scale / other.scale
        offset = control_points.center + control_points.mean_displacement - other.center
        points = kernel_arguments.planes(local.T * ratio + offset / other.scale)
        displacement = np.empty_like(local)
        self.swapped_map.launch_at("point_displacement", [points], outputs=[displacement])
        means = other.mean_displacement + control_points.mean_displacement
        return (displacement / ratio + means[:, None] / control_points.scale).astype(np.float32)

    def _sampled(self, box):
        """Kernel arguments: number and table of samples with det(J) > 0; None without samples.

        They cover a `box` (2, 3), local units.
        """
        control_points = self.map.control_points
        local = inverses.cubic_grid(box, inverses.SAMPLES).points()
        world = control_points.center + control_points.scale * local
        v = local[self.map.region.holds(self.deformation.moved_planes, world)]
        if len(v) == 0:
            return None
        local = kernel_arguments.planes(v)
        slope = self.map.at_local_points("point_jacobian", 9, local)
        usable = np.linalg.det(np.eye(3) + slope.T.reshape(-1, 3, 3)) > 0
        displacement = self.map.at_local_points("point_displacement", self.map.displacements, local)
        if self.deformation.in_rest_frame:
            usable &= displacement[3] >= 0
        if not usable.any():
            return None
        table = np.zeros(np.count_nonzero(usable), kernel_arguments.STRUCTS["sample_t"])
        table["v"], table["image"] = local.T[usable], (local + displacement[:3]).T[usable]
        return np.int32(len(table)), self.map.memory.constant(table)


class Lattice:
    """The lattice of lattice.cl: first guesses at its nodes, and samples of the map on its levels.

    A launcher keeps it for each region as long as the deformation exists, so it holds arrays only.
    Nodes are solved for when a point first lies in a cell beside them. Points determine which nodes
    are solved for, never their values. `box` (2, 3), local units, is level 0; `samples` are kernel
    arguments by level, as `InverseSearch` makes them.
    """

    def __init__(self, box):
        self.box, self.samples = box, {}
        self.record = filled("lattice_t", center=box.mean(axis=0), density=2 / np.ptp(box, axis=0))
        self._is_solved = np.zeros(_LATTICE_LEVELS * _LEVEL_NODES, bool)
        self._displacement = np.zeros((len(self._is_solved), 4), np.float32)
        self._buffer = None

    def unsolved_nodes(self, cells):
        """Nodes (m,) at the corners of `cells` (n,) that have no displacement yet."""
        is_occupied = np.zeros(_LATTICE_LEVELS * _LEVEL_CELLS + 1, bool)
        is_occupied[cells] = True
        is_needed = np.zeros(len(self._is_solved), bool)
        is_needed[_corner_nodes(np.flatnonzero(is_occupied[:-1]))] = True
        return np.flatnonzero(is_needed & ~self._is_solved)

    def set_displacements(self, nodes, displacement):
        """Store displacements (3, m), local units, at `nodes` (m,)."""
        self._displacement[nodes, :3] = displacement.T
        self._is_solved[nodes] = True
        self._buffer = None

    def buffer(self, memory):
        """The displacements at the nodes, on the device; 0 at nodes without."""
        if self._buffer is None:
            stop = np.flatnonzero(self._is_solved).max(initial=0) + 1
            self._buffer = memory.constant(self._displacement[:stop])
        return self._buffer

    def positions(self, nodes):
        """Positions x (3, m) float32, local units, of `nodes` (m,)."""
        level, node = np.divmod(nodes, _LEVEL_NODES)
        index = np.stack(np.unravel_index(node, [_NODES] * 3)[::-1], axis=1)
        position = (2 * index / _LATTICE_CELLS - 1) * np.exp2(level)[:, None]
        center, half = self.box.mean(axis=0), np.ptp(self.box, axis=0) / 2
        return kernel_arguments.planes(center + half * position)


def _corner_nodes(cells):
    """The nodes at the corners of `cells` (m,): (m, 8)."""
    level, cell = np.divmod(cells, _LEVEL_CELLS)
    k, j, i = np.unravel_index(cell, [_LATTICE_CELLS] * 3)
    first = level * _LEVEL_NODES + i + _NODES * (j + _NODES * k)
    return first[:, None] + _CORNERS @ [1, _NODES, _NODES**2]
