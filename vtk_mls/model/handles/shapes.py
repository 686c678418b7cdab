"""Shapes of rigid regions."""

from __future__ import annotations

import functools
import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base import validation
from vtk_mls.base.grid import Grid, checked_grid
from vtk_mls.base.validation import freeze, positive, vector
from vtk_mls.model.handles import distance_image
from vtk_mls.model.handles.distance_image import DistanceImage
from vtk_mls.model.shape_fields import Described, ShapeField


class Shape(Described):
    """A solid of the undeformed space.

    Attributes
    ----------
    image : DistanceImage or None
        Distances, accurate to a fraction of a cell, if the shape has no formula for them. It is
        made at its first use.
    """

    image: DistanceImage | None = None

    @property
    def bounds(self) -> NDArray[np.float64]:
        """Lowest and highest coordinates (2, 3), world coordinates."""
        raise NotImplementedError

    def distance(self, x: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Distances (m,) of `x` (m, 3), 0 inside, and half the gradients of their squares."""
        return self.image.at(x)

    def lattice(self, count: int) -> NDArray[np.float64]:
        """Points (m, 3) over the bounds, `count` along each axis."""
        low, high = self.bounds
        return Grid([count] * 3, low, np.maximum(high - low, 1e-30) / (count - 1)).points()

    def samples(self, count: int) -> NDArray[np.float64]:
        """Points (m, 3) of the shape: the `lattice`, with those outside taken to the surface."""
        points = self.lattice(count)
        return points - self.distance(points)[1]

    def proxies(self, order: int) -> NDArray[np.float64]:
        """Points (k, 3) about the center that determine polynomials of degree `order`.

        They are the principal lattice of a regular tetrahedron, whose second moments are equal.
        """
        low, high = self.bounds
        corners = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]) / 2
        lattice = [x for x in itertools.product(range(order + 1), repeat=4) if sum(x) == order]
        size = (high - low).max() / 2
        return (low + high) / 2 + size * np.array(lattice) @ corners / order


@dataclass(frozen=True, eq=False, init=False)
class Capsule(Shape):
    """The points within `radius` of the segment from `a` to `b`.

    Parameters
    ----------
    a, b : (3,) array_like, world coordinates
    radius : float, > 0, world units
    """

    a: NDArray[np.float64]
    b: NDArray[np.float64]
    radius: float

    name = "capsule"
    fields = ShapeField("a", "point"), ShapeField("b", "point"), ShapeField("radius", "length")

    def __init__(self, a: ArrayLike, b: ArrayLike, radius: float) -> None:
        freeze(self, a=vector("a", a), b=vector("b", b), radius=positive("radius", radius))

    @property
    def bounds(self) -> NDArray[np.float64]:
        ends = np.stack([self.a, self.b])
        return np.stack([ends.min(axis=0) - self.radius, ends.max(axis=0) + self.radius])

    def distance(self, x: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        along = self.b - self.a
        square = along @ along or 1.0
        share = np.clip(np.einsum("mi,i->m", x - self.a, along) / square, 0, 1)
        offset = x - self.a - share[:, None] * along
        length = np.linalg.norm(offset, axis=1)
        distance = np.maximum(length - self.radius, 0)
        factor = np.divide(distance, length, out=np.zeros_like(length), where=length > 0)
        return distance, factor[:, None] * offset


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Ball(Capsule):
    """The points within `radius` of `center`.

    Parameters
    ----------
    center : (3,) array_like, world coordinates
    radius : float, > 0, world units
    """

    name = "ball"
    fields = ShapeField("center", "point"), ShapeField("radius", "length")

    def __init__(self, center: ArrayLike, radius: float) -> None:
        at = vector("center", center)
        freeze(self, a=at, b=at, radius=positive("radius", radius))

    def __repr__(self) -> str:
        return f"Ball(center={self.a}, radius={self.radius})"

    @property
    def center(self) -> NDArray[np.float64]:
        """(3,), world coordinates."""
        return self.a


@dataclass(frozen=True, eq=False, init=False)
class Solid(Shape):
    """The inside of a closed surface.

    Parameters
    ----------
    points : (n, 3) array_like, world coordinates
    triangles : (m, 3) array_like of ints
        Corners of each triangle, as rows of `points`.
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.int64]

    name = "solid"
    fields = ShapeField("points", "rows"), ShapeField("triangles", "rows")

    def __init__(self, points: ArrayLike, triangles: ArrayLike) -> None:
        corners = validation.points("points", points)
        rows = validation.corners("triangles", triangles, 3, len(corners))
        # files such as STL repeat the corners of each triangle
        _, same = np.unique(corners, axis=0, return_inverse=True)
        edges = np.sort(same.ravel()[rows][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges = edges[edges[:, 0] != edges[:, 1]]
        _, count = np.unique(edges, axis=0, return_counts=True)
        open_edges = int((count % 2).sum())
        if open_edges:
            raise ValueError(
                f"`triangles` must be a closed surface, got {open_edges} edges with an open side; "
                "close its holes"
            )
        freeze(self, points=corners, triangles=rows)

    def __repr__(self) -> str:
        return f"Solid({len(self.points)} points, {len(self.triangles)} triangles)"

    @property
    def bounds(self) -> NDArray[np.float64]:
        used = self.points[np.unique(self.triangles)]
        return np.stack([used.min(axis=0), used.max(axis=0)])

    @functools.cached_property
    def image(self) -> DistanceImage:
        return distance_image.of_triangles(self.points, self.triangles)

    def samples(self, count: int) -> NDArray[np.float64]:
        return np.concatenate([self.points, super().samples(count)])


@dataclass(frozen=True, eq=False, init=False)
class Labels(Shape):
    """The voxels of a segmentation.

    Parameters
    ----------
    mask : (nz, ny, nx) array_like of bool or numbers
        Not 0 inside.
    grid : Grid
        Of the mask.
    """

    mask: NDArray[np.bool_]
    grid: Grid

    name = "labels"
    fields = ShapeField("mask", "mask"), ShapeField("grid", "grid")

    def __init__(self, mask: ArrayLike, grid: Grid) -> None:
        checked_grid("grid", grid)
        inside = np.asarray(mask) != 0
        if inside.shape != grid.shape:
            raise ValueError(
                f"`mask` must have the shape {grid.shape} of `grid`, got {inside.shape}; resample "
                "it to that grid"
            )
        if not inside.any():
            raise ValueError("`mask` must have a voxel that is not 0, got none")
        freeze(self, mask=inside, grid=grid)

    def __repr__(self) -> str:
        return f"Labels({int(self.mask.sum())} voxels)"

    @property
    def bounds(self) -> NDArray[np.float64]:
        corners = self._box.corners()
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    @property
    def _box(self):
        """The part of the grid that contains the label."""
        low, high = self._index_bounds
        return self.grid.part(low, high - low + 1)

    @functools.cached_property
    def _index_bounds(self):
        used = [np.flatnonzero(self.mask.any(axis=axes)) for axes in ((0, 1), (0, 2), (1, 2))]
        return np.array([u[0] for u in used]), np.array([u[-1] for u in used])

    @functools.cached_property
    def image(self) -> DistanceImage:
        low, high = self._index_bounds
        part = self.mask[tuple(slice(a, b + 1) for a, b in zip(low[::-1], high[::-1]))]
        return distance_image.of_mask(part, self._box)
