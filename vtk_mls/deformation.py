"""The deformation as a value: validated once, then asked."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls import kinds
from vtk_mls.base import buffer_pool, validation
from vtk_mls.base.grid import Grid, checked_grid, fitted_grid
from vtk_mls.base.linear_algebra import unit
from vtk_mls.base.progress import ProgressLike, whole
from vtk_mls.base.sampling import Sampling
from vtk_mls.base.validation import short_repr
from vtk_mls.cuts import Cut, Obstacle, Plane
from vtk_mls.engine.dispatch import engine_for
from vtk_mls.model import arguments
from vtk_mls.model.options import DEFORMATION_OPTIONS, named
from vtk_mls.model.regions import Region, divided, moved
from vtk_mls.queries import vector_fields, void_cells
from vtk_mls.queries.overlap import overlap
from vtk_mls.queries.void_cells import VoidCells

# Points of a grid whose displacements are in memory though only void distances are wanted.
_SLAB = 1 << 20
_MOST_OBSTACLES = 30  # each has a bit in the kernels


Arguments = ParamSpec("Arguments")
Answer = TypeVar("Answer")


def _quiet(question: Callable[Arguments, Answer]) -> Callable[Arguments, Answer]:
    """A method whose answers may be NaN or infinite, without numpy's warnings of that."""

    @functools.wraps(question)
    def asked(*arguments: Arguments.args, **keywords: Arguments.kwargs) -> Answer:
        with np.errstate(all="ignore"):
            return question(*arguments, **keywords)

    return asked


@dataclass(frozen=True)
class DisplacementField:
    """The displacement map of a deformation on a grid.

    Attributes
    ----------
    displacement : (nz, ny, nx, 3) float32, world units
        G(v) - v at every point v of the grid.
    void_distance : (nz, ny, nx) float32, world units, or None without cuts
        Below 0 where there is nothing because a cut has opened, and continuous on each side of
        every cut: its zero level is the face of the void.
    grid : Grid
        Where the points are.
    """

    displacement: NDArray[np.float32]
    grid: Grid
    void_distance: NDArray[np.float32] | None = None

    @property
    def void(self) -> NDArray[np.bool_]:
        """(nz, ny, nx) bool: where the deformation has opened a void."""
        if self.void_distance is None:
            return np.zeros(self.grid.shape, bool)
        return self.void_distance < 0


@dataclass(frozen=True)
class ForwardField:
    """Where the material at some points goes.

    Attributes
    ----------
    displacement : (m, 3) float32, world units
        v - x for the point v with G(v) = x. Where there is none, v is the point with the smallest
        residual that was found, or x; NaN for points that are not finite.
    found : (m,) bool
        False where there is no inverse: the map folds, or what is at x was pushed through a cut.
    """

    displacement: NDArray[np.float32]
    found: NDArray[np.bool_]


@dataclass(frozen=True, eq=False, repr=False)
class Deformation:
    """A moving-least-squares deformation of space, given by control points.

    The backward map G tells for each point v of the deformed space where its material came from
    (Eq. 2 of the paper). It interpolates the control points, G(q_i) = p_i, and is the identity
    where p = q.

    Parameters
    ----------
    rest : (n, 3) array_like, world coordinates
        p, the control points in the undeformed space.
    deformed : (n, 3) array_like, world coordinates
        q, where they were moved to. Control points with the same q count as one, at their
        weighted mean p.
    kind : {"affine", "rigid", "similarity", "polynomial"}
        The maps that are fitted around each point: affine (Eq. 5 to 7), rotations (Eq. 8 to 22),
        rotations with a uniform factor (end of section 2), polynomials (Eq. 23 to 26).
    alpha : float, > 0
        Weights are ``1 / |q_i - v|^(2 alpha)``: a larger alpha makes control points more local. At
        alpha <= 1/2 the map has a kink at each control point.
    degree : {1, 2, 3}
        Degree of the polynomial kind.
    weights : (n,) array_like, > 0, optional
        Factor on the weight of each control point; all 1 if not given.
    cuts : sequence of Plane, HalfPlane and Surface
        What keeps control points from acting on what is behind (section 4). A side of a Plane
        without control points stays at rest. A control point exactly on a Plane or HalfPlane
        counts on the side of its normal.
    nu : float, > 1
        Damping exponent of Eq. 28: how fast influence fades with the length of the detour.
    cut_frame : {"rest", "deformed"}
        Where the cuts are. "rest": in the undeformed space, as part of the material, which takes
        them along; what acts on material is decided by its own place and the rest positions of
        the control points. "deformed": in the deformed space, where they stay, as the paper has it;
        material that comes to a cut is gone.
    map_tolerance : float, >= 0
        How far displacements on grids may be off, in spacings of the grid; 0 for each point's own.
        Above, `displacement_field`, `resample`, `source_bounds`, `resample_gradients` and
        `corrected_gradient` interpolate them between nodes, every fourth point, in all cells where
        a check finds that close enough: not so near control points and cuts, and on grids of few
        or flat layers. Void distances there keep their sign. The Jacobians that gradients are
        taken through are off by no more from each point to the next.
    device : str, optional
        "gpu" or "cpu" for the first of its kind, "0:1" for platform 0 and device 1, "reference"
        for the float64 numpy specification. If not given: the environment variable
        VTK_MLS_DEVICE, else the first GPU, else the fastest CPU driver.

    Raises
    ------
    ValueError, TypeError
        For a bad argument, naming it.
    DeviceError
        From the questions, if the device cannot be had.

    Notes
    -----
    A set that does not determine a map gets the one nearest to the identity: one control point
    (or several that move alike) translates; control points on a line turn without twist about
    it; on a plane they leave the direction across it as it is; too few for a degree fit only the
    polynomials that they can tell apart.

    Kernels compute in float32, in a local frame, to about 1e-6 of the extent of the control
    points; results of `backward` carry the full digits of `points`.
    """

    rest: NDArray[np.float64]
    deformed: NDArray[np.float64]
    kind: str = named("kind").default
    _: KW_ONLY
    alpha: float = named("alpha").default
    degree: int = named("degree").default
    weights: NDArray[np.float64] = None
    cuts: tuple[Cut, ...] = ()
    nu: float = named("nu").default
    cut_frame: str = named("cut_frame").default
    map_tolerance: float = named("map_tolerance").default
    device: str | None = named("device").default
    regions: tuple[Region, ...] = field(init=False)

    if TYPE_CHECKING:

        def __init__(
            self,
            rest: ArrayLike,
            deformed: ArrayLike,
            kind: str = ...,
            *,
            alpha: float = ...,
            degree: int = ...,
            weights: ArrayLike | None = ...,
            cuts: Cut | Iterable[Cut] | None = ...,
            nu: float = ...,
            cut_frame: str = ...,
            map_tolerance: float = ...,
            device: str | None = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        rest = arguments.control_points("rest", self.rest)
        deformed = arguments.control_points("deformed", self.deformed)
        if len(rest) == 0:
            raise ValueError("`rest` is empty; a deformation needs at least one control point")
        if rest.shape != deformed.shape:
            raise ValueError(
                "`rest` and `deformed` must have the same number of control points, "
                f"got {len(rest)} and {len(deformed)}"
            )
        settings = {
            option.name: option.checked(getattr(self, option.name))
            for option in DEFORMATION_OPTIONS
        }
        weights = arguments.positive_weights(self.weights, len(rest))
        cuts = arguments.cut_shapes(self.cuts)
        planes = [cut for cut in cuts if isinstance(cut, Plane)]
        seen = rest if self.cut_frame == "rest" else deformed
        kind = kinds.named(self.kind, settings["degree"])
        for array in (rest, deformed, weights):
            array.flags.writeable = False
        for name, value in {
            "rest": rest,
            "deformed": deformed,
            "weights": weights,
            "cuts": cuts,
            **settings,
            "regions": divided(planes, seen, (rest, deformed, weights), kind),
        }.items():
            object.__setattr__(self, name, value)
        arguments.check_reach(cuts, self.regions)
        if self.in_rest_frame and len(self.obstacles) > _MOST_OBSTACLES:
            raise ValueError(
                f"`cuts` must have at most {_MOST_OBSTACLES} that one can go round, "
                f"got {len(self.obstacles)}; join surfaces into one"
            )

    def __repr__(self) -> str:
        degree = f", degree={self.degree}" if self.regions[0].control_points.kind.has_degree else ""
        return (
            f"<Deformation {self.kind}{degree}, alpha={self.alpha:g}, "
            f"{len(self.rest)} control points" + (f", {len(self.cuts)} cuts>" if self.cuts else ">")
        )

    @property
    def planes(self) -> list[Plane]:
        """The full cuts, which make the regions."""
        return [cut for cut in self.cuts if isinstance(cut, Plane)]

    @property
    def in_rest_frame(self) -> bool:
        """Whether there are cuts that belong to the material."""
        return bool(self.cuts) and self.cut_frame == "rest"

    @functools.cached_property
    def exchanged_frame(self) -> Deformation:
        """The same for maps with p and q exchanged: their deformed space is the undeformed one."""
        return replace(self, cut_frame="deformed") if self.in_rest_frame else self

    @property
    def has_rivals(self) -> bool:
        """Whether material of several regions may come to the same point."""
        return self.in_rest_frame and bool(self.planes)

    @functools.cached_property
    def moved_planes(self) -> list[Plane]:
        """About where the full cuts are in the deformed space: which region is tried first."""
        if not self.in_rest_frame:
            return self.planes
        return [moved(plane, self.rest, self.deformed) for plane in self.planes]

    @property
    def obstacles(self) -> list[Cut]:
        """The cuts that one can go round."""
        return [cut for cut in self.cuts if isinstance(cut, Obstacle)]

    @_quiet
    def backward(self, points: ArrayLike, progress: ProgressLike = None) -> NDArray[np.float64]:
        """Where the material now at `points` came from: G(v) = l_v^-1(v), Eq. 4 and 26.

        Parameters
        ----------
        points : (m, 3) array_like, world coordinates
        progress : callable, optional
            Called with the fraction done, which grows from 0 to 1; a true answer stops the work.

        Returns
        -------
        (m, 3) float64, world coordinates

        Raises
        ------
        ValueError, DeviceError, Aborted
        """
        points = validation.points("points", points)
        with whole(progress) as progress:
            return self._engine.backward(self, points, progress)

    @_quiet
    def forward(self, points: ArrayLike, progress: ProgressLike = None) -> NDArray[np.float64]:
        """Where the material at `points` goes: the true inverse of `backward`.

        `forward_field` gives the same as displacements, for less time and memory.

        Parameters
        ----------
        points : (m, 3) array_like, world coordinates of the undeformed space
        progress : callable, optional
            As for `backward`.

        Returns
        -------
        (m, 3) float64, world coordinates
            v with G(v) = x to 1e-5 of the extent of the control points, or of the distance from
            them where that is larger. NaN where there is none: where the map folds, or what is at x
            was pushed through a cut, or x is not finite, or so far away that the device's float32
            cannot tell. Where it folds there can be several, and one of them is returned.

        Raises
        ------
        ValueError, DeviceError, Aborted
        """
        points = validation.coordinates(points)
        with whole(progress) as progress:
            displacement, found = self._engine.forward(self, points, progress)
            v = points + displacement.astype(np.float64)
            v[~found] = np.nan
            return v

    @_quiet
    def forward_field(self, points: ArrayLike, progress: ProgressLike = None) -> ForwardField:
        """Displacements of the material at `points`, with those marked that have no inverse.

        G(v) = x is solved by Newton's method with the analytic Jacobian and backtracking. Many
        points at once are solved for by Broyden's method, from first guesses that are interpolated
        on a grid.

        Parameters
        ----------
        points : (m, 3) array_like, world coordinates of the undeformed space
            float32 is taken as it is, all else as float64.
        progress : callable, optional
            As for `backward`.

        Returns
        -------
        ForwardField

        Raises
        ------
        ValueError, DeviceError, Aborted
        """
        points = validation.coordinates(points)
        with whole(progress) as progress:
            displacement, found = self._engine.forward(self, points, progress)
            displacement = displacement.astype(np.float32, copy=False)
            lost = np.flatnonzero(~found)
            lost = lost[np.isfinite(points[lost]).all(axis=1)]
            # too far away for the device's float32
            displacement[lost[~np.isfinite(displacement[lost]).all(axis=1)]] = 0
            return ForwardField(displacement, found)

    @_quiet
    def jacobian(
        self,
        points: ArrayLike,
        progress: ProgressLike = None,
        origins: ArrayLike | None = None,
    ) -> NDArray[np.float64]:
        """dG_i/dv_j at `points`, J_G of Eq. 29, in closed form.

        At a control point it is the linear part of the map fitted there.

        Parameters
        ----------
        points : (m, 3) array_like, world coordinates
        progress : callable, optional
            As for `backward`.
        origins : (m, 3) array_like, world coordinates of the undeformed space, optional
            x = G(v), where it is known. With cuts in the rest frame it tells material at a face
            from that of another side which is there, too.

        Returns
        -------
        (m, 3, 3) float64
        """
        points = validation.points("points", points)
        if origins is not None:
            origins = validation.points("origins", origins)
            if origins.shape != points.shape:
                raise ValueError(
                    f"`origins` must be as many as `points`, got {len(origins)} for {len(points)}"
                )
        with whole(progress) as progress:
            known = origins if self.in_rest_frame else None
            return self._engine.jacobian(self, points, progress, known)

    @_quiet
    def void_distance(
        self, points: ArrayLike, progress: ProgressLike = None
    ) -> NDArray[np.float64]:
        """How far `points` are from being void.

        Below 0 where the segment from a point v to its origin G(v) crosses a cut, so that nothing
        is at v; continuous on each side of every cut. Its zero level is the face of the void.

        Parameters
        ----------
        points : (m, 3) array_like, world coordinates
        progress : callable, optional
            As for `backward`.

        Returns
        -------
        (m,) float64, world units
            Infinite without cuts.
        """
        points = validation.points("points", points)
        with whole(progress) as progress:
            if self.in_rest_frame:
                return self._engine.void_distance(self, points, progress)
            mapping, measuring = progress.divided(3, 1)
            origins = self._engine.backward(self, points, mapping)
            distances = [cut.void_distance(points, origins) for cut in measuring.over(self.cuts)]
            return np.min(distances, axis=0) if distances else np.full(len(points), np.inf)

    def void(self, points: ArrayLike, progress: ProgressLike = None) -> NDArray[np.bool_]:
        """Whether there is nothing at `points` (m, 3) because a cut has opened: (m,) bool."""
        return self.void_distance(points, progress) < 0

    @_quiet
    def overlap(self, points: ArrayLike, progress: ProgressLike = None) -> NDArray[np.bool_]:
        """Whether material from both sides of a cut is at `points`: they are pushed together.

        What `backward` says there is the origin of one of them. Of a Plane that side counts which
        is expected there, so that G(q_i) = p_i does not hold for a control point of the other.

        Parameters
        ----------
        points : (m, 3) array_like, world coordinates
        progress : callable, optional
            As for `backward`.

        Returns
        -------
        (m,) bool
            False with cuts in the deformed frame, where material that comes to a cut is gone.
        """
        points = validation.points("points", points)
        with whole(progress) as progress:
            if not self.in_rest_frame:
                return np.zeros(len(points), bool)
            return overlap(self._engine, self, points, progress)

    @_quiet
    def overlap_field(self, grid: Grid, progress: ProgressLike = None) -> NDArray[np.bool_]:
        """`overlap` on a grid, (nz, ny, nx) bool."""
        result = np.zeros(checked_grid("grid", grid).shape, bool)
        with whole(progress) as progress:
            starts = range(0, grid.size, _SLAB)
            for start, part in zip(starts, progress.divided(*[1] * len(starts))):
                points = grid.points(start, min(start + _SLAB, grid.size))
                result.reshape(-1)[start : start + _SLAB] = self.overlap(points, part)
            return result

    @_quiet
    def displacement_field(
        self,
        dimensions: ArrayLike | Grid,
        origin: ArrayLike = (0, 0, 0),
        spacing: ArrayLike = (1, 1, 1),
        direction: ArrayLike | None = None,
        progress: ProgressLike = None,
    ) -> DisplacementField:
        """The displacement map G(v) - v on a grid (section 4 of the paper).

        Parameters
        ----------
        dimensions, origin, spacing, direction
            Of the `Grid`; dimensions (nx, ny, nz). Or only the `Grid`.
        progress : callable, optional
            As for `backward`.

        Returns
        -------
        DisplacementField
        """
        grid = dimensions
        if not isinstance(grid, Grid):
            grid = Grid(dimensions, origin, spacing, direction)
        with whole(progress) as progress:
            displacement, void_distance = self._engine.displacement_field(self, grid, progress)
            return DisplacementField(displacement, grid, void_distance)

    @_quiet
    def void_distance_field(self, grid: Grid, progress: ProgressLike = None) -> NDArray[np.float32]:
        """`void_distance` on a grid, for the memory of the result alone.

        Parameters
        ----------
        grid : Grid
        progress : callable, optional
            As for `backward`.

        Returns
        -------
        (nz, ny, nx) float32, world units
            Infinite without cuts.
        """
        void_distance = np.full(checked_grid("grid", grid).shape, np.inf, np.float32)
        with whole(progress) as progress:
            for part, values in self._void_distance_slabs(grid, progress):
                void_distance[part] = values
            return void_distance

    @_quiet
    def void_field(self, grid: Grid, progress: ProgressLike = None) -> NDArray[np.bool_]:
        """`void` on a grid, (nz, ny, nx) bool, as `void_distance_field`."""
        void = np.zeros(checked_grid("grid", grid).shape, bool)
        with whole(progress) as progress:
            for part, values in self._void_distance_slabs(grid, progress):
                np.less(values, 0, out=void[part])
            return void

    @_quiet
    def void_of_cells(
        self,
        grid: Grid,
        void_distance: NDArray[np.float32] | None = None,
        progress: ProgressLike = None,
    ) -> VoidCells:
        """Which cells between the points of a grid are void.

        The map is asked for the centres of those only that are near a face of the void.

        Parameters
        ----------
        grid : Grid
        void_distance : (nz, ny, nx) float32, world units, optional
            The `void_distance_field` of the grid, where it is known already.
        progress : callable, optional
            As for `backward`.

        Returns
        -------
        VoidCells
            For the centres and the corners of the `Grid.cells` of `grid`.

        Raises
        ------
        ValueError, TypeError, DeviceError, Aborted
        """
        checked_grid("grid", grid)
        with whole(progress) as progress:
            measuring, looking = progress.divided(1, 1)
            if void_distance is None:
                void_distance = self.void_distance_field(grid, measuring)
            void_distance = np.ascontiguousarray(void_distance, np.float32)
            if void_distance.shape != grid.shape:
                raise ValueError(
                    f"`void_distance` must have the shape of the grid, {grid.shape}, "
                    f"got {void_distance.shape}"
                )
            return void_cells.of_cells(self, self._engine, grid, void_distance, looking)

    def _void_distance_slabs(self, grid, progress):
        """Slices along z of a grid, and the void distance there, to the bit that of the whole."""
        if not self.cuts:
            return
        nx, ny, nz = grid.dimensions
        step = max(1, _SLAB // (nx * ny))
        lows = range(0, nz, step)
        for low, part in zip(lows, progress.divided(*[1] * len(lows))):
            high = min(low + step, nz)
            slab = grid.part((0, 0, low), (nx, ny, high - low))
            yield slice(low, high), self._engine.displacement_field(self, slab, part)[1]

    @_quiet
    def jacobian_field(self, grid: Grid, progress: ProgressLike = None) -> NDArray[np.float32]:
        """dG_i/dv_j at the points of a grid, in closed form.

        Parameters
        ----------
        grid : Grid
        progress : callable, optional
            As for `backward`.

        Returns
        -------
        (nz, ny, nx, 3, 3) float32
            A view of (I + J_D)^T, the paper's extra texture: `swapaxes(-1, -2)` is contiguous.
        """
        checked_grid("grid", grid)
        with whole(progress) as progress:
            return self._engine.jacobian_field(self, grid, progress).swapaxes(-1, -2)

    @_quiet
    def resample(
        self,
        arrays: Sequence[ArrayLike],
        sampling: Sampling | Grid,
        progress: ProgressLike = None,
        void_distance: NDArray[np.float32] | None = None,
    ) -> list[NDArray[Any]]:
        """Deform what `arrays` hold on a grid.

        Parameters
        ----------
        arrays : sequence of (nz, ny, nx) or (nz, ny, nx, components) arrays, any real dtype
        sampling : Sampling or Grid
            Where the values of the arrays are, and for which points they are wanted; a Grid is
            short for `Sampling(grid)`.
        progress : callable, optional
            As for `backward`.
        void_distance : (nz, ny, nx) float32, contiguous, optional
            With the target's shape; is filled with what `void_distance_field` returns, for which
            the map need not be evaluated once more.

        Returns
        -------
        list of arrays
            With the target's shape and the dtypes of `arrays`; integers are rounded to the
            nearest and kept in their range. Where the map is the identity, values are the same
            to the bit.
        """
        sampling = Sampling.of(sampling)
        arrays = _on_grid(arrays, sampling.source)
        sampling.methods(len(arrays))
        _check_background(sampling, arrays)
        distances = self._distances(void_distance, sampling.target)
        with whole(progress) as progress:
            return self._resampled(arrays, sampling, progress, distances)

    @_quiet
    def source_bounds(
        self, sampling: Sampling | Grid, progress: ProgressLike = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Which part of the source the points of the target take their material from.

        Parameters
        ----------
        sampling : Sampling or Grid
        progress : callable, optional
            As for `backward`.

        Returns
        -------
        low, high : (3,) float64
            Bounds of the continuous indices in `source.whole`, without those outside of it; inf
            and -inf if all are.
        """
        sampling = Sampling.of(sampling)
        with whole(progress) as progress:
            low, high = self._engine.source_bounds(self, sampling, progress)
            return low.astype(np.float64), high.astype(np.float64)

    @_quiet
    def resample_gradients(
        self,
        vectors: ArrayLike,
        sampling: Sampling | Grid,
        normalise: bool = False,
        progress: ProgressLike = None,
    ) -> NDArray[np.float32]:
        """Deform covariant vectors, as gradients and normals are: J_G^T n(G(v)), Eq. 29.

        Parameters
        ----------
        vectors : (nz, ny, nx, 3) array, world frame
        sampling : Sampling or Grid
            As for `resample`.
        normalise : bool
            Whether to return unit vectors; the factor det(J_G) of Eq. 29 does not count then, and
            a gradient does not have it.
        progress : callable, optional
            As for `backward`.

        Returns
        -------
        (nz, ny, nx, 3) float32
            0 outside, and in the void unless values are continued there.
        """
        sampling, vectors = Sampling.of(sampling), validation.single_precision("vectors", vectors)
        if vectors.shape != (*sampling.source.shape, 3):
            raise ValueError(
                "`vectors` must have the shape of the grid, "
                f"{(*sampling.source.shape, 3)}, got {vectors.shape}"
            )
        sampling.methods(1)
        with whole(progress) as progress:
            return self._resampled([vectors], sampling, progress, covariant={0: normalise})[0]

    @_quiet
    def resample_vectors(
        self, vectors: ArrayLike, sampling: Sampling | Grid, progress: ProgressLike = None
    ) -> NDArray[np.float32]:
        """Deform contravariant vectors, as velocities are: J_G^-1 w(G(v)).

        Parameters
        ----------
        vectors : (nz, ny, nx, 3) array, world frame
        sampling : Sampling or Grid
            As for `resample`.
        progress : callable, optional
            As for `backward`.

        Returns
        -------
        (nz, ny, nx, 3) float32
            0 outside, where the map is singular, and in the void unless values are continued there.
        """
        sampling = replace(Sampling.of(sampling), background=0.0)
        vectors = validation.single_precision("vectors", vectors)
        with whole(progress) as progress:
            sampled, mapped, transformed = progress.divided(2, 2, 1)
            (moved,) = self.resample([vectors], sampling, sampled)
            jacobian = self.jacobian_field(sampling.target, mapped)
            transformed.report(0)
            return vector_fields.contravariant(moved, jacobian)

    @_quiet
    def corrected_gradient(
        self,
        array: ArrayLike,
        sampling: Sampling | Grid,
        normalise: bool = False,
        progress: ProgressLike = None,
    ) -> NDArray[np.float32]:
        """Gradient of the deformed `array`: J_G^T (grad f)(G(v)) with the analytic Jacobian.

        It follows the deformation exactly, unlike differences of the resampled array. On the
        face of a void it is taken across the face, as the paper has it, unless values are
        continued behind it.

        Parameters
        ----------
        array : (nz, ny, nx) array
        sampling : Sampling or Grid
            As for `resample`.
        normalise : bool
            Whether to return unit vectors.
        progress : callable, optional
            As for `backward`.

        Returns
        -------
        (nz, ny, nx, 3) float32, per world unit
            0 outside, and in the void unless values are continued there.
        """
        return self.resample_with_gradient([], array, sampling, normalise, progress)[1]

    @_quiet
    def resample_with_gradient(
        self,
        arrays: Sequence[ArrayLike],
        array: ArrayLike,
        sampling: Sampling | Grid,
        normalise: bool = False,
        progress: ProgressLike = None,
        void_distance: NDArray[np.float32] | None = None,
    ) -> tuple[list[NDArray[Any]], NDArray[np.float32]]:
        """What `resample` makes of `arrays` and `corrected_gradient` of `array`, in one pass.

        Parameters
        ----------
        arrays : sequence of (nz, ny, nx) or (nz, ny, nx, components) arrays, any real dtype
        array : (nz, ny, nx) array
        sampling : Sampling or Grid
            As for `resample`. Of an interpolation for each, that of the gradient is the last.
        normalise : bool
            Whether gradients are unit vectors.
        progress : callable, optional
            As for `backward`.
        void_distance : (nz, ny, nx) float32, contiguous, optional
            As for `resample`.

        Returns
        -------
        arrays : list of arrays
        gradient : (nz, ny, nx, 3) float32, per world unit
        """
        sampling, array = Sampling.of(sampling), np.asarray(array)
        source = sampling.source
        if array.dtype.kind not in "biuf" or array.shape != source.shape:
            raise ValueError(
                f"`array` must be real numbers with the shape of the grid, {source.shape}, "
                f"got {short_repr(array)}"
            )
        arrays = _on_grid(arrays, source)
        methods = sampling.methods(len(arrays) + 1)
        _check_background(sampling, arrays)
        distances = self._distances(void_distance, sampling.target, is_needed=True)
        with whole(progress) as progress:
            differences, sampled, at_faces = progress.divided(1, 4, 2)
            slopes = self._engine.gradient(validation.native_array(array), source, differences)
            *results, gradient = self._resampled(
                [*arrays, slopes], sampling, sampled, distances, {len(arrays): normalise}
            )
            if self.cuts and not sampling.continues:
                near, values = vector_fields.near_faces(
                    self._engine,
                    self,
                    distances,
                    (_as_floats(array), slopes),
                    replace(sampling, interpolation=methods[-1]),
                    at_faces,
                )
                gradient.reshape(-1, 3)[near] = unit(values) if normalise else values
            return results, gradient

    @_quiet
    def fitted_grid(self, source: Grid, progress: ProgressLike = None) -> Grid:
        """The grid in line with `source` that holds all of the deformed volume.

        Parameters
        ----------
        source : Grid
            Of the undeformed volume.
        progress : callable, optional
            As for `backward`.

        Returns
        -------
        Grid
            With the spacing and direction of `source`.
        """
        checked_grid("source", source)
        with whole(progress) as progress:
            return fitted_grid(self, source, progress)

    def _distances(self, void_distance, target, is_needed=False):
        """An argument to be filled with void distances: (target.size,) float32.

        None if it is not given, unless it is needed and there are cuts.
        """
        if void_distance is None:
            is_needed &= bool(self.cuts)
            return buffer_pool.empty(target.size, np.float32) if is_needed else None
        validation.output_array("void_distance", void_distance, target.shape, np.float32)
        if not self.cuts:
            void_distance.fill(np.inf)
        return void_distance.reshape(-1)

    def _resampled(self, arrays, sampling, progress, distances=None, covariant=None):
        """What the engine makes of `arrays`, in their own types."""
        values = [validation.native_array(array) for array in arrays]
        results = self._engine.resample(self, values, sampling, progress, distances, covariant)
        return [new.astype(old.dtype, copy=False) for new, old in zip(results, arrays)]

    @property
    def _engine(self):
        return engine_for(self.device)


def _as_floats(array):
    """An array as float32 if that holds all values of its type, else as float64."""
    return validation.native_array(array).astype(
        np.promote_types(array.dtype, np.float32), copy=False
    )


def _check_background(sampling, arrays):
    """Warn of arrays that cannot hold the background."""
    sampling.warn_of_background({f"array {i}": array.dtype for i, array in enumerate(arrays)})


def _on_grid(arrays, grid):
    """The argument `arrays`, which hold numbers at the points of a grid."""
    arrays, shape = [np.asarray(array) for array in arrays], grid.shape
    for array in arrays:
        if array.ndim not in (3, 4) or array.shape[:3] != shape:
            raise ValueError(
                f"`arrays` must have the shape of the grid, {shape} or "
                f"{(*shape, 'components')}, got {array.shape}"
            )
        if array.dtype.kind not in "iuf" or array.dtype.itemsize > 8:
            raise TypeError(f"`arrays` must hold integers or floats, got {array.dtype}")
    return arrays
