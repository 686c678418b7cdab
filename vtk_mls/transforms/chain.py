"""Chains of transforms."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from vtk_mls.base.progress import SILENT
from vtk_mls.base.validation import freeze, short_repr
from vtk_mls.queries.transform import Transform
from vtk_mls.transforms.pointwise import PointwiseTransform


@dataclass(frozen=True, eq=False, init=False)
class Chain(PointwiseTransform):
    """Transforms one after the other; a chain answers the questions of each of them.

    The first is applied first to the material, so that the backward map of ``Chain([a, b])`` is
    ``a.backward(b.backward(v))``. Each transform lives in the space that the ones before it lead
    to: in the example, the rest positions, cuts in the rest frame and grids of b are in the space
    between.

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
    the units of the space where that transform acts.
    """

    transforms: tuple[Transform, ...]

    def __init__(self, transforms: Iterable[Transform]) -> None:
        try:
            members = tuple(transforms)
        except TypeError:
            members = (transforms,)
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
            device=devices[-1] if devices else None,
        )

    def origins(self, points, progress):
        for member, part in self._backward(progress):
            points = member._engine.backward(member, points, part)
        return points

    def jacobians(self, points, progress):
        result = None
        for member, part in self._backward(progress):
            mapping, differentiating = part.divided(1, 2)
            jacobian = member._engine.jacobian(member, points, differentiating)
            result = jacobian if result is None else jacobian @ result
            points = member._engine.backward(member, points, mapping)
        return result

    def search(self, points, progress):
        x = v = points.astype(np.float64)
        found = np.ones(len(x), bool)
        for member, part in zip(self.transforms, progress.divided(*[1] * len(self.transforms))):
            displacement, is_found = member._engine.forward(member, v, part)
            lost = ~np.isfinite(displacement).all(axis=1)  # too far away for a device
            displacement = np.where(lost[:, None] & np.isfinite(v), 0, displacement)
            v, found = v + displacement, found & is_found
        return v - x, found

    def _backward(self, progress=SILENT):
        """The transforms from the last to the first, each with its part of the progress."""
        parts = progress.divided(*[1] * len(self.transforms))
        return zip(self.transforms[::-1], parts)
