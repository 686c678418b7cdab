"""How the deformation distorts space: colors of the change of volume, and a deformed grid."""

import numpy as np

from vtk_mls.rendering.rest_lines import RestLines
from vtk_mls.rendering.surfaces import material_at
from vtk_mls.rendering.volume_colors import tinted

MODES = "nothing", "deformed grid", "change of volume", "grid and volume"
# The message for each mode.
TEXTS = (
    "The grid and the colors of the volume are hidden.",
    "A grid of cubes, deformed with the data.",
    "Orange: the volume grows. Blue: it shrinks. Red: space folds.",
    "A deformed grid, and the change of volume; red where space folds.",
)
_CUBES = 12  # of the grid along the longest side of the data


class Distortion:
    """How the distortion by the current deformation is drawn, over `bounds` (2, 3) of data at rest.

    `mode` is an index in `MODES`, `lines` are `RestLines`, and `deformation` is None for the
    identity.
    """

    def __init__(self, bounds):
        self.mode, self.lines, self.deformation = 0, RestLines.over(bounds, _CUBES), None

    @property
    def has_grid(self):
        """Whether the grid is shown."""
        return "grid" in MODES[self.mode]

    @property
    def has_colors(self):
        """Whether the change of volume is shown."""
        return "volume" in MODES[self.mode]

    def tinted(self, points, colors):
        """Colors (n, 3), 0 to 255, at points (n, 3) of a slice, tinted by the change of volume."""
        if not self.has_colors or self.deformation is None:
            return colors
        origins, has_material = material_at(self.deformation, points)
        rows = np.flatnonzero(has_material & self.lines.covers(self.lines.coordinates(origins)))
        result = colors.copy()
        jacobian = self.deformation.jacobian(points[rows], origins=origins[rows])
        result[rows] = tinted(colors[rows], np.linalg.det(jacobian))
        return result

    def lines_in(self, axis, grid):
        """Segments (m, 2, 3) of the grid in a slice, as of `RestLines.in_slice`."""
        if not self.has_grid:
            return np.zeros((0, 2, 3))
        return self.lines.in_slice(axis, grid, *material_at(self.deformation, grid.points()))
