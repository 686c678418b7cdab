"""How far apart rays are while a picture moves; steps along them stay, so that looks do, too."""

from __future__ import annotations

import numpy as np

_SECONDS = 0.04  # that a picture may take while it moves
_COARSEST = 4.0  # pixels
_MOVING_RATE = 1.0  # pictures a second that are wanted from a window


class RaySpacing:
    """Sets how many pixels apart rays are, by what the last picture took.

    Parameters
    ----------
    mapper : vtkGPUVolumeRayCastMapper
        Its steps along rays must not adjust themselves.
    """

    def __init__(self, mapper):
        self._mapper = mapper

    def adjust(self, window):
        """Before a picture: a ray for each pixel when the window rests, fewer while it moves."""
        mapper, pixels = self._mapper, 1.0
        if window.GetDesiredUpdateRate() >= _MOVING_RATE:
            full = mapper.GetTimeToDraw() * mapper.GetImageSampleDistance() ** 2
            # in whole steps: with each change VTK makes its shader anew
            pixels = float(np.clip(np.ceil(np.sqrt(full / _SECONDS)), 1, _COARSEST))
        mapper.SetImageSampleDistance(pixels)


def usual_step(image):
    """Distance of samples along rays that VTK's smart mapper takes at rest, in world units."""
    voxels = np.prod(np.array(image.GetDimensions()) - 1.0) ** 0.333
    return np.mean(image.GetSpacing()) / 2 * min(1, 0.01 + 0.99 * voxels / 100)
