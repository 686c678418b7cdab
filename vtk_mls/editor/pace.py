"""How fine maps and pictures are, so that the mouse is followed."""

from __future__ import annotations

import numpy as np

from vtk_mls.rendering.pace import MapPace, pixels_per_ray

_MOST = 96  # nodes along the longest side
_MOVING_PICTURE, _RESTING_PICTURE = 0.06, 2.0  # seconds that a picture may take
_SAVED_PICTURE = 20.0
_COARSEST, _COARSEST_AT_REST = 8.0, 3.0  # pixels for a ray along both axes


class Pace(MapPace):
    """Chooses pixels for a ray, too.

    Attributes
    ----------
    picture_seconds : float
        Of the last one.
    """

    def __init__(self):
        super().__init__(_MOST)
        self.picture_seconds, self._full_picture = 0.0, np.inf

    def note_picture(self, pixels, seconds):
        """Tell how long a picture took with a ray for so many pixels along both axes."""
        self.picture_seconds = seconds
        self._full_picture = seconds * pixels**2

    def pixels_while_moving(self):
        """Pixels for a ray along both axes."""
        return pixels_per_ray(self._full_picture, _MOVING_PICTURE, _COARSEST)

    def pixels_at_rest(self):
        """Likewise, of a picture that stays: above 1 only where graphics are slow."""
        return pixels_per_ray(self._full_picture, _RESTING_PICTURE, _COARSEST_AT_REST)

    def pixels_for_file(self):
        """Likewise, of a picture that is saved."""
        return pixels_per_ray(self._full_picture, _SAVED_PICTURE, _COARSEST_AT_REST)
