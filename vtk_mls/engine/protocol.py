"""The interface of engines: the numpy reference and the OpenCL engine."""

from typing import Protocol


class Engine(Protocol):
    """Evaluates deformations.

    Arguments are valid: `Deformation` checks them. Points are float64, finite and in world
    coordinates unless stated otherwise; v is a point of the deformed space, x of the undeformed
    space, and x = G(v). `progress` is reported before each piece of the work.
    """

    NAME: str  # for people

    def backward(self, deformation, points, progress):
        """Origins G(v) (m, 3) float64, world coordinates, of the material at `points` v (m, 3)."""

    def void_distance(self, deformation, points, progress):
        """Void distances (m,) float64, world units, at `points` v (m, 3); below 0 in the void.

        Of a deformation with `void_needs_map`. For others `Cut.void_distance` computes them from v
        and G(v).
        """

    def least_determinant(self, deformation, points, progress):
        """The smallest determinants (m,) float64 of the Jacobians of steps at `points` (m, 3)."""

    def jacobian(self, deformation, points, progress, origins=None):
        """Jacobians dG_i/dv_j (m, 3, 3) float64 at `points` v (m, 3).

        `origins` x (m, 3) are optional, and given only with cuts in the rest frame.
        """

    def origins_from(self, deformation, points, starts, progress):
        """Origins (m, 3) float64, world coordinates, of the material on one side of the cuts.

        Only with cuts in the rest frame; behind the face of that side the map is continued
        smoothly. Each search for the origin of `points` v (m, 3) begins at one of `starts` (m, 3),
        on the side of each cut whose material is requested. Also void distances (m,) float64, world
        units, below 0 where that side has no material.
        """

    def forward(self, deformation, points, progress):
        """Displacements v - x (m, 3) of the material at `points` x (m, 3), for the v with G(v) = x.

        `points` are float32 or float64, of the undeformed space, and need not be finite;
        displacements are in world units. Also whether such a v exists on the material's side of the
        cuts, (m,) bool. Otherwise v is the point with the smallest residual that was found, or the
        displacement is not finite.
        """

    def displacement_field(self, deformation, grid, progress):
        """G(v) - v (nz, ny, nx, 3) float32, world units, on a grid of points v.

        Also void distances (nz, ny, nx) float32, world units, below 0 in the void; None without
        cuts.
        """

    def jacobian_field(self, deformation, grid, progress):
        """Transposed Jacobians dG_j/dv_i (nz, ny, nx, 3, 3) float32 on a grid of points v."""

    def resample(self, deformation, arrays, sampling, progress, void_distance=None, covariant=None):
        """Deformed arrays on `sampling.target`, of the same dtypes.

        `arrays` (nz, ny, nx) or (nz, ny, nx, components) of integers or floats are contiguous, and
        lie on `sampling.source`. `void_distance` (target.size,) float32, world units, is filled if
        there are cuts. `covariant` has the indices of arrays of covariant vectors n, float32 in the
        world frame, which become J_G^T n(G(v)), Eq. 29, and whether they are normalized. They are 0
        outside the source and in the void.
        """

    def gradient(self, array, grid, progress):
        """Gradient (nz, ny, nx, 3) float32, per world unit, of an array on a grid by differences.

        Of fourth order inside, of second order at the border, 0 across a single slice. `array`
        (nz, ny, nx) is contiguous and holds real numbers.
        """

    def sample(self, array, index, method, background, source, version=None):
        """Values between the points of an array, as `interpolation.sample` computes them.

        `array` (nz, ny, nx) or (nz, ny, nx, components) is contiguous and holds real numbers. The
        result (m,) or (m, components) has the same dtype. `version` is one of `Sampling.versions`.
        """

    def void_by_corners(self, void_distance, min_distance, progress):
        """The bits VOID, UNKNOWN and TOUCHED of cells, as `void_cells.by_corners` computes them.

        `void_distance` (nz, ny, nx) float32, world units, is contiguous. Cells that are not near a
        face have corners at least `min_distance` from it. uint8 with the shape of `Grid.cells`.
        """

    def doubtful_voxels(self, displacement, axes, progress):
        """1 for voxels in which a field may fold, as `certificate.doubtful_voxels` computes them.

        `displacement` (nz, ny, nx, 3) float32 is contiguous, with two layers or more along each
        axis; columns of `axes` (3, 3) are the steps of the grid. (nz - 1, ny - 1, nx - 1) uint8.
        """

    def void_distance_listed(self, deformation, grid, indices, progress):
        """The void distance (m,) float32, world units, of `displacement_field` at some points.

        The deformation has cuts. `indices` (m,) int64 of points of the grid ascend, x fastest.
        """

    def source_index(self, deformation, sampling, progress):
        """The origins of the target of a `Sampling`: (target.size, 3) float32 or float64.

        Continuous indices of `sampling.source.whole`, for `sample`. They are outside of it for the
        void, unless values are continued there.
        """
