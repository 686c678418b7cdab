"""First guesses for the inverse at the nodes of a lattice that is the deformation's own."""

from __future__ import annotations

import itertools

import numpy as np

from vtk_mls.engine.launch import kernel_arguments
from vtk_mls.engine.launch.kernel_arguments import LATTICE_CELLS, LATTICE_LEVELS

_CORNERS = np.array(list(itertools.product((0, 1), repeat=3)))[:, ::-1]  # along x first
_NODES = LATTICE_CELLS + 1  # along each axis of a level
_LEVEL_CELLS, _LEVEL_NODES = LATTICE_CELLS**3, _NODES**3


class Lattice:
    """The lattice of lattice.cl, and first guesses at its nodes.

    Only nodes at corners of cells with points in them are found. Which cells these are depends on
    the points, what is found there does not.

    Parameters
    ----------
    launcher : Launcher
    box : (2, 3) float64, local units
        Level 0.
    solve : callable
        Displacements (3, m) float32 for x (3, m) float32, local units.
    """

    def __init__(self, launcher, box, solve):
        self.launcher, self.box, self._solve = launcher, box, solve
        self._record = kernel_arguments.filled(
            kernel_arguments.LATTICE, center=box.mean(axis=0), density=2 / np.ptp(box, axis=0)
        )
        self._is_found = np.zeros(LATTICE_LEVELS * _LEVEL_NODES, bool)
        self._displacement = np.zeros((len(self._is_found), 4), np.float32)

    def around(self, points):
        """Kernel arguments: the lattice, and its nodes around `points` (3, m)."""
        is_occupied = np.zeros(LATTICE_LEVELS * _LEVEL_CELLS + 1, bool)
        is_occupied[self._cells(points)] = True
        nodes = _corner_nodes(np.flatnonzero(is_occupied[:-1]))
        self._find(nodes)
        size = nodes.max(initial=0) + 1
        return self._record, self.launcher.constant(self._displacement[:size])

    def _cells(self, points):
        """The cells that `points` (3, m) are in: (m,) int32."""
        count, memory = points.shape[1], self.launcher.memory
        cells = np.empty(count, np.int32)
        if count == 0:
            return cells
        constants = (("LANES", self.launcher.device.lanes),)
        with memory.read(points) as read, memory.written(cells) as out:
            self.launcher.launch(
                *("lattice_cells", constants, count, np.int64(count), read, self._record, out)
            )
        return cells

    def _find(self, nodes):
        """Find the displacements at those of `nodes` (any shape) that are not known yet."""
        is_needed = np.zeros(len(self._is_found), bool)
        is_needed[nodes] = True
        missing = np.flatnonzero(is_needed & ~self._is_found)
        if len(missing) == 0:
            return
        self._displacement[missing, :3] = self._solve(self._positions(missing)).T
        self._is_found[missing] = True

    def _positions(self, nodes):
        """Where `nodes` (m,) are: (3, m) float32, local units."""
        level, node = np.divmod(nodes, _LEVEL_NODES)
        index = np.stack(np.unravel_index(node, [_NODES] * 3)[::-1], axis=1)
        position = (2 * index / LATTICE_CELLS - 1) * np.exp2(level)[:, None]
        center, half = self.box.mean(axis=0), np.ptp(self.box, axis=0) / 2
        return kernel_arguments.planes(center + half * position)


def _corner_nodes(cells):
    """The nodes at the corners of `cells` (m,): (m, 8)."""
    level, cell = np.divmod(cells, _LEVEL_CELLS)
    k, j, i = np.unravel_index(cell, [LATTICE_CELLS] * 3)
    first = level * _LEVEL_NODES + i + _NODES * (j + _NODES * k)
    return first[:, None] + _CORNERS @ [1, _NODES, _NODES**2]
