"""The validated parameters of a deformation."""

from __future__ import annotations

import functools
from collections.abc import Iterable
from dataclasses import dataclass, field, fields, replace
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.errors import InputError
from vtk_mls.base.validation import freeze, same_count, short_repr, values_of
from vtk_mls.model import arguments, kinds, limits
from vtk_mls.model.cuts import Cut, Obstacle, Plane
from vtk_mls.model.handles.handle import Handle
from vtk_mls.model.handles.handle_set import HandleSet
from vtk_mls.model.kinds.splines import MIN_LANDMARKS
from vtk_mls.model.options import DEFORMATION_OPTIONS, named, with_kind
from vtk_mls.model.regions import Region, deformed_plane, split_by_planes

Parameters = TypeVar("Parameters", bound="MapParameters")
_MAX_OBSTACLES = 30  # each has a bit in the kernels


@dataclass(frozen=True, eq=False, repr=False, init=False)
class MapParameters:
    """Control points, cuts and options of a map, as `Deformation` documents them."""

    rest: NDArray[np.float64]
    deformed: NDArray[np.float64]
    weights: NDArray[np.float64]
    kind: str
    alpha: float
    smoothing: float
    degree: int
    order: int
    softening: float
    steps: int
    path: NDArray[np.float64]
    handles: tuple[Handle, ...]
    cuts: tuple[Cut, ...]
    mask: limits.Mask | None
    constraints: tuple[limits.FixedFace, ...]
    nu: float
    cut_frame: str
    map_tolerance: float
    device: str | None
    limits: tuple[limits.Limit, ...] = field(init=False)  # the mask, then the constraints
    handle_set: HandleSet = field(init=False)  # points and handles together
    regions: tuple[Region, ...] = field(init=False)  # between the planes

    def __init__(
        self,
        rest: ArrayLike = (),
        deformed: ArrayLike = (),
        kind: str = named("kind").default,
        *,
        alpha: float = named("alpha").default,
        smoothing: float | str = named("smoothing").default,
        degree: int = named("degree").default,
        order: int | str = named("order").default,
        softening: float | str = named("softening").default,
        steps: int | str = named("steps").default,
        path: ArrayLike | None = None,
        weights: ArrayLike | None = None,
        handles: Handle | Iterable[Handle] | None = (),
        cuts: Cut | Iterable[Cut] | None = (),
        mask: limits.Mask | None = None,
        constraints: limits.FixedFace | Iterable[limits.FixedFace] | None = (),
        nu: float = named("nu").default,
        cut_frame: str = named("cut_frame").default,
        map_tolerance: float = named("map_tolerance").default,
        device: str | None = named("device").default,
    ) -> None:
        given = locals()
        p = arguments.control_points("rest", rest)
        q = arguments.control_points("deformed", deformed)
        shaped = values_of("handles", handles, Handle)
        if len(p) == 0 and not shaped:
            raise InputError(
                "is empty; a deformation needs at least one control point", argument="rest"
            )
        same_count(p, q, "control points")
        settings = {item.name: item.checked(given[item.name]) for item in DEFORMATION_OPTIONS}
        may_be_spline = len(p) >= MIN_LANDMARKS and not (cuts or arguments.has_regions(shaped))
        settings = with_kind(settings, may_be_spline)
        if settings["kind"] in kinds.KINDS and settings["smoothing"] < 0:  # automatic
            text = f"must be a number from 0 on, got {short_repr(smoothing)}"
            raise InputError(text, argument="smoothing")
        factors = arguments.positive_weights(weights, len(p))
        places = arguments.path(path, len(p))
        shapes = values_of("cuts", cuts, Cut)
        faces = values_of("constraints", constraints, limits.FixedFace)
        if not isinstance(mask, (limits.Mask, type(None))):
            expected = "a BallMask, BoxMask or ImageMask"
            raise TypeError(f"`mask` must be {expected}, got {short_repr(mask)}")
        masks = () if mask is None else (mask,)
        freeze(self, limits=(*masks, *faces), mask=mask, constraints=faces, **settings)
        freeze(self, rest=p, deformed=q, weights=factors, handles=shaped, cuts=shapes, path=places)
        self._find_regions()

    def _find_regions(self):
        """Divide the handles by the cuts."""
        if self.in_rest_frame and len(self.obstacles) > _MAX_OBSTACLES:
            raise InputError(
                f"must have at most {_MAX_OBSTACLES} with an edge, "
                f"got {len(self.obstacles)}; join surfaces into one",
                argument="cuts",
            )
        names = ("degree", "order", "smoothing", "softening")
        kind = kinds.BY_NAME[self.kind](**{name: getattr(self, name) for name in names})
        if not kind.is_local and (self.cuts or arguments.has_regions(self.handles)):
            what = "cuts" if self.cuts else "rigid regions"
            raise InputError(
                f"must be one of {', '.join(kinds.KINDS)} with {what}, got {kind.name!r}; control "
                "points of a spline act everywhere",
                argument="kind",
            )
        in_rest_frame = self.cut_frame == "rest"
        points = self.rest, self.deformed, self.weights
        handle_set = HandleSet.of(*points, self.handles, kind, self.alpha, self.path)
        kind = kind.chosen(handle_set)
        handle_set = handle_set.split_by(self.obstacles, in_rest_frame)
        regions = split_by_planes(
            *(self.planes, handle_set, in_rest_frame, kind),
            has_zero_mean=bool(self.limits) or self.is_stepwise,
        )
        freeze(self, handle_set=handle_set, regions=regions)
        arguments.check_cut_distances(self.cuts, regions)

    def __repr__(self) -> str:
        kind = self.regions[0].control_points.kind
        degree = f", degree={self.degree}" if kind.has_degree else ""
        shape = f"alpha={self.alpha:g}" if kind.is_local else f"order={kind.order}"
        return f"<Deformation {self.kind}{degree}, {shape}, {len(self.rest)} control points" + (
            f", {len(self.cuts)} cuts>" if self.cuts else ">"
        )

    @property
    def is_stepwise(self) -> bool:
        """Whether there may be more than one step."""
        return self.steps != 1 or len(self.path) > 0

    @property
    def steps_used(self) -> int:
        """Number of steps; a multiple of the lines of the path."""
        legs = len(self.path) + 1
        return legs * -(-self.steps // legs)

    def in_steps(self: Parameters, count: int, map_tolerance: float | None = None) -> Parameters:
        """The same map in another number of steps, with the automatic settings that were chosen."""
        if not self.is_stepwise:
            return replace(self, steps=count)
        other = object.__new__(type(self))
        freeze(other, **{item.name: getattr(self, item.name) for item in fields(self)})
        # devices and steps are cached by the objects
        regions = [
            replace(region, control_points=replace(region.control_points))
            for region in self.regions
        ]
        freeze(other, steps=count, regions=tuple(regions))
        if map_tolerance is not None:
            freeze(other, map_tolerance=map_tolerance)
        return other

    @property
    def order_used(self) -> int:
        """The order of the spline; 0 for other kinds."""
        return getattr(self.regions[0].control_points.kind, "order", 0)

    @property
    def smoothing_used(self) -> float:
        """The smoothing, world units, chosen if it is automatic."""
        return getattr(self.regions[0].control_points.kind, "smoothing", self.smoothing)

    @property
    def softening_used(self) -> float:
        """The softening of the spline, world units; 0 for other kinds."""
        return getattr(self.regions[0].control_points.kind, "softening", 0.0)

    @property
    def left_out_errors(self) -> NDArray[np.float64] | None:
        """Distance (n,) from p of each control point to the map of all others, world units.

        Only for splines with automatic settings. Of more than 1,500 points, these are of 1,500.
        """
        left_out = getattr(self.regions[0].control_points.kind, "left_out", None)
        return None if left_out is None else np.linalg.norm(left_out, axis=1)

    @property
    def planes(self) -> list[Plane]:
        """The unbounded cuts, which separate the regions."""
        return [cut for cut in self.cuts if isinstance(cut, Plane)]

    @property
    def obstacles(self) -> list[Obstacle]:
        """The cuts with an edge."""
        return [cut for cut in self.cuts if isinstance(cut, Obstacle)]

    @property
    def in_rest_frame(self) -> bool:
        """Whether there are cuts that move with the material."""
        return bool(self.cuts) and self.cut_frame == "rest"

    @functools.cached_property
    def with_deformed_cuts(self) -> MapParameters:
        """The same parameters with the cuts in the deformed frame."""
        return replace(self, cut_frame="deformed") if self.in_rest_frame else self

    @property
    def void_needs_map(self) -> bool:
        """Whether void distances depend on more than v and G(v)."""
        return bool(self.cuts) and (self.in_rest_frame or self.steps_used > 1)

    @property
    def has_competing_regions(self) -> bool:
        """Whether material of several regions may reach the same point."""
        return self.in_rest_frame and bool(self.planes)

    @functools.cached_property
    def moved_planes(self) -> list[Plane]:
        """The approximate planes in the deformed space, which say which region is tried first."""
        if not self.in_rest_frame:
            return self.planes
        return [deformed_plane(plane, *self.handle_set.positions) for plane in self.planes]


for _option in DEFORMATION_OPTIONS:  # `Deformation.alpha` is the default
    setattr(MapParameters, _option.name, _option.default)
