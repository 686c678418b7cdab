"""What an engine answers: the contract of the specification and of the OpenCL engine."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import numpy as np

    from vtk_mls.base.grid import Grid
    from vtk_mls.base.progress import Progress
    from vtk_mls.base.sampling import Sampling
    from vtk_mls.deformation import Deformation


class Engine(Protocol):
    """Answers the questions that one can ask a deformation.

    Arguments are valid: `Deformation` has checked them. Points are in world coordinates and finite,
    unless a question says otherwise. `progress` is told before each piece of the work.

    Attributes
    ----------
    NAME : str
        For people.
    """

    NAME: str

    def backward(
        self, deformation: Deformation, points: np.ndarray, progress: Progress
    ) -> np.ndarray:
        """Origins of the material at some points.

        Parameters
        ----------
        deformation : Deformation
        points : (m, 3) float64, world coordinates
            v.
        progress : Progress

        Returns
        -------
        (m, 3) float64, world coordinates
            G(v).
        """

    def void_distance(
        self, deformation: Deformation, points: np.ndarray, progress: Progress
    ) -> np.ndarray:
        """How far some points are from being void, where the cuts are in the rest frame.

        Parameters
        ----------
        deformation : Deformation
            With cuts; in the deformed frame v and G(v) tell it (`Cut.void_distance`).
        points : (m, 3) float64, world coordinates
            v.
        progress : Progress

        Returns
        -------
        (m,) float64, world units
            Below 0 in the void.
        """

    def jacobian(
        self,
        deformation: Deformation,
        points: np.ndarray,
        progress: Progress,
        origins: np.ndarray | None = None,
    ) -> np.ndarray:
        """Jacobian of the map at some points.

        Parameters
        ----------
        deformation : Deformation
        points : (m, 3) float64, world coordinates
            v.
        progress : Progress
        origins : (m, 3) float64, world coordinates, optional
            x = G(v) where it is known; only with cuts in the rest frame.

        Returns
        -------
        (m, 3, 3) float64
            dG_i/dv_j.
        """

    def origins_from(
        self,
        deformation: Deformation,
        points: np.ndarray,
        starts: np.ndarray,
        progress: Progress,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Origins of the material on one side of the cuts; only with cuts in the rest frame.

        Behind the face of that side the map is continued smoothly.

        Parameters
        ----------
        deformation : Deformation
        points : (m, 3) float64, world coordinates
            v.
        starts : (m, 3) float64, world coordinates
            Where searches begin, on the side of each cut whose material is wanted.
        progress : Progress

        Returns
        -------
        origins : (m, 3) float64, world coordinates
        void_distance : (m,) float64, world units
            Below 0 where that side has no material.
        """

    def forward(
        self, deformation: Deformation, points: np.ndarray, progress: Progress
    ) -> tuple[np.ndarray, np.ndarray]:
        """Displacements of the material at some points of the undeformed space.

        Parameters
        ----------
        deformation : Deformation
        points : (m, 3) float32 or float64, world coordinates
            x, which need not be finite.
        progress : Progress

        Returns
        -------
        displacement : (m, 3) float32 or float64, world units
            v - x for the v with G(v) = x.
        found : (m,) bool
            Whether there is such a v on the material's side of the cuts. Where there is none, v is
            the point with the smallest residual that was found, or `displacement` is not finite.
        """

    def displacement_field(
        self, deformation: Deformation, grid: Grid, progress: Progress
    ) -> tuple[np.ndarray, np.ndarray | None]:
        """Displacement map on a grid.

        Parameters
        ----------
        deformation : Deformation
        grid : Grid
            Its points are v.
        progress : Progress

        Returns
        -------
        displacement : (nz, ny, nx, 3) float32, world units
            G(v) - v.
        void_distance : (nz, ny, nx) float32, world units, or None without cuts
            Below 0 in the void.
        """

    def jacobian_field(
        self, deformation: Deformation, grid: Grid, progress: Progress
    ) -> np.ndarray:
        """Transposed Jacobian of the map on a grid.

        Parameters
        ----------
        deformation : Deformation
        grid : Grid
            Its points are v.
        progress : Progress

        Returns
        -------
        (nz, ny, nx, 3, 3) float32
            dG_j/dv_i.
        """

    def resample(
        self,
        deformation: Deformation,
        arrays: list[np.ndarray],
        sampling: Sampling,
        progress: Progress,
        void_distance: np.ndarray | None = None,
        covariant: dict[int, bool] | None = None,
    ) -> list[np.ndarray]:
        """Deformed arrays.

        Parameters
        ----------
        deformation : Deformation
        arrays : list of (nz, ny, nx) or (nz, ny, nx, components) arrays, contiguous
            On `sampling.source`, of integers or floats.
        sampling : Sampling
        progress : Progress
        void_distance : (target.size,) float32, optional
            Is filled, world units, if there are cuts.
        covariant : dict, optional
            The numbers of arrays of vectors n, float32 in the world frame, that become
            J_G^T n(G(v)), Eq. 29; and whether of length 1 (or 0). They are 0 outside of the source
            and in the void.

        Returns
        -------
        list of arrays
            On `sampling.target`, of the same dtypes.
        """

    def gradient(self, array: np.ndarray, grid: Grid, progress: Progress) -> np.ndarray:
        """Gradient of an array by differences.

        Parameters
        ----------
        array : (nz, ny, nx) array, contiguous, of real numbers
        grid : Grid
        progress : Progress

        Returns
        -------
        (nz, ny, nx, 3) float32, per world unit
            Of fourth order inside, of second order at the border, 0 across a single slice.
        """

    def sample(
        self,
        array: np.ndarray,
        index: np.ndarray,
        method: str,
        background: float,
        source: Grid,
    ) -> np.ndarray:
        """Values of an array between its points: `interpolation.sample`.

        Parameters
        ----------
        array : (nz, ny, nx) or (nz, ny, nx, components) array, contiguous, of real numbers
        index, method, background, source
            As of `interpolation.sample`.

        Returns
        -------
        (m,) or (m, components) array of the same dtype
        """

    def void_by_corners(
        self, void_distance: np.ndarray, least: float, progress: Progress
    ) -> np.ndarray:
        """What the corners of cells tell of the void: `void_cells.by_corners`.

        Parameters
        ----------
        void_distance : (nz, ny, nx) float32, world units, contiguous
            At the points of a grid.
        least : float, world units
            Corners of cells that are not near a face are at least as far from it.
        progress : Progress

        Returns
        -------
        array of uint8
            Of the shape of the `Grid.cells`: the bits VOID, UNKNOWN and TOUCHED of each.
        """

    def void_distance_listed(
        self, deformation: Deformation, grid: Grid, numbers: np.ndarray, progress: Progress
    ) -> np.ndarray:
        """The void distance of `displacement_field` at some points of a grid.

        Parameters
        ----------
        deformation : Deformation
            With cuts.
        grid : Grid
        numbers : (m,) int64
            Of the points, x fastest; they grow.
        progress : Progress

        Returns
        -------
        (m,) float32, world units
        """

    def source_bounds(
        self, deformation: Deformation, sampling: Sampling, progress: Progress
    ) -> np.ndarray:
        """Bounds of the origins of a grid.

        Parameters
        ----------
        deformation : Deformation
        sampling : Sampling
        progress : Progress

        Returns
        -------
        (2, 3) floats
            Lowest and highest continuous index of `sampling.source.whole` that points of the target
            come from, of those inside of it; inf and -inf if there is none.
        """
