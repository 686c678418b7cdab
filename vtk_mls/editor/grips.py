"""Grips: the points by which the mouse drags point handles, regions, curves and the mask."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vtk_mls import BallMask, CurveHandle, RegionHandle

POINT, MASK = -1, -2  # owners that are not among the handles
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
    number : (g,) int
        Row of a point handle, node of a curve, PLACE, RADIUS or FALLOFF of the mask.
    anchored : (g,) bool
    """

    rest: np.ndarray
    deformed: np.ndarray
    owner: np.ndarray
    number: np.ndarray
    anchored: np.ndarray

    @classmethod
    def of(cls, state) -> Grips:
        """The grips of a state."""
        parts = [(state.rest, state.deformed, POINT)]
        for index, handle in enumerate(state.handles):
            if isinstance(handle, RegionHandle):
                rest, deformed = (center[None] for center in handle.center)
            else:
                rest, deformed = handle.rest, handle.deformed
            parts.append((rest, deformed, index))
        if state.mask is not None:
            heights = _heights(state.mask)
            positions = state.mask.center + heights[:, None] * _UP
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

    @property
    def are_resting(self):
        """Whether each is at its rest position: (g,) bool."""
        return (self.rest == self.deformed).all(axis=1)

    def rows_of(self, owner):
        """Rows of the grips of an owner."""
        return np.flatnonzero(self.owner == owner)


def names_of(state):
    """Names of the grips, list of str: of points their labels or numbers."""
    names = [label or str(number) for number, label in enumerate(state.labels, 1)]
    for index, handle in enumerate(state.handles, 1):
        if isinstance(handle, RegionHandle):
            names.append(f"rigid {index}")
        else:
            names += [f"curve {index}.{node}" for node in range(1, len(handle.rest) + 1)]
    return names if state.mask is None else [*names, "mask", "mask radius", "mask fall-off"]


def only_region(state, selected):
    """The index of the region that alone is among the `selected` grips; None without one."""
    owner = int(state.grips.owner[selected[0]]) if len(selected) == 1 else POINT
    is_region = owner >= 0 and isinstance(state.handles[owner], RegionHandle)
    return owner if is_region else None


def moved(state, rows, positions):
    """A `State` with grips `rows` at other positions (m, 3); anchored ones stay."""
    grips, rows = state.grips, np.asarray(rows, int)
    rows, positions = _free(grips, rows, np.asarray(positions, float))
    target = grips.deformed.copy()
    target[rows] = positions
    changes = {"deformed": target[: len(state)]}
    owners = {owner for owner in grips.owner[rows].tolist() if owner >= 0}
    if owners:
        changes["handles"] = [
            _moved_handle(handle, target[grips.rows_of(index)]) if index in owners else handle
            for index, handle in enumerate(state.handles)
        ]
    parts = [(grips.number[row], target[row]) for row in rows if grips.owner[row] == MASK]
    if parts:
        changes["mask"] = _moved_mask(state.mask, *min(parts, key=lambda part: part[0]))
    return state.changed(**changes)


def with_rest(state, row, position):
    """A `State` with the rest position (3,) of a grip changed.

    Raises
    ------
    ValueError
        For regions and the mask.
    """
    grips = state.grips
    owner, rest = grips.owner[row], np.array(grips.rest)
    rest[row] = position
    if owner == POINT:
        return state.changed(rest=rest[: len(state)])
    handle = state.handles[owner] if owner >= 0 else None
    if not isinstance(handle, CurveHandle):
        raise ValueError("only points and nodes of curves have a rest position that can be changed")
    return with_handle(state, owner, CurveHandle(rest[grips.rows_of(owner)], handle.deformed))


def with_handle(state, index, handle):
    """A `State` with another region or curve at an index; the last one for None as index."""
    handles = list(state.handles)
    if index is None:
        handles.append(handle)
    else:
        handles[index] = handle
    return state.changed(handles=handles)


def without(state, rows):
    """A `State` without grips `rows`: points, regions, nodes of curves, the mask."""
    grips, rows = state.grips, np.asarray(rows, int)
    owners = grips.owner[rows]
    remaining = np.setdiff1d(np.arange(len(state)), rows)
    handles = []
    for index, handle in enumerate(state.handles):
        nodes = np.setdiff1d(grips.rows_of(index), rows)
        if index not in owners:
            handles.append(handle)
        elif len(nodes) > 1:
            handles.append(CurveHandle(grips.rest[nodes], grips.deformed[nodes]))
    return state.changed(
        rest=state.rest[remaining],
        deformed=state.deformed[remaining],
        weights=None if state.weights is None else state.weights[remaining],
        labels=tuple(state.labels[i] for i in remaining),
        anchored=state.anchored[remaining],
        enabled=state.enabled[remaining],
        handles=handles,
        mask=None if MASK in owners else state.mask,
    )


def _free(grips, rows, positions):
    free = ~grips.anchored[rows]
    return rows[free], positions[free]


def _moved_handle(handle, positions):
    if isinstance(handle, CurveHandle):
        return CurveHandle(handle.rest, positions)
    motion = handle.motion.copy()
    motion[:3, 3] += positions[0] - handle.center[1]
    return RegionHandle(handle.shape, motion)


def _heights(mask):
    """Of the grips of a BallMask over its center: (3,)."""
    return np.array([-mask.radius, mask.radius, mask.radius + mask.falloff])


def _moved_mask(mask, number, position):
    """The mask with one of its grips at a position (3,)."""
    if number == PLACE:
        return BallMask(position - _heights(mask)[PLACE] * _UP, mask.radius, mask.falloff)
    length, least = np.linalg.norm(position - mask.center), _MIN_LENGTH
    if number == RADIUS:
        return BallMask(mask.center, max(length, least * mask.falloff), mask.falloff)
    return BallMask(mask.center, mask.radius, max(length - mask.radius, least * mask.radius))
