"""The lattice of first guesses for the inverse, a property of the deformation."""

import itertools

import numpy as np

from vtk_mls.engine.launch import kernel_arguments
from vtk_mls.engine.launch.kernel_arguments import CONSTANTS, filled

_CORNERS = np.array(list(itertools.product((0, 1), repeat=3)))[:, ::-1]  # along x first
LATTICE_CELLS, LATTICE_LEVELS = CONSTANTS["LATTICE_CELLS"], CONSTANTS["LATTICE_LEVELS"]
_NODES = LATTICE_CELLS + 1  # along each axis of a level
_LEVEL_CELLS, _LEVEL_NODES = LATTICE_CELLS**3, _NODES**3


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
        self._is_solved = np.zeros(LATTICE_LEVELS * _LEVEL_NODES, bool)
        self._displacement = np.zeros((len(self._is_solved), 4), np.float32)
        self._buffer = None

    def unsolved_nodes(self, cells):
        """Nodes (m,) at the corners of `cells` (n,) that have no displacement yet."""
        is_occupied = np.zeros(LATTICE_LEVELS * _LEVEL_CELLS + 1, bool)
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
        position = (2 * index / LATTICE_CELLS - 1) * np.exp2(level)[:, None]
        center, half = self.box.mean(axis=0), np.ptp(self.box, axis=0) / 2
        return kernel_arguments.planes(center + half * position)


def _corner_nodes(cells):
    """The nodes at the corners of `cells` (m,): (m, 8)."""
    level, cell = np.divmod(cells, _LEVEL_CELLS)
    k, j, i = np.unravel_index(cell, [LATTICE_CELLS] * 3)
    first = level * _LEVEL_NODES + i + _NODES * (j + _NODES * k)
    return first[:, None] + _CORNERS @ [1, _NODES, _NODES**2]
