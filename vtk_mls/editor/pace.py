"""How fine maps and pictures are, so that the mouse is followed."""

from __future__ import annotations

import numpy as np

from vtk_mls.rendering.ray_spacing import pixels_per_ray

_MOVING, _RESTING = 0.06, 0.7  # seconds that a map may take
_FEW, _MANY, _MOST = 24, 64, 96  # nodes along the longest side
_MOVING_PICTURE, _RESTING_PICTURE = 0.06, 2.0  # seconds that a picture may take
_SAVED_PICTURE = 20.0
_COARSEST, _COARSEST_AT_REST = 8.0, 3.0  # pixels for a ray along both axes


class Pace:
    """Chooses the nodes of maps, and pixels for a ray, by what the last ones took.

    Attributes
    ----------
    map_seconds, picture_seconds : float
        Of the last ones.
    nodes : int
        Of the last map.
    """

    def __init__(self):
        self.map_seconds, self.picture_seconds, self.nodes = 0.0, 0.0, _MANY
        self._per_node, self._full_picture = None, np.inf

    def note_map(self, nodes, seconds):
        """Tell how long a map took."""
        self.nodes, self.map_seconds = nodes, seconds
        self._per_node = seconds / nodes**3

    def note_picture(self, pixels, seconds):
        """Tell how long a picture took with a ray for so many pixels along both axes."""
        self.picture_seconds = seconds
        self._full_picture = seconds * pixels**2

    def nodes_while_moving(self):
        """Nodes of a map that is replaced at once."""
        return self._nodes(_MOVING, _FEW, _MANY)

    def nodes_at_rest(self):
        """Nodes of a map that stays."""
        return self._nodes(_RESTING, _MANY, _MOST)

    def pixels_while_moving(self):
        """Pixels for a ray along both axes."""
        return pixels_per_ray(self._full_picture, _MOVING_PICTURE, _COARSEST)

    def pixels_at_rest(self):
        """Likewise, of a picture that stays: above 1 only where graphics are slow."""
        return pixels_per_ray(self._full_picture, _RESTING_PICTURE, _COARSEST_AT_REST)

    def pixels_for_file(self):
        """Likewise, of a picture that is saved."""
        return pixels_per_ray(self._full_picture, _SAVED_PICTURE, _COARSEST_AT_REST)

    def _nodes(self, seconds, fewest, most):
        if self._per_node is None:
            return _MANY
        return int(np.clip((seconds / self._per_node) ** (1 / 3), fewest, most))
