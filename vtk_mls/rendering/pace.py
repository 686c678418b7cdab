"""Resolution of maps and pictures while the mouse moves, from the time the last one took."""

import time

import numpy as np

_MOVING_MAP_SECONDS, _RESTING_MAP_SECONDS = 0.04, 0.7
_MIN_NODES, _USUAL_NODES = 24, 64  # along the longest side
_REDO_RATIO = 1.25  # of possible to used nodes, from which on a map at rest is computed again
_PICTURE_SECONDS = 0.04  # for a picture while the scene moves
_MAX_PIXELS_PER_RAY = 4.0
_MIN_MOVING_RATE = 1.0  # pictures per second that a window requests while it moves


class MapPace:
    """Chooses the resolution of maps, and of pictures, from the time that the last ones took.

    Maps at rest have at most `max_nodes` along the longest side. The last map has taken
    `map_seconds` with `nodes`, the last picture `picture_seconds`.
    """

    def __init__(self, max_nodes):
        self.map_seconds, self.nodes, self._max_nodes = 0.0, _USUAL_NODES, max_nodes
        self.picture_seconds, self._full_seconds = 0.0, np.inf

    def note_picture(self, pixels, seconds):
        """Record the time of a picture with one ray for `pixels` pixels along both axes."""
        self.picture_seconds, self._full_seconds = seconds, seconds * pixels**2

    def pixels(self, limits):
        """`pixels_per_ray` within the limits: seconds, and pixels at most."""
        return pixels_per_ray(self._full_seconds, *limits)

    def make(self, make_map, is_moving):
        """Call `make_map(nodes)` with the number of nodes that time allows.

        A map at rest is computed again if time allows many more nodes: the map before may have
        waited for its kernel to be built, or for a busy machine.
        """
        if is_moving:
            self._make(make_map, self._nodes(_MOVING_MAP_SECONDS, _MIN_NODES, _USUAL_NODES))
            return
        nodes = self.nodes_at_rest()
        self._make(make_map, nodes)
        if self.nodes_at_rest() > _REDO_RATIO * nodes:
            self._make(make_map, self.nodes_at_rest())

    def nodes_at_rest(self):
        """Nodes of a map at rest."""
        return self._nodes(_RESTING_MAP_SECONDS, _USUAL_NODES, self._max_nodes)

    def _make(self, make_map, nodes):
        start = time.perf_counter()
        make_map(nodes)
        self.nodes, self.map_seconds = nodes, time.perf_counter() - start

    def _nodes(self, seconds, min_nodes, max_nodes):
        if self.map_seconds == 0:
            return max_nodes
        nodes = (seconds / self.map_seconds) ** (1 / 3) * self.nodes
        return int(np.clip(nodes, min_nodes, max_nodes))


def adjust_rays(mapper, window):
    """Before a picture: a ray for each pixel when the window rests, fewer while it moves.

    How many follows from the time of the last picture. Steps along rays stay the same, so that
    colors and opacities do: the vtkGPUVolumeRayCastMapper must not adjust them automatically.
    """
    pixels = 1.0
    if window.GetDesiredUpdateRate() >= _MIN_MOVING_RATE:
        seconds = mapper.GetTimeToDraw() or np.inf  # the first picture may take a minute
        full = seconds * mapper.GetImageSampleDistance() ** 2
        pixels = pixels_per_ray(full, _PICTURE_SECONDS, _MAX_PIXELS_PER_RAY)
    mapper.SetImageSampleDistance(pixels)


def pixels_per_ray(seconds, limit, max_pixels):
    """Pixels per ray along each axis, an integer, as VTK rebuilds its shader at each change.

    `seconds` are those of a picture with a ray per pixel, inf if unknown, `limit` those of this.
    """
    return float(np.clip(np.ceil(np.sqrt(seconds / limit)), 1, max_pixels))


def usual_step(image):
    """Distance of samples along rays in VTK's smart mapper at rest, world units."""
    voxels = np.prod(np.array(image.GetDimensions()) - 1.0) ** 0.333
    return np.mean(image.GetSpacing()) / 2 * min(1, 0.01 + 0.99 * voxels / 100)
