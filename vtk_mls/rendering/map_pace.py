"""How fine maps are, so that the mouse is followed."""

from __future__ import annotations

import time

import numpy as np

_MOVING, _RESTING = 0.06, 0.7  # seconds that a map may take
_FEW, _MANY = 24, 64  # nodes along the longest side
_MUCH_FINER = 1.25


class MapPace:
    """Chooses the nodes of maps by what the last one took.

    Parameters
    ----------
    most : int
        Nodes along the longest side of a map that stays.

    Attributes
    ----------
    map_seconds : float
        Of the last one.
    nodes : int
        Likewise.
    """

    def __init__(self, most):
        self.map_seconds, self.nodes, self._most = 0.0, _MANY, most

    def make(self, make_map, is_moving):
        """Call `make_map(nodes)` with as many nodes as there is time for.

        A map that stays is made anew if it took much less than was expected: the one before may
        have waited for its kernel to be built, or for a busy machine.
        """
        nodes = self.nodes_while_moving() if is_moving else self.nodes_at_rest()
        self._make(make_map, nodes)
        if not is_moving and self.nodes_at_rest() > _MUCH_FINER * nodes:
            self._make(make_map, self.nodes_at_rest())

    def nodes_while_moving(self):
        """Nodes of a map that is replaced at once."""
        return self._nodes(_MOVING, _FEW, _MANY)

    def nodes_at_rest(self):
        """Nodes of a map that stays."""
        return self._nodes(_RESTING, _MANY, self._most)

    def _make(self, make_map, nodes):
        started = time.perf_counter()
        make_map(nodes)
        self.nodes, self.map_seconds = nodes, time.perf_counter() - started

    def _nodes(self, seconds, fewest, most):
        if self.map_seconds == 0:
            return most
        return int(np.clip((seconds / self.map_seconds) ** (1 / 3) * self.nodes, fewest, most))
