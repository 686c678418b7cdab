"""The deformation as a value: validated once, then asked."""

from __future__ import annotations

import functools
from dataclasses import KW_ONLY, dataclass, field

import numpy as np

from vtk_mls import arguments, kinds, vector_fields
from vtk_mls.cuts import Obstacle, Plane
from vtk_mls.engine.dispatch import engine_for
from vtk_mls.fitting import fitted_grid
from vtk_mls.grid import Grid
from vtk_mls.reals import shown
from vtk_mls.regions import Region, divided
from vtk_mls.sampling import INTERPOLATIONS

# Points of a grid whose displacements are in memory though only openings are wanted.
_SLAB = 1 << 20


def _quiet(question):
    """A method whose answers may be NaN or infinite, without numpy's warnings of that."""

    @functools.wraps(question)
    def asked(*arguments, **keywords):
        with np.errstate(all="ignore"):
            return question(*arguments, **keywords)

    return asked


class Aborted(RuntimeError):
    """The `progress` callback asked to stop."""


@dataclass(frozen=True)
class DisplacementField:
    """The displacement map of a deformation on a grid.

    Attributes
    ----------
    displacement : (nz, ny, nx, 3) float32, world units
        G(v) - v at every point v of the grid.
    void_distance : (nz, ny, nx) float32, world units, or None without cuts
        Below 0 where there is nothing because a cut has opened, and continuous on each side of
        every cut: its zero level is the face of the opening.
    grid : Grid
        Where the points are.
    """

    displacement: np.ndarray
    grid: Grid
    void_distance: np.ndarray | None = None

    @property
    def void(self):
        """(nz, ny, nx) bool: where the deformation has opened a void."""
        if self.void_distance is None:
            return np.zeros(self.grid.shape, bool)
        return self.void_distance < 0


@dataclass(frozen=True)
class ForwardField:
    """Where the material of some points goes.

    Attributes
    ----------
    displacement : (m, 3) float32, world units
        v - x for the place v with G(v) = x. Where there is none it leads to the best place that was
        found, or is 0; NaN for points that are not finite.
    found : (m,) bool
        False where there is no inverse: the map folds, or what is at x was pushed through a cut.
    """

    displacement: np.ndarray
    found: np.ndarray


@dataclass(frozen=True, eq=False, repr=False)
class Deformation:
    """A moving-least-squares deformation of space, given by control points.

    The backward map G tells for each place v of the deformed space where its material came from
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
        The maps that are fitted around each place: affine (Eq. 5 to 7), rotations (Eq. 8 to 22),
        rotations with a uniform factor (end of section 2), polynomials (Eq. 23 to 26).
    alpha : float, > 0
        Weights are 1 / |q_i - v|^(2 alpha): a larger alpha makes control points more local. At
        alpha <= 1/2 the map has a kink at each control point.
    degree : {1, 2, 3}
        Degree of the polynomial kind.
    weights : (n,) array_like, > 0, optional
        Factor on the weight of each control point; all 1 if not given.
    cuts : sequence of Plane, HalfPlane and Surface
        What keeps control points from acting on what is behind (section 4). A side of a Plane
        without control points stays at rest.
    nu : float, > 1
        Damping exponent of Eq. 28: how fast influence fades with the length of the detour.
    device : str, optional
        "gpu" or "cpu" for the first of its kind, "0:1" for platform 0 and device 1, "reference"
        for the float64 numpy specification. If not given: the environment variable
        VTK_MLS_DEVICE, else the first GPU, else the first CPU.

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

    rest: np.ndarray
    deformed: np.ndarray
    kind: str = "rigid"
    _: KW_ONLY
    alpha: float = 1.0
    degree: int = 2
    weights: np.ndarray | None = None
    cuts: tuple = ()
    nu: float = 2.0
    device: str | None = None
    regions: tuple[Region, ...] = field(init=False)

    def __post_init__(self):
        rest = arguments.control_points("rest", self.rest)
        deformed = arguments.control_points("deformed", self.deformed)
        if len(rest) == 0:
            raise ValueError("`rest` is empty; a deformation needs at least one control point")
        if rest.shape != deformed.shape:
            raise ValueError(
                "`rest` and `deformed` must have the same number of control points, "
                f"got {len(rest)} and {len(deformed)}"
            )
        arguments.choice("kind", self.kind, kinds.KINDS)
        alpha = arguments.number("alpha", self.alpha)
        if not (np.isfinite(alpha) and alpha > 0):
            raise ValueError(f"`alpha` must be a positive number, got {shown(self.alpha)}")
        if not np.isscalar(self.degree) or self.degree not in (1, 2, 3):
            raise ValueError(f"`degree` must be 1, 2 or 3, got {shown(self.degree)}")
        degree = int(self.degree)
        weights = arguments.positive_weights(self.weights, len(rest))
        cuts = arguments.cut_shapes(self.cuts)
        nu = arguments.number("nu", self.nu)
        if not (np.isfinite(nu) and nu > 1):
            raise ValueError(f"`nu` must be a number above 1, got {shown(self.nu)}")
        planes = [cut for cut in cuts if isinstance(cut, Plane)]
        kind = kinds.named(self.kind, degree)
        for array in (rest, deformed, weights):
            array.flags.writeable = False
        for name, value in {
            "rest": rest,
            "deformed": deformed,
            "alpha": alpha,
            "degree": degree,
            "weights": weights,
            "cuts": cuts,
            "nu": nu,
            "regions": divided(planes, rest, deformed, weights, kind),
        }.items():
            object.__setattr__(self, name, value)
        arguments.check_reach(cuts, self.regions)

    def __repr__(self):
        degree = f", degree={self.degree}" if self.regions[0].control_points.kind.has_degree else ""
        return (
            f"<Deformation {self.kind}{degree}, alpha={self.alpha:g}, "
            f"{len(self.rest)} control points" + (f", {len(self.cuts)} cuts>" if self.cuts else ">")
        )

    @property
    def planes(self):
        """The full cuts, which make the regions."""
        return [cut for cut in self.cuts if isinstance(cut, Plane)]

    @property
    def obstacles(self):
        """The cuts that one can go round."""
        return [cut for cut in self.cuts if isinstance(cut, Obstacle)]

    @_quiet
    def backward(self, points, progress=None):
        """Where the material now at `points` came from: G(v) = l_v^-1(v), Eq. 4 and 26.

        Parameters
        ----------
        points : (m, 3) array_like, world coordinates
        progress : callable, optional
            Called with the fraction done (0 to 1) between chunks; a true answer stops the work.

        Returns
        -------
        (m, 3) float64, world coordinates

        Raises
        ------
        ValueError, DeviceError, Aborted
        """
        return self._engine.backward(self, arguments.points("points", points), _checked(progress))

    @_quiet
    def forward(self, points, progress=None):
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
        points = arguments.places(points)
        displacement, found = self._engine.forward(self, points, _checked(progress))
        v = points + displacement.astype(np.float64)
        v[~found] = np.nan
        return v

    @_quiet
    def forward_field(self, points, progress=None):
        """Where the material at `points` goes, as displacements, and where that is nowhere.

        Places are looked for by Newton's method on G with its analytic Jacobian, without leaving
        the material's side of a cut; many at once by Broyden's method, from first guesses that
        are interpolated between some.

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
        points = arguments.places(points)
        displacement, found = self._engine.forward(self, points, _checked(progress))
        displacement = displacement.astype(np.float32, copy=False)
        lost = np.flatnonzero(~found)
        lost = lost[np.isfinite(points[lost]).all(axis=1)]
        # too far away for the device's float32
        displacement[lost[~np.isfinite(displacement[lost]).all(axis=1)]] = 0
        return ForwardField(displacement, found)

    @_quiet
    def jacobian(self, points, progress=None):
        """dG_i/dv_j at `points`, J_G of Eq. 29, in closed form.

        At a control point it is the linear part of the map fitted there.

        Parameters
        ----------
        points : (m, 3) array_like, world coordinates
        progress : callable, optional
            As for `backward`.

        Returns
        -------
        (m, 3, 3) float64
        """
        return self._engine.jacobian(self, arguments.points("points", points), _checked(progress))

    @_quiet
    def void_distance(self, points, progress=None):
        """How far `points` are from being void.

        Below 0 where the way from a place v to its origin G(v) crosses a cut, so that nothing is
        at v; continuous on each side of every cut. Its zero level is the face of the opening.

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
        points = arguments.points("points", points)
        origins = self._engine.backward(self, points, _checked(progress))
        void_distances = [cut.void_distance(points, origins) for cut in self.cuts]
        return np.min(void_distances, axis=0) if void_distances else np.full(len(points), np.inf)

    def void(self, points, progress=None):
        """Whether there is nothing at `points` (m, 3) because a cut has opened: (m,) bool."""
        return self.void_distance(points, progress) < 0

    @_quiet
    def displacement_field(
        self, dimensions, origin=(0, 0, 0), spacing=(1, 1, 1), direction=None, progress=None
    ):
        """The displacement map G(v) - v on a grid (section 4 of the paper).

        Parameters
        ----------
        dimensions, origin, spacing, direction
            Of the `Grid`; dimensions (nx, ny, nz). Or only the `Grid`.
        progress : callable, optional
            As for `backward`, called between slabs.

        Returns
        -------
        DisplacementField
        """
        grid = _grid(dimensions, origin, spacing, direction)
        displacement, void_distance = self._engine.displacement_field(
            self, grid, _checked(progress)
        )
        return DisplacementField(displacement, grid, void_distance)

    @_quiet
    def void_distance_field(
        self, dimensions, origin=(0, 0, 0), spacing=(1, 1, 1), direction=None, progress=None
    ):
        """`void_distance` on a grid, for the memory of the result alone.

        Parameters
        ----------
        dimensions, origin, spacing, direction, progress
            As for `displacement_field`.

        Returns
        -------
        (nz, ny, nx) float32, world units
            Infinite without cuts.
        """
        grid = _grid(dimensions, origin, spacing, direction)
        void_distance = np.full(grid.shape, np.inf, np.float32)
        for part, values in self._void_distance_slabs(grid, progress):
            void_distance[part] = values
        return void_distance

    @_quiet
    def void_field(
        self, dimensions, origin=(0, 0, 0), spacing=(1, 1, 1), direction=None, progress=None
    ):
        """`void` on a grid, (nz, ny, nx) bool, as `void_distance_field`."""
        grid = _grid(dimensions, origin, spacing, direction)
        void = np.zeros(grid.shape, bool)
        for part, values in self._void_distance_slabs(grid, progress):
            np.less(values, 0, out=void[part])
        return void

    def _void_distance_slabs(self, grid, progress):
        """Slices along z of a grid, and the void distance there, to the bit that of the whole."""
        if not self.cuts:
            return
        report = _checked(progress)
        nx, ny, nz = grid.dimensions
        step = max(1, _SLAB // (nx * ny))
        for low in range(0, nz, step):
            high = min(low + step, nz)
            slab = grid.part((0, 0, low), (nx, ny, high - low))
            yield slice(low, high), self._engine.displacement_field(self, slab)[1]
            if report is not None:
                report(high / nz)

    @_quiet
    def resample(
        self,
        arrays,
        source,
        target=None,
        interpolation="linear",
        background=0.0,
        void_values="background",
        progress=None,
    ):
        """Deform what `arrays` hold on a grid.

        Parameters
        ----------
        arrays : sequence of (nz, ny, nx) or (nz, ny, nx, components) arrays, any real dtype
        source : Grid
            Where the arrays' values are. Of a part of a grid it is taken that values which it
            lacks are not needed: see `source_bounds`.
        target : Grid, optional
            Where values are wanted; `source` if not given.
        interpolation : {"nearest", "linear", "cubic"} or a sequence with one per array
        background : float
            Value of places whose material came from outside of `source` (by more than half a
            spacing), and of the void.
        void_values : {"background", "continued"}
            What is in the void: `background`; or the values that the map of each side brings
            there, as if its material went on behind the face of the cut. Contours of these end
            sharp where they are clipped by the opening.
        progress : callable, optional
            As for `backward`, called between slabs.

        Returns
        -------
        list of arrays
            With the target's shape and the dtypes of `arrays`; integers are rounded to the
            nearest and kept in their range. Where the map is the identity, values are the same
            to the bit.
        """
        arguments.grid("source", source)
        target = source if target is None else arguments.grid("target", target)
        arrays = [np.asarray(array) for array in arrays]
        for array in arrays:
            if array.ndim not in (3, 4) or array.shape[:3] != source.shape:
                raise ValueError(
                    f"`arrays` must have the shape of the grid, {source.shape} or "
                    f"{(*source.shape, 'components')}, got {array.shape}"
                )
            if array.dtype.kind not in "iuf" or array.dtype.itemsize > 8:
                raise TypeError(f"`arrays` must hold integers or floats, got {array.dtype}")
        is_one = np.isscalar(interpolation) or interpolation is None
        methods = [interpolation] * len(arrays) if is_one else list(interpolation)
        if (
            len(methods) != len(arrays)
            or not all(np.isscalar(m) for m in methods)
            or not (set(methods) <= set(INTERPOLATIONS))
        ):
            raise ValueError(
                f"`interpolation` must be one of {', '.join(INTERPOLATIONS)}, or one for each "
                f"array, got {shown(interpolation)}"
            )
        return self._engine.resample(
            self,
            [np.ascontiguousarray(array) for array in arrays],
            source,
            target,
            methods,
            arguments.number("background", background),
            arguments.continues(void_values),
            _checked(progress),
        )

    @_quiet
    def source_bounds(self, source, target, void_values="background", progress=None):
        """Which part of `source` the points of `target` take their material from.

        Parameters
        ----------
        source, target : Grid
        void_values, progress
            As for `resample`.

        Returns
        -------
        low, high : (3,) float64
            Bounds of the continuous indices in `source.whole`, without those outside of it; inf
            and -inf if all are.
        """
        for name, grid in (("source", source), ("target", target)):
            arguments.grid(name, grid)
        low, high = self._engine.source_bounds(
            self, source, target, arguments.continues(void_values), _checked(progress)
        )
        return low.astype(np.float64), high.astype(np.float64)

    @_quiet
    def jacobian_field(
        self, dimensions, origin=(0, 0, 0), spacing=(1, 1, 1), direction=None, progress=None
    ):
        """dG_i/dv_j at the points of a grid, in closed form.

        Parameters
        ----------
        dimensions, origin, spacing, direction, progress
            As for `displacement_field`.

        Returns
        -------
        (nz, ny, nx, 3, 3) float32
            A view of (I + J_D)^T, the paper's extra texture: `swapaxes(-1, -2)` is contiguous.
        """
        grid = _grid(dimensions, origin, spacing, direction)
        return self._engine.jacobian_field(self, grid, _checked(progress)).swapaxes(-1, -2)

    @_quiet
    def resample_gradients(
        self,
        vectors,
        source,
        target=None,
        interpolation="linear",
        normalise=False,
        void_values="background",
        progress=None,
    ):
        """Deform vectors that are gradients or normals: J_G^T n(G(v)), Eq. 29.

        Parameters
        ----------
        vectors : (nz, ny, nx, 3) array, world frame
        source, target, interpolation, void_values, progress
            As for `resample`.
        normalise : bool
            Whether to return unit vectors; the factor det(J_G) of Eq. 29 does not count then, and
            a gradient does not have it.

        Returns
        -------
        (nz, ny, nx, 3) float32
            0 outside, and in the void unless values are continued there.
        """
        return self._resampled_gradients(
            vectors, source, target, interpolation, normalise, void_values, progress
        )[0]

    @_quiet
    def resample_vectors(
        self,
        vectors,
        source,
        target=None,
        interpolation="linear",
        void_values="background",
        progress=None,
    ):
        """Deform vectors that move with the material, as velocities do: J_G^-1 w(G(v)).

        Parameters
        ----------
        vectors : (nz, ny, nx, 3) array, world frame
        source, target, interpolation, void_values, progress
            As for `resample`.

        Returns
        -------
        (nz, ny, nx, 3) float32
            0 outside, where the map is singular, and in the void unless values are continued there.
        """
        arguments.grid("source", source)
        target = source if target is None else arguments.grid("target", target)
        first, second = _halves(progress)
        vectors = arguments.single("vectors", vectors)
        (moved,) = self.resample([vectors], source, target, interpolation, 0.0, void_values, first)
        return vector_fields.contravariant(moved, self.jacobian_field(target, progress=second))

    @_quiet
    def corrected_gradient(
        self,
        array,
        source,
        target=None,
        interpolation="linear",
        background=0.0,
        normalise=False,
        void_values="background",
        progress=None,
    ):
        """Gradient of the deformed `array`: J_G^T (grad f)(G(v)) with the analytic Jacobian.

        It follows the deformation exactly, unlike differences of the resampled array. On the
        face of a void it is taken across the face, as the paper has it, unless values are
        continued behind it.

        Parameters
        ----------
        array : (nz, ny, nx) array
        source, target, interpolation, background, void_values, progress
            As for `resample`.
        normalise : bool
            Whether to return unit vectors.

        Returns
        -------
        (nz, ny, nx, 3) float32, per world unit
            0 outside, and in the void unless values are continued there.
        """
        target = source if target is None else target
        array = np.asarray(array)
        if array.dtype.kind not in "biuf" or array.shape != arguments.grid("source", source).shape:
            raise ValueError(
                f"`array` must be real numbers with the shape of the grid, {source.shape}, "
                f"got {shown(array)}"
            )
        slopes = vector_fields.gradient(array, source)
        turned, void_distance = self._resampled_gradients(
            slopes, source, target, interpolation, normalise, void_values, progress
        )
        if self.cuts and not arguments.continues(void_values):
            reach = vector_fields.REACH * np.abs(source.spacing).mean()
            near = np.nonzero((void_distance >= 0) & (void_distance < reach))
            at_faces = vector_fields.at_faces(
                self,
                target.whole.at(np.stack(near[::-1], axis=1) + target.first),
                np.asarray(array, np.float32),
                slopes,
                source,
                interpolation,
                arguments.number("background", background),
            )
            turned[near] = vector_fields.unit(at_faces) if normalise else at_faces
        return turned

    def _resampled_gradients(
        self, vectors, source, target, interpolation, normalise, void_values, progress
    ):
        """What `resample_gradients` returns, and the void distance or None."""
        arguments.grid("source", source)
        target = source if target is None else arguments.grid("target", target)
        vectors = np.ascontiguousarray(arguments.single("vectors", vectors))
        if vectors.shape != (*source.shape, 3):
            raise ValueError(
                f"`vectors` must have the shape of the grid, {(*source.shape, 3)}, "
                f"got {vectors.shape}"
            )
        arguments.choice("interpolation", interpolation, INTERPOLATIONS)
        return self._engine.resample_gradients(
            self,
            vectors,
            source,
            target,
            interpolation,
            arguments.continues(void_values),
            normalise,
            _checked(progress),
        )

    @_quiet
    def fitted_grid(self, source):
        """The grid on the lattice of `source` that holds all of the deformed volume.

        Parameters
        ----------
        source : Grid
            Of the undeformed volume.

        Returns
        -------
        Grid
            With the spacing and direction of `source`.
        """
        return fitted_grid(self, source)

    @property
    def _engine(self):
        return engine_for(self.device)


def _grid(dimensions, *placement):
    return dimensions if isinstance(dimensions, Grid) else Grid(dimensions, *placement)


def _halves(progress):
    """Callbacks for the two halves of a work with `progress`."""
    if progress is None:
        return None, None
    return (lambda f: progress(f / 2)), (lambda f: progress((1 + f) / 2))


def _checked(progress):
    """`progress` as the engines call it: an answer to stop becomes an exception."""
    if progress is None:
        return None

    def report(fraction):
        if progress(fraction):
            raise Aborted(f"stopped at {fraction:.0%} as `progress` asked")

    return report
