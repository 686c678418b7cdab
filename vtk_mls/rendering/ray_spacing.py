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
            # the first picture, of which nothing is known, may take a minute
            seconds = mapper.GetTimeToDraw() or np.inf
            full = seconds * mapper.GetImageSampleDistance() ** 2
            pixels = pixels_per_ray(full, _SECONDS, _COARSEST)
        mapper.SetImageSampleDistance(pixels)


def pixels_per_ray(seconds, limit, coarsest):
    """Pixels for a ray along both axes, of a picture that may not take longer than a limit.

    Parameters
    ----------
    seconds : float
        That a picture with a ray for each pixel takes; inf if nobody knows.
    limit : float
        Seconds.
    coarsest : float

    Returns
    -------
    float
        A whole number: with each change VTK makes its shader anew.
    """
    return float(np.clip(np.ceil(np.sqrt(seconds / limit)), 1, coarsest))


def usual_step(image):
    """Distance of samples along rays that VTK's smart mapper takes at rest, in world units."""
    voxels = np.prod(np.array(image.GetDimensions()) - 1.0) ** 0.333
    return np.mean(image.GetSpacing()) / 2 * min(1, 0.01 + 0.99 * voxels / 100)
