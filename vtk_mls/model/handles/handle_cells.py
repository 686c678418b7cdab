"""Handles as cells of points: vertices are points, lines are curves, surfaces are rigid regions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from vtk_mls.base.errors import InputError
from vtk_mls.base.validation import short_repr
from vtk_mls.model.handles.curve import CurveHandle
from vtk_mls.model.handles.handle import Handle
from vtk_mls.model.handles.region import RegionHandle
from vtk_mls.model.handles.rigid_motion import fitted_motion
from vtk_mls.model.handles.shapes import Solid

HANDLE_SHAPES = ("points", "cells")
_RIGID = 1e-4  # largest residual, as a fraction of the size of the surface


@dataclass(frozen=True, eq=False)
class HandleCells:
    """The cells of points that are handles, as rows of the points."""

    vertices: NDArray[np.int64]  # (k,): points that are handles
    lines: tuple[NDArray[np.int64], ...] = ()  # the nodes of each curve
    # (t, 3): of closed surfaces
    triangles: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 3), np.int64))

    @classmethod
    def points(cls, count: int) -> HandleCells:
        """`count` points, each a handle."""
        return cls(np.arange(count))

    @property
    def point_rows(self) -> NDArray[np.int64]:
        """Rows (k,) of the handles that are points, in the order of `handles_of_cells`."""
        return np.unique(self.vertices)

    @property
    def has_shapes(self) -> bool:
        """Whether there are curves or surfaces."""
        return bool(self.lines) or len(self.triangles) > 0

    def of_rows(self, mask: NDArray[np.bool_]) -> HandleCells:
        """The cells of the points in a `mask` (n,); nodes that are not in it are left out."""
        new_row = np.cumsum(mask) - 1
        lines = [new_row[line[mask[line]]] for line in self.lines]
        return HandleCells(
            new_row[self.vertices[mask[self.vertices]]],
            tuple(line for line in lines if len(line)),
            new_row[self.triangles[mask[self.triangles].all(axis=1)]],
        )


def handles_of_cells(
    rest: NDArray[np.float64],
    deformed: NDArray[np.float64],
    weights: NDArray[np.float64] | None,
    cells: HandleCells,
    solids: Sequence[Solid] = (),
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64] | None, list[Handle]]:
    """The rest and deformed positions and weights of handles that are points, and the others.

    Each connected surface is a region; points at the same place connect. Surfaces that are the same
    at rest as one of the `solids` of an earlier call take it: a distance image takes seconds.
    Raises ValueError if a line is no curve, or a surface is open or does not move rigidly.
    """
    handles: list[Handle] = [
        _curve(rest[line], deformed[line], number) for number, line in enumerate(cells.lines)
    ]
    parts = _connected(rest, cells.triangles)
    handles += [_region(rest, deformed, part, n, solids) for n, part in enumerate(parts)]
    rows = cells.point_rows
    return rest[rows], deformed[rows], None if weights is None else weights[rows], handles


def cells_of_handles(
    rest: NDArray[np.float64], deformed: NDArray[np.float64], handles: Sequence[Handle]
) -> tuple[NDArray[np.float64], NDArray[np.float64], HandleCells]:
    """Points (n, 3), at rest and deformed, and their cells: the inverse of `handles_of_cells`.

    Regions must have the shape Solid.
    """
    before, after, lines, triangles = [rest], [deformed], [], []
    count = len(rest)
    for handle in handles:
        if isinstance(handle, CurveHandle):
            before.append(handle.rest)
            after.append(handle.deformed)
            lines.append(count + np.arange(len(handle.rest)))
        elif isinstance(handle.shape, Solid):
            before.append(handle.shape.points)
            after.append(handle.moved(handle.shape.points))
            triangles.append(count + handle.shape.triangles)
        else:
            raise ValueError(
                "`handles` must be curves and regions with the shape Solid, the surface of any "
                f"other, got {short_repr(handle.shape)}"
            )
        count += len(before[-1])
    surface = np.concatenate([np.zeros((0, 3), np.int64), *triangles])
    cells = HandleCells(np.arange(len(rest)), tuple(lines), surface)
    return np.concatenate(before), np.concatenate(after), cells


def _curve(rest, deformed, number):
    try:
        return CurveHandle(rest, deformed)
    except ValueError as error:
        raise InputError(
            f", line {number}, is no curve handle: {error}", argument="ControlPoints"
        ) from error


def _region(rest, deformed, triangles, number, solids):
    """The region of one connected surface, `triangles` (t, 3) of points `rest` (n, 3)."""
    where, named = f", surface {number}, is no rigid region", {"argument": "ControlPoints"}
    used, rows = np.unique(triangles, return_inverse=True)
    surface = rest[used], rows.reshape(-1, 3)
    known = [s for s in solids if all(map(np.array_equal, (s.points, s.triangles), surface))]
    try:
        shape = known[0] if known else Solid(*surface)
    except ValueError as error:
        raise InputError(f"{where}: {error}", **named) from error
    if not np.isfinite(deformed[used]).all():
        raise InputError(f"{where}: its displacements must be finite", **named)
    motion, residual = fitted_motion(rest[used], deformed[used])
    size = float(np.ptp(rest[used], axis=0).max())
    if not residual <= _RIGID * size:
        raise InputError(
            f"{where}: its points must move by one rotation and translation, but the best one "
            f"misses them by up to {residual:.3g}, of a size of {size:.3g}; transform the surface "
            "as a whole",
            **named,
        )
    return RegionHandle(shape, motion)


def _connected(points, triangles):
    """The triangles (t, 3) of each connected surface, a list in the order of their first ones."""
    if len(triangles) == 0:
        return []
    _, same = np.unique(points, axis=0, return_inverse=True)
    corners = same.ravel()[triangles]
    label = np.arange(same.max() + 1)
    while True:  # the lowest point of each surface spreads over it
        lowest = label.copy()
        np.minimum.at(lowest, corners, label[corners].min(axis=1, keepdims=True))
        lowest = lowest[lowest]
        if (lowest == label).all():
            break
        label = lowest
    part = label[corners[:, 0]]
    _, first = np.unique(part, return_index=True)
    return [triangles[part == part[row]] for row in np.sort(first)]
