"""Grips: the points by which the mouse drags point handles, regions, curves and the mask."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vtk_mls import BallMask

POINT, MASK = -1, -2  # owners that are not among the handles
NO_ROWS = np.zeros(0, int)
PLACE, RADIUS, FALLOFF = range(3)  # grips of the mask: its lowest and highest points
_UP = np.array((0.0, 0.0, 1.0))
_MIN_LENGTH = 1e-3  # of the radius and the fall-off, relative to their sum


@dataclass(frozen=True, eq=False)
class Grips:
    """The grips of a `State`: point handles come first, then regions and nodes of curves.

    Attributes
    ----------
    rest, deformed : (g, 3) float64, world coordinates
        Of a region, the center of its bounds; of the mask, the same twice.
    owner : (g,) int
        Index of the region or curve among the handles; POINT or MASK.
    part : (g,) int
        Row of a point handle, node of a curve, PLACE, RADIUS or FALLOFF of the mask.
    anchored : (g,) bool
    """

    rest: np.ndarray
    deformed: np.ndarray
    owner: np.ndarray
    part: np.ndarray
    anchored: np.ndarray

    @classmethod
    def of(cls, state) -> Grips:
        """The grips of a state."""
        parts = [(state.rest, state.deformed, POINT)]
        for index, handle in enumerate(state.handles):
            parts.append((*handle.grips, index))
        if state.mask is not None:
            positions = state.mask.center + _heights(state.mask)[:, None] * _UP
            parts.append((positions, positions, MASK))
        counts = [len(rest) for rest, _, _ in parts]
        count = sum(counts[1:])
        return cls(
            np.concatenate([rest for rest, _, _ in parts]),
            np.concatenate([deformed for _, deformed, _ in parts]),
            np.repeat([owner for *_, owner in parts], counts),
            np.concatenate([np.arange(count) for count in counts]),
            np.append(state.anchored, np.zeros(count, bool)),
        )

    def __len__(self):
        return len(self.owner)

    def rows_of(self, owner):
        """Rows of the grips of an owner."""
        return np.flatnonzero(self.owner == owner)


def names_of(state):
    """Names of the grips, list of str: of points their labels or numbers."""
    names = [label or str(number) for number, label in enumerate(state.labels, 1)]
    for index, handle in enumerate(state.handles, 1):
        name, count = f"{handle.title} {index}", len(handle.grips[0])
        names += [name] if count == 1 else [f"{name}.{node + 1}" for node in range(count)]
    return names if state.mask is None else [*names, "mask", "mask radius", "mask fall-off"]


def _heights(mask):
    """Heights (3,) of the grips of a BallMask above its center."""
    return np.array([-mask.radius, mask.radius, mask.radius + mask.falloff])


def moved_mask(mask, part, position):
    """The mask with one of its grips, by its `part`, at a position (3,)."""
    if part == PLACE:
        return BallMask(position - _heights(mask)[PLACE] * _UP, mask.radius, mask.falloff)
    length = np.linalg.norm(position - mask.center)
    if part == RADIUS:
        return BallMask(mask.center, max(length, _MIN_LENGTH * mask.falloff), mask.falloff)
    return BallMask(mask.center, mask.radius, max(length - mask.radius, _MIN_LENGTH * mask.radius))
