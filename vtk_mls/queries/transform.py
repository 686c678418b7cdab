"""The methods of all transforms: deformations, affine maps, fields and chains."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base import interpolation, validation
from vtk_mls.base.grid import Grid, checked_grid
from vtk_mls.base.messages import warn
from vtk_mls.base.progress import Progress, ProgressLike, whole
from vtk_mls.base.sampling import Sampling
from vtk_mls.queries import arrival, fields, resampling, vector_fields, void_cells
from vtk_mls.queries import certificate as certificates
from vtk_mls.queries.certificate import Certificate
from vtk_mls.queries.fields import DisplacementField, ForwardField
from vtk_mls.queries.void_cells import VoidCells


@contextmanager
def question(progress: ProgressLike) -> Iterator[Progress]:
    """The Progress of a question, without numpy's warnings: results may be NaN or infinite."""
    with np.errstate(all="ignore"), whole(progress) as part:
        yield part


class Transform:
    """A map between the undeformed and the deformed space.

    The backward map G gives for each point v of the deformed space the origin of its material.

    Methods take `progress`, a callable that is called with the fraction done, from 0 to 1. A true
    return value stops the computation with `Aborted`.

    Attributes
    ----------
    cuts : tuple of cuts
        Not empty if it may open voids.
    in_rest_frame : bool
        Whether there are cuts that move with the material.
    device : str or None
        Where arrays are sampled.
    """

    cuts: Any
    in_rest_frame: Any
    device: Any

    def backward(self, points: ArrayLike, progress: ProgressLike = None) -> NDArray[np.float64]:
        """Origins of the material now at `points`: G(v) = l_v^-1(v), Eq. 4 and 26.

        Parameters
        ----------
        points : (m, 3) array_like, world coordinates

        Returns
        -------
        (m, 3) float64, world coordinates
        """
        points = validation.points("points", points)
        with question(progress) as part:
            return self._engine.backward(self, points, part)

    def forward(self, points: ArrayLike, progress: ProgressLike = None) -> NDArray[np.float64]:
        """Deformed positions of the material at `points`: the true inverse of `backward`.

        `forward_field` returns displacements, and needs less time and memory.

        Parameters
        ----------
        points : (m, 3) array_like, world coordinates of the undeformed space

        Returns
        -------
        (m, 3) float64, world coordinates
            v with G(v) = x, to 1e-5 of the extent of the control points or of the distance from
            them, whichever is larger; in several steps, to that in each of them. NaN without an
            inverse: where the map folds, where material was pushed through a cut, and where x is
            not finite or too far away for the device's float32. Where the map folds there can be
            several inverses; one of them is returned.
        """
        points = validation.coordinates(points)
        with question(progress) as part:
            displacement, found = self._engine.forward(self, points, part)
            v = points + displacement.astype(np.float64)
            v[~found] = np.nan
            return v

    def forward_field(self, points: ArrayLike, progress: ProgressLike = None) -> ForwardField:
        """Displacements of the material at `points`, and whether the inverse was found.

        G(v) = x is solved by Newton's method with the analytic Jacobian and backtracking; for many
        points by Broyden's method, from first guesses that are interpolated on a grid.

        Parameters
        ----------
        points : (m, 3) array_like, world coordinates of the undeformed space
            float32 is used as it is, other types as float64.
        """
        points = validation.coordinates(points)
        with question(progress) as part:
            return fields.forward_field(self._engine, self, points, part)

    def jacobian(
        self, points: ArrayLike, progress: ProgressLike = None, origins: ArrayLike | None = None
    ) -> NDArray[np.float64]:
        """dG_i/dv_j at `points`, J_G of Eq. 29, in closed form.

        At a control point it is the linear part of the map fitted there.

        Parameters
        ----------
        points : (m, 3) array_like, world coordinates
        origins : (m, 3) array_like, world coordinates of the undeformed space, optional
            x = G(v), if known. With cuts in the rest frame it selects the material at a face where
            material of both sides meets.

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
        with question(progress) as part:
            return self._engine.jacobian(
                self, points, part, origins if self.in_rest_frame else None
            )

    def void_distance(
        self, points: ArrayLike, progress: ProgressLike = None
    ) -> NDArray[np.float64]:
        """Signed distance of `points` from the void.

        Negative where the segment from v to G(v) crosses a cut, so that there is no material at v;
        continuous on each side of every cut. Its zero level is the face of the void.

        Parameters
        ----------
        points : (m, 3) array_like, world coordinates

        Returns
        -------
        (m,) float64, world units
            Infinite without cuts.
        """
        points = validation.points("points", points)
        with question(progress) as part:
            return self._void_distance(points, part)

    def void(self, points: ArrayLike, progress: ProgressLike = None) -> NDArray[np.bool_]:
        """Whether `points` (m, 3) are in a void that a cut has opened: (m,) bool."""
        return self.void_distance(points, progress) < 0

    def overlap(self, points: ArrayLike, progress: ProgressLike = None) -> NDArray[np.bool_]:
        """Whether material from both sides of a cut overlaps at `points`.

        `backward` returns the origin of one of them. At a Plane it is the material on the expected
        side, so G(q_i) = p_i does not hold for control points of the other side there.

        Parameters
        ----------
        points : (m, 3) array_like, world coordinates

        Returns
        -------
        (m,) bool
            False with cuts in the deformed frame, where material that reaches a cut is lost.
        """
        points = validation.points("points", points)
        with question(progress) as part:
            return self._overlap(points, part)

    def overlap_field(self, grid: Grid, progress: ProgressLike = None) -> NDArray[np.bool_]:
        """`overlap` on a grid, (nz, ny, nx) bool."""
        result = np.zeros(checked_grid("grid", grid).shape, bool)
        with question(progress) as part:
            for rows, share in part.chunks(grid.size, fields.MAX_SLAB_POINTS):
                values = self.overlap(grid.points(rows.start, rows.stop), share)
                result.reshape(-1)[rows] = values
            return result

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
            Of the `Grid`, with dimensions (nx, ny, nz); or only the `Grid`.

        Notes
        -----
        A warning counts displacements that are not finite.
        """
        grid = dimensions
        if not isinstance(grid, Grid):
            grid = Grid(grid, origin, spacing, direction)
        with question(progress) as part:
            field = self._field(grid, part)
            if sentence := fields.gaps("displacements", field.displacement):
                warn(sentence)
            return field

    def certificate(
        self,
        where: Grid | DisplacementField | tuple[ArrayLike, ArrayLike],
        progress: ProgressLike = None,
    ) -> Certificate:
        """Whether the displacement field on a grid, interpolated linearly, keeps orientation.

        Linear interpolation in the six tetrahedra of each voxel (Kuhn) is proven not to fold, or
        the voxels that fold are named, and the spacing that avoids it. So is the deformation of a
        tetrahedral mesh by its points.

        Parameters
        ----------
        where : Grid, DisplacementField, or (points, tetrahedra)
            The grid of a field, or a field of this transform; or (n, 3) world coordinates of the
            undeformed space and (m, 4) ints.
        """
        with question(progress) as part:
            if isinstance(where, tuple):
                points = validation.points("where", where[0])
                rows = validation.corners("where[1]", where[1], 4, len(points))
                return certificates.certificate_of_mesh(self, points, rows, part)
            computing, certifying = part.divided(1, 1)
            field = where if isinstance(where, DisplacementField) else None
            grid = checked_grid("where", where) if field is None else field.grid
            if min(grid.dimensions) == 1:
                raise ValueError(
                    "`where` must have two points or more along each axis, "
                    f"got {' x '.join(map(str, grid.dimensions))}"
                )
            if field is None:
                field = self.displacement_field(grid, progress=computing)
            return certificates.certificate(self._engine, self, field, certifying)

    def void_distance_field(self, grid: Grid, progress: ProgressLike = None) -> NDArray[np.float32]:
        """`void_distance` on a grid, (nz, ny, nx) float32, without the memory of a whole map."""
        result = np.full(checked_grid("grid", grid).shape, np.inf, np.float32)
        with question(progress) as part:
            for layers, slab, share in fields.slabs(grid, part) if self.cuts else ():
                result[layers] = self._field_engine.displacement_field(self, slab, share)[1]
            return result

    def void_field(self, grid: Grid, progress: ProgressLike = None) -> NDArray[np.bool_]:
        """`void` on a grid, (nz, ny, nx) bool, without the memory of a whole map."""
        return self.void_distance_field(grid, progress) < 0

    def void_of_cells(
        self,
        grid: Grid,
        void_distance: NDArray[np.float32] | None = None,
        progress: ProgressLike = None,
    ) -> VoidCells:
        """Which cells between the points of a grid are void.

        The map is evaluated only at the centers of cells near a face of the void.

        Parameters
        ----------
        grid : Grid
        void_distance : (nz, ny, nx) float32, world units, optional
            The `void_distance_field` of the grid, if known.

        Returns
        -------
        VoidCells
            For the centers and the corners of the `Grid.cells` of `grid`.
        """
        checked_grid("grid", grid)
        with question(progress) as part:
            measuring, classifying = part.divided(1, 1)
            if void_distance is None:
                void_distance = self.void_distance_field(grid, measuring)
            void_distance = np.ascontiguousarray(void_distance, np.float32)
            if void_distance.shape != grid.shape:
                raise ValueError(
                    f"`void_distance` must have the shape of the grid, {grid.shape}, "
                    f"got {void_distance.shape}"
                )
            return void_cells.classify_cells(self, self._engine, grid, void_distance, classifying)

    def jacobian_field(self, grid: Grid, progress: ProgressLike = None) -> NDArray[np.float32]:
        """dG_i/dv_j at the points of a grid, in closed form: (nz, ny, nx, 3, 3) float32.

        The result is a view of (I + J_D)^T, the paper's extra texture: `swapaxes(-1, -2)` is
        contiguous.
        """
        checked_grid("grid", grid)
        with question(progress) as part:
            texture = self._engine.jacobian_field(self, grid, self._prepare(grid, part))
            if sentence := fields.gaps("Jacobians", texture.reshape(grid.size, 9)):
                warn(sentence)
            return texture.swapaxes(-1, -2)

    def resample(
        self,
        arrays: Sequence[ArrayLike],
        sampling: Sampling | Grid,
        progress: ProgressLike = None,
        void_distance: NDArray[np.float32] | None = None,
    ) -> list[NDArray[Any]]:
        """Deform arrays on a grid.

        Parameters
        ----------
        arrays : sequence of (nz, ny, nx) or (nz, ny, nx, components) arrays, any real dtype
        sampling : Sampling or Grid
            A Grid is short for `Sampling(grid)`.
        void_distance : (nz, ny, nx) float32, contiguous, optional
            With the target's shape; filled with the `void_distance_field`.

        Returns
        -------
        list of arrays
            With the target's shape and the dtypes of `arrays`; integers are rounded to the nearest
            and limited to their range. Where the map is the identity, values are unchanged.
        """
        sampling = Sampling.of(sampling)
        checked = resampling.checked_arrays(arrays, sampling)
        sampling.methods(len(checked))
        sampling = sampling.with_backgrounds(checked)
        distances = resampling.distance_buffer(self, void_distance, sampling.target)
        with question(progress) as part:
            resampling.warn_of_background(checked, sampling)
            part = self._prepare(sampling.target, part)
            return resampling.resampled(self._engine, self, checked, sampling, part, distances)

    def source_bounds(
        self, sampling: Sampling | Grid, progress: ProgressLike = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Bounds of the origins of the target's points, as indices of the source.

        Returns
        -------
        low, high : (3,) float64
            Of the continuous indices inside `source.whole`; inf and -inf if all are outside.
        """
        sampling = Sampling.of(sampling)
        with question(progress) as part:
            low, high = interpolation.NO_BOUNDS
            for _, target, share in fields.slabs(sampling.target, part):
                index = self._engine.source_index(self, replace(sampling, target=target), share)
                low, high = interpolation.joined_bounds((low, high), index, sampling.source.whole)
            return low.astype(np.float64), high.astype(np.float64)

    def resample_gradients(
        self,
        vectors: ArrayLike,
        sampling: Sampling | Grid,
        normalise: bool = False,
        progress: ProgressLike = None,
    ) -> NDArray[np.float32]:
        """Deform covariant vectors, such as gradients and normals: J_G^T n(G(v)), Eq. 29.

        Parameters
        ----------
        vectors : (nz, ny, nx, 3) array, world frame
        sampling : Sampling or Grid
        normalise : bool
            Whether to return unit vectors. The factor det(J_G) of Eq. 29 then cancels; gradients do
            not have it.

        Returns
        -------
        (nz, ny, nx, 3) float32
            0 outside, and in the void unless values are continued there.
        """
        with question(progress) as part:
            sampling = replace(Sampling.of(sampling), background=0.0)
            checked = resampling.checked_vectors(vectors, sampling.source)
            sampling.methods(1)
            part = self._prepare(sampling.target, part)
            return resampling.resampled(
                self._engine, self, [checked], sampling, part, covariant={0: normalise}
            )[0]

    def resample_vectors(
        self, vectors: ArrayLike, sampling: Sampling | Grid, progress: ProgressLike = None
    ) -> NDArray[np.float32]:
        """Deform contravariant vectors, such as velocities: J_G^-1 w(G(v)).

        Parameters
        ----------
        vectors : (nz, ny, nx, 3) array, world frame
        sampling : Sampling or Grid

        Returns
        -------
        (nz, ny, nx, 3) float32
            0 outside, where the map is singular, and in the void unless values are continued there.
        """
        with question(progress) as part:
            sampling = replace(Sampling.of(sampling), background=0.0)
            vectors = validation.single_precision("vectors", vectors)
            sampled, mapped, transformed = part.divided(2, 2, 1)
            (moved,) = self.resample([vectors], sampling, sampled)
            jacobian = self.jacobian_field(sampling.target, mapped)
            transformed.report(0)
            return vector_fields.contravariant(moved, jacobian)

    def corrected_gradient(
        self,
        array: ArrayLike,
        sampling: Sampling | Grid,
        normalise: bool = False,
        progress: ProgressLike = None,
    ) -> NDArray[np.float32]:
        """Gradient of the deformed `array`: J_G^T (grad f)(G(v)) with the analytic Jacobian.

        Unlike differences of the resampled array, it follows the deformation exactly. At the face
        of a void it is the gradient across the face, as in the paper, unless values are continued
        behind it.

        Parameters
        ----------
        array : (nz, ny, nx) array
        sampling : Sampling or Grid
        normalise : bool
            Whether to return unit vectors.

        Returns
        -------
        (nz, ny, nx, 3) float32, per world unit
            0 outside, and in the void unless values are continued there.
        """
        return self.resample_with_gradient([], array, sampling, normalise, progress)[1]

    def resample_with_gradient(
        self,
        arrays: Sequence[ArrayLike],
        array: ArrayLike,
        sampling: Sampling | Grid,
        normalise: bool = False,
        progress: ProgressLike = None,
        void_distance: NDArray[np.float32] | None = None,
    ) -> tuple[list[NDArray[Any]], NDArray[np.float32]]:
        """`resample` of `arrays` and `corrected_gradient` of `array`, in one pass.

        With an interpolation or background for each array, that of the gradient is the last.
        """
        sampling = Sampling.of(sampling)
        scalars = resampling.checked_scalars(array, sampling.source)
        checked = resampling.checked_arrays(arrays, sampling)
        sampling.methods(len(checked) + 1)
        sampling = sampling.with_backgrounds([*checked, scalars])
        distances = resampling.distance_buffer(self, void_distance, sampling.target, is_needed=True)
        with question(progress) as part:
            resampling.warn_of_background(checked, sampling)
            part = self._prepare(sampling.target, part)
            return resampling.with_gradient(
                self._field_engine, self, [*checked, scalars], sampling, normalise, part, distances
            )

    def fitted_grid(self, source: Grid, progress: ProgressLike = None) -> Grid:
        """The grid that holds the deformed volume, with spacing and direction of `source`.

        Parameters
        ----------
        source : Grid
            Of the undeformed volume.
        """
        checked_grid("source", source)
        with question(progress) as part:
            return arrival.fitted_grid(self, source, part)

    @property
    def _engine(self):
        """The `engine.protocol.Engine` that evaluates this transform."""
        raise NotImplementedError

    @property
    def _field_engine(self):
        """The same, for displacement fields and gradients."""
        return self._engine

    def _field(self, grid, progress):
        """The `DisplacementField` on a grid, with as many steps as it needs."""
        displacement, void_distance = self._field_engine.displacement_field(self, grid, progress)
        return DisplacementField(displacement, grid, void_distance)

    def _on_grid(self, grid, points, progress, with_jacobian):
        """Origins (m, 3), void distances (m,) or None, and Jacobians (m, 3, 3) or None.

        At the `points` (m, 3) of a grid.
        """
        mapping, differentiating = progress.divided(1, with_jacobian)
        displacement, distance = self._field_engine.displacement_field(self, grid, mapping)
        jacobian = None
        if with_jacobian:
            jacobian = self._engine.jacobian_field(self, grid, differentiating)
            jacobian = jacobian.reshape(-1, 3, 3).swapaxes(1, 2)
        distance = None if distance is None else distance.reshape(-1)
        return points + displacement.reshape(-1, 3), distance, jacobian

    def _prepare(self, grid, progress):
        """Take as many steps as a grid needs, before a question about it; the Progress left."""
        return progress

    def _check_folds(self, grid, progress):
        """The `certificates.FoldCheck` of the field on a grid."""
        computing, checking = progress.divided(3, 1)
        return certificates.check(self._engine, self, self._field(grid, computing), checking)

    def _folded_points(self, grid, progress, with_field=False):
        """Points of a grid, (nz, ny, nx) bool, at corners of voxels in which the map folds.

        With `with_field`, also of those in which the field folds. Voxels beside a part of a grid
        count, too.
        """
        before = np.minimum(grid.first, 1)
        last = np.minimum(np.add(grid.first, grid.dimensions) + 1, grid.whole.dimensions)
        outer = grid
        if grid.is_part:
            first = np.subtract(grid.first, before)
            outer = grid.whole.part(first, last - first)
        folds = self._check_folds(outer, progress)
        voxels = np.union1d(folds.map_indices, folds.indices if with_field else [])
        points = certificates.corner_points(outer, voxels.astype(np.int64))
        return points[tuple(slice(i, i + n) for i, n in zip(before[::-1], grid.shape))]

    def _void_distance(self, points, progress):
        return fields.void_distance(self._engine, self, points, progress)

    def _overlap(self, points, progress):
        return fields.overlap(self._engine, self, points, progress)

    def _nearest_face(self, points, origins):
        """Void distances (m,) at v, and unit vectors (m, 3) away from the nearest cut.

        `points` (m, 3) are v, `origins` (m, 3) G(v). The vectors are in the space of these.
        """
        positions = origins if self.in_rest_frame else points  # in the frame of the cuts
        distances = [cut.void_distance(positions, origins) for cut in self.cuts]
        nearest = np.argmin(distances, axis=0)
        away = np.zeros_like(points)
        for index, cut in enumerate(self.cuts):
            rows = nearest == index
            away[rows] = cut.away(positions[rows], origins[rows])
        return np.min(distances, axis=0), away

    def _material_samples(self, grid):
        """Positions (n, 3) of some material before and after the transform, near a grid."""
        raise NotImplementedError
