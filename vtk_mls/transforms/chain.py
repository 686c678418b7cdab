"""Chains of transforms."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from vtk_mls.base.linear_algebra import finite, unit
from vtk_mls.base.progress import SILENT
from vtk_mls.base.validation import freeze, short_repr
from vtk_mls.queries.transform import Transform
from vtk_mls.transforms.pointwise import PointwiseTransform


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Chain(PointwiseTransform):
    """Transforms one after the other; a chain answers the questions of each of them.

    The first is applied first to the material, so that the backward map of ``Chain([a, b])`` is
    ``a.backward(b.backward(v))``. In the space between are the deformed positions and the grid of
    a, and the rest positions and the cuts in the rest frame of b.

    Parameters
    ----------
    transforms : sequence of Deformation, Affine, Field and Chain

    Attributes
    ----------
    transforms : tuple
    cuts : tuple of cuts
        Those of all transforms.

    Raises
    ------
    ValueError, TypeError
        Without a transform, or for what is none.

    Notes
    -----
    The last transform is evaluated on grids as it is by itself, with its `map_tolerance`; the
    others at every point. Inverses are those of the transforms: exact where they are affine. A
    point is in the void if it is in that of a transform; its `void_distance` is the smallest, in
    the units of the space where that transform acts. `jacobian` does not need `origins`.
    """

    transforms: tuple[Transform, ...]

    def __init__(self, transforms: Transform | Iterable[Transform]) -> None:
        members = tuple(transforms) if isinstance(transforms, Iterable) else (transforms,)
        for member in members:
            if not isinstance(member, Transform):
                raise TypeError(
                    "`transforms` must be Deformations, Affines, Fields and Chains, "
                    f"got {short_repr(member)}"
                )
        if not members:
            raise ValueError("`transforms` is empty; a chain needs at least one transform")
        devices = [member.device for member in members if member.device is not None]
        freeze(
            self,
            transforms=members,
            cuts=tuple(cut for member in members for cut in member.cuts),
            in_rest_frame=any(member.in_rest_frame for member in members),
            device=devices[-1] if devices else None,
        )

    def __repr__(self) -> str:
        return f"<Chain of {', '.join(map(repr, self.transforms))}>"

    def _origins(self, points, progress):
        for member, part in progress.parts(self.transforms[::-1]):
            points = member._engine.backward(member, points, part)
        return points

    def _jacobians(self, points, progress):
        result = np.eye(3)
        for member, v, part in self._backward(points, progress):
            result = member._engine.jacobian(member, v, part) @ result
        return result

    def _search(self, points, progress):
        x = v = points.astype(np.float64)
        found = np.ones(len(x), bool)
        for member, part in progress.parts(self.transforms):
            displacement, is_found = member._engine.forward(member, v, part)
            is_too_far = ~np.isfinite(displacement).all(axis=1)  # too far away for a device
            displacement = np.where(is_too_far[:, None] & np.isfinite(v), 0, displacement)
            v, found = v + displacement, found & is_found
        return v - x, found

    def _on_grid(self, grid, points, progress, with_jacobian):
        last, others = self.transforms[-1], self.transforms[:-1]
        mapping, rest = progress.divided(1, len(others))
        points, distance, jacobian = last._on_grid(grid, points, mapping, with_jacobian)
        if not others:
            return points, distance, jacobian
        chain = Chain(others)
        origins, voids, slopes = rest.divided(1, bool(chain.cuts), 2 * with_jacobian)
        if chain.cuts:
            other = chain._void_distance(points, voids)
            distance = other if distance is None else np.minimum(distance, other)
        if with_jacobian:
            jacobian = chain._jacobians(points, slopes) @ jacobian
        return chain._origins(points, origins), distance, jacobian

    def _prepare(self, grid, progress):
        return self.transforms[-1]._prepare(grid, progress)

    def _field(self, grid, progress):
        return super()._field(grid, self._prepare(grid, progress))

    def _backward(self, points, progress):
        """The transforms from the last to the first, the points v of each, and a progress."""
        for i, (member, part) in enumerate(progress.parts(self.transforms[::-1]), start=1):
            answering, mapping = part.divided(2, 1)
            yield member, points, answering
            if i < len(self.transforms):
                points = member._engine.backward(member, points, mapping)

    def _void_distance(self, points, progress=SILENT):
        distance = np.full(len(points), np.inf)
        for member, v, part in self._backward(points, progress):
            if member.cuts:
                distance = np.minimum(distance, member._void_distance(v, part))
        return distance

    def _overlap(self, points, progress):
        found = np.zeros(len(points), bool)
        for member, v, part in self._backward(points, progress):
            if member.cuts:
                found |= member._overlap(v, part)
        return found

    def _nearest_face(self, points, origins):
        steps = [(member, v) for member, v, _ in self._backward(points, SILENT)][::-1]
        nearest, direction = np.full(len(points), np.inf), np.zeros_like(points)
        x, to_first = origins, np.eye(3)  # Jacobian of the transforms before this one
        for member, v in steps:
            if member.cuts:
                distance, away = member._nearest_face(v, x)
                rows = np.flatnonzero(distance < nearest)
                nearest[rows] = distance[rows]
                back = np.linalg.pinv(finite(np.broadcast_to(to_first, (len(v), 3, 3))[rows]))
                # normals are covariant
                direction[rows] = unit(np.einsum("mji,mj->mi", back, away[rows]))
            to_first = to_first @ member._engine.jacobian(member, v, SILENT)
            x = v
        return nearest, direction


def members_of(transform: Transform) -> list[Transform]:
    """The transforms that a transform consists of, without chains; TypeError if it is none."""
    if isinstance(transform, Chain):
        return [member for part in transform.transforms for member in members_of(part)]
    if not isinstance(transform, Transform):
        raise TypeError(
            "`transform` must be a Deformation, Affine, Field or Chain, "
            f"got {short_repr(transform)}"
        )
    return [transform]
