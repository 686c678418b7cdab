"""Whether a displacement field, as other programs interpolate it, and its map keep orientation.

Programs interpolate a field linearly. In each of the six tetrahedra into which Kuhn divides a
voxel, along its diagonal, that is an affine map: it keeps orientation exactly if the deformed
tetrahedron has a positive volume. `Engine.doubtful_voxels` finds the voxels whose volumes are not
far from 0, or differ much; these are computed in float64, and so is the Jacobian of the map at
their corners and centers.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vtk_mls.base.linear_algebra import transformed
from vtk_mls.base.progress import SILENT
from vtk_mls.queries.void_cells import TOUCHED

# A voxel is doubtful if the smallest volume of its tetrahedra is not above this share of their
# mean. Of 358 scenes of tests/fuzz/folds.py with automatic steps, no other voxel has a fold of the
# map at a corner or the center; of single maps that fold, 18 of 123,844 such voxels were missed.
DOUBTFUL = 0.4
_CORNERS = np.stack(np.meshgrid((0, 1), (0, 1), (0, 1), indexing="ij"), axis=-1)[..., ::-1]
_CORNERS = _CORNERS.reshape(8, 3)  # as indices (i, j, k), i fastest
_HALVINGS = 2, 4, 8
_MAX_VOXELS = 1 << 14  # in memory at once


@dataclass(frozen=True, eq=False)
class Certificate:
    """Which cells of a field or mesh keep their orientation.

    Attributes
    ----------
    indices : (folded,) int64
        The voxels that fold, as rows of the `Grid.cells`, x fastest; or the tetrahedra.
    map_indices : (k,) int64
        The voxels at whose corners or center the determinant of the map itself is not above 0.
    checked : int
        The number of voxels or tetrahedra that are not left out.
    left_out : int
        The number of voxels that a void or cut crosses or touches.
    spacing : (3,) float64, world units, or None
        The largest spacing, halved up to three times, with which the field does not fold. None
        without one, and for tetrahedra.
    """

    indices: NDArray[np.int64]
    map_indices: NDArray[np.int64]
    checked: int
    left_out: int = 0
    spacing: NDArray[np.float64] | None = None
    cells: str = "voxels"

    @property
    def folded(self) -> int:
        """The number of cells that fold."""
        return len(self.indices)

    @property
    def is_proven(self) -> bool:
        """Whether no cell folds, except those that are left out."""
        return not self.folded

    def __str__(self) -> str:
        cells, left_out = f"{self.checked} {self.cells}", ""
        if self.left_out:
            left_out = f", without {self.left_out} across a cut or void"
        if self.is_proven:
            text = f"proven to keep orientation in all {cells}"
        else:
            text = f"folds in {self.folded} of {cells}"
        if len(self.map_indices):
            advice = f"the map itself folds in {len(self.map_indices)}, which more steps may avoid"
        elif self.spacing is not None:
            numbers = ", ".join(f"{length:.6g}" for length in self.spacing)
            advice = f"a field with the spacing {numbers} does not fold" * (not self.is_proven)
        else:
            advice = "no spacing down to an eighth avoids it" * (self.cells == "voxels")
        return text + left_out + f"; {advice}" * (bool(advice) and not self.is_proven)


class FoldCheck(NamedTuple):
    """Folds of the voxels of a field: `indices`, `map_indices` and `left_out` of a Certificate, and
    the smallest determinant (1,) that was computed, infinite without any."""

    indices: np.ndarray
    map_indices: np.ndarray
    left_out: int
    smallest: float


NO_FOLDS = FoldCheck(np.zeros(0, np.int64), np.zeros(0, np.int64), 0, np.inf)


def volumes(positions):
    """Volumes (m, 6), times six, of Kuhn's tetrahedra of voxels with corners (m, 8, 3)."""
    x, y, xy, z, xz, yz, diagonal = np.moveaxis(positions[:, 1:] - positions[:, :1], 1, 0)
    normals = np.cross(diagonal, np.stack([x, -y, y, -z, z, -x]))  # one slow call instead of six
    return np.einsum("kmi,kmi->mk", normals, np.stack([xy, xy, yz, yz, xz, xz]))


def doubtful_voxels(displacement, axes):
    """1 for `DOUBTFUL` voxels of a field (nz, ny, nx, 3), else 0: (nz - 1, ny - 1, nx - 1) uint8.

    Columns of `axes` (3, 3) are the steps between neighbors in the world.
    """
    nz, ny, nx, _ = displacement.shape
    result = np.empty((nz - 1, ny - 1, nx - 1), np.uint8)
    j, i = np.divmod(np.arange((ny - 1) * (nx - 1)), nx - 1)
    for layer, flags in enumerate(result):
        corners = [displacement[layer + c, j + b, i + a] + axes @ (a, b, c) for a, b, c in _CORNERS]
        found = volumes(np.stack(corners, axis=1).astype(np.float64)) * np.linalg.det(axes)
        clear = found.min(axis=1) > DOUBTFUL * found.mean(axis=1)
        flags[:] = ~clear.reshape(flags.shape)
    return result


def check(engine, transform, field, progress=SILENT):
    """The `FoldCheck` of a DisplacementField of a transform.

    Voxels that hold a handle, which may fold between their corners, and the neighbors of those in
    which the map folds are checked, too. On a grid with a single layer there are no tetrahedra: the
    map is checked at all points.
    """
    grid, (finding, mapping) = field.grid, progress.divided(1, 1)
    if is_flat := min(grid.dimensions) == 1:
        doubtful = np.arange(grid.cells.size)
    else:
        flags = engine.doubtful_voxels(field.displacement, grid.index_to_world, finding)
        doubtful = np.flatnonzero(flags.view(bool))
        if transform.regions:
            doubtful = np.union1d(doubtful, _holding(grid, transform.handle_set.positions[1]))
    left_out = 0
    if field.void_distance is not None:
        is_near, left_out = _near_cuts(engine, field, doubtful)
        doubtful = doubtful[~is_near]
    values, in_map = _least_determinants(engine, transform, grid, doubtful, mapping), []
    smallest, new, checked = values.min(initial=np.inf), doubtful[~(values > 0)], doubtful
    while len(new):
        in_map.append(new)
        around = np.setdiff1d(_neighbors(grid, new), checked)
        if field.void_distance is not None:
            around = around[~_near_cuts(engine, field, around)[0]]
        values = _least_determinants(engine, transform, grid, around, SILENT)
        checked, new = np.union1d(checked, around), around[~(values > 0)]
    in_map = np.sort(np.concatenate([np.zeros(0, np.int64), *in_map]))
    if is_flat:
        return FoldCheck(in_map, in_map, left_out, smallest)
    return FoldCheck(_folded(field, doubtful), in_map, left_out, smallest)


def _folded(field, voxels):
    """Those of voxels (m,) that have a tetrahedron without a positive volume."""
    volume, is_folded = np.linalg.det(field.grid.index_to_world), np.zeros(len(voxels), bool)
    for part, _ in SILENT.chunks(len(voxels), _MAX_VOXELS):
        found = volumes(_positions(field, _corner_ids(field.grid, voxels[part]))) * volume
        is_folded[part] = ~(found > 0).all(axis=1)
    return voxels[is_folded]


def _least_determinants(engine, transform, grid, voxels, progress):
    """The smallest determinant (m,) of the map at the corners and centers of voxels (m,)."""
    ids = _corner_ids(grid, voxels)
    corners, rows = np.unique(ids, return_inverse=True)
    points = np.concatenate([grid.points_of(corners), grid.cells.points_of(voxels)])
    found = np.linalg.det(engine.jacobian(transform, points, progress))
    return np.minimum(found[rows.reshape(ids.shape)].min(axis=1), found[len(corners) :])


def _holding(grid, points):
    """Rows of the voxels that hold points (n, 3), those outside of the grid left out."""
    index, size = np.floor(grid.index_of(points)), np.array(grid.cells.dimensions)
    index = index[((index >= 0) & (index < size)).all(axis=1)].astype(np.int64)
    return np.ravel_multi_index(tuple(index[:, ::-1].T), grid.cells.shape)


def _neighbors(grid, voxels):
    """Rows of the voxels beside voxels (m,), and these."""
    shape = grid.cells.shape
    index = np.stack(np.unravel_index(voxels, shape), axis=-1)
    near = index[:, None] + np.stack(np.meshgrid(*[(-1, 0, 1)] * 3), axis=-1).reshape(-1, 3)
    near = np.clip(near, 0, np.array(shape) - 1).reshape(-1, 3)
    return np.unique(np.ravel_multi_index(tuple(near.T), shape))


def certificate(engine, transform, field, progress=SILENT):
    """The `Certificate` of a DisplacementField of a transform."""
    checking, refining = progress.divided(1, 1)
    folds = check(engine, transform, field, checking)
    spacing, checked = None, field.grid.cells.size - folds.left_out
    if not len(folds.map_indices):
        moved = partial(engine.backward, transform)
        spacing = _finer_spacing(moved, field.grid, folds.indices, refining)
    return Certificate(folds.indices, folds.map_indices, checked, folds.left_out, spacing)


def certificate_of_inverse(transform, field):
    """The `Certificate` of a field of displacements to where the material of a grid goes.

    The transform has no cuts. The determinant of the map is not checked.
    """
    grid, engine = field.grid, transform._engine
    flags = engine.doubtful_voxels(field.displacement, grid.index_to_world, SILENT)
    folded = _folded(field, np.flatnonzero(flags.view(bool)))

    def moved(points, progress):
        return points + engine.forward(transform, points, progress)[0]

    spacing = _finer_spacing(moved, grid, folded, SILENT)
    return Certificate(folded, NO_FOLDS.map_indices, grid.cells.size, spacing=spacing)


def _finer_spacing(moved, grid, folded, progress):
    """The largest spacing with which none of some voxels folds; None without one."""
    for count, part in zip(_HALVINGS, progress.divided(*np.power(_HALVINGS, 3))):
        if len(folded) and not _folds_between(moved, grid, folded, count, part):
            return grid.spacing / count
    return None


def certificate_of_mesh(transform, points, tetrahedra, progress=SILENT):
    """The `Certificate` of tetrahedra (m, 4) of `points` (n, 3) in the undeformed space."""
    moved = transform.forward(points, progress)
    before, after = (
        np.linalg.det(x[tetrahedra[:, 1:]] - x[tetrahedra[:, :1]]) for x in (points, moved)
    )
    folded, none = np.flatnonzero(~(before * after > 0)), NO_FOLDS.map_indices
    return Certificate(folded, none, len(tetrahedra), cells="tetrahedra")


def corner_points(grid, voxels):
    """The points of a grid that are corners of voxels, given as rows: (nz, ny, nx) bool."""
    result = np.zeros(grid.size, bool)
    result[_corner_ids(grid, voxels)] = True
    return result.reshape(grid.shape)


def _corner_ids(grid, voxels):
    """Rows (m, 8) of the points at the corners of voxels (m,), rows of the cells of a grid."""
    index = np.stack(np.unravel_index(voxels, grid.cells.shape)[::-1], axis=-1)
    last, (nx, ny, _) = np.array(grid.dimensions) - 1, grid.dimensions
    corners = np.minimum(index[:, None] + _CORNERS, last)
    return corners @ (1, nx, nx * ny)


def _positions(field, ids):
    """Positions (m, 8, 3) of corners (m, 8), without the origin of the grid, after the map."""
    steps = transformed(field.grid.index_to_world, _CORNERS.astype(np.float64))
    return steps + field.displacement.reshape(-1, 3)[ids]


def _near_cuts(engine, field, voxels):
    """Which voxels (m,) a cut may cross or a void touches, and the number of all such voxels.

    Among voxels that a cut crosses without opening a void, only those of `voxels` count: a corner
    is nearer to the cut than to the opposite corner.
    """
    touched = (engine.void_by_corners(field.void_distance, np.inf) & TOUCHED) > 0
    touched = touched.reshape(-1)
    is_near = touched[voxels]
    for part, _ in SILENT.chunks(len(voxels), _MAX_VOXELS):
        ids = _corner_ids(field.grid, voxels[part])
        corners = _positions(field, ids)
        longest = np.linalg.norm(corners[:, 1:] - corners[:, :1], axis=2).max(axis=1)
        is_near[part] |= field.void_distance.reshape(-1)[ids].min(axis=1) < longest
    return is_near, int(touched.sum() + (is_near & ~touched[voxels]).sum())


def _folds_between(moved, grid, voxels, count, progress):
    """Whether a field with `count` times as many points along each edge folds in some voxels.

    `moved` is a function of points (m, 3) and a Progress.
    """
    axis = np.arange(count + 1) / count
    inner = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1)[..., ::-1]
    volume = np.linalg.det(grid.index_to_world)
    for part, share in progress.chunks(len(voxels), max(1, (1 << 20) // inner[..., 0].size)):
        first = np.stack(np.unravel_index(voxels[part], grid.cells.shape)[::-1], axis=-1)
        points = grid.at(first[:, None] + inner.reshape(-1, 3))
        found = moved(points.reshape(-1, 3), share) - grid.origin
        found = found.reshape(-1, *inner.shape)
        corners = np.stack(
            [
                found[:, c : c + count, b : b + count, a : a + count].reshape(-1, 3)
                for a, b, c in _CORNERS
            ],
            axis=1,
        )
        if not (volumes(corners) * volume > 0).all():
            return True
    return False
