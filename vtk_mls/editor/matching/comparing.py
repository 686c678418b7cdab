"""The moving data and the target in the same slices."""

import numpy as np

from vtk_mls.editor.matching.target import CHECKERBOARD, DIFFERENCE
from vtk_mls.editor.slice_pane import colors_of

_TILES = 8  # of the checkerboard along the longest side of the data
# Colors of a difference, 0 to 1: where the moving data are brighter, and where the target is.
_MOVING_COLOR, _TARGET_COLOR = np.array((1.0, 0.6, 0.15)), np.array((0.2, 0.65, 1.0))


class ComparedItem:
    """Images of both sides, items of a `Scene`, as one item of `Slices`.

    The checkerboard divides the box with the corners `bounds` (2, 3).
    """

    def __init__(self, moving, target, comparison, bounds):
        self._sides, self._comparison, self._bounds = (moving, target), comparison, bounds

    def mesh(self):
        """None: meshes are items of their own."""

    def colors_at(self, points):
        """Where points (n, 3) have material of a side, and their colors; None without images."""
        moving, target = (colors_of(items, points) for items in self._sides)
        if moving is None or target is None:
            return target if moving is None else moving
        (has_moving, moving), (has_target, target) = moving, target
        mode, share = self._comparison.mode, self._comparison.share
        if mode == CHECKERBOARD:
            is_target = self._is_target_tile(points)
            has_material = np.where(is_target, has_target, has_moving)
            return has_material, np.where(is_target[:, None], target, moving)
        has_material, moving, target = has_moving | has_target, moving / 1.0, target / 1.0
        if mode == DIFFERENCE:
            colors = difference_colors(moving, target)
        else:
            colors = (1 - share) * moving + share * target
        return has_material, np.rint(colors).astype(np.uint8)

    def _is_target_tile(self, points):
        """Whether each point is in a tile of the target: (n,) bool."""
        size = np.ptp(self._bounds, axis=0).max() / _TILES
        # an odd number of half tiles from the middle, so that no slice there is on an edge
        tiles = np.floor((points - self._bounds.mean(axis=0)) / size + 0.5).astype(int)
        return tiles.sum(axis=1) % 2 == 1


def difference_colors(moving, target):
    """Colors (n, 3) of the difference of two sides (n, 3), all 0 to 255; black where equal."""
    difference = (moving - target).mean(axis=1, keepdims=True)
    more, less = np.clip(difference, 0, None), np.clip(-difference, 0, None)
    return more * _MOVING_COLOR + less * _TARGET_COLOR
