"""Which cells of a mesh have been turned inside out."""

from __future__ import annotations

import numpy as np

from vtk_mls import arrays

_TETRAHEDRON = [(0, 1, 2, 3)]
_HEXAHEDRON = [(0, 1, 3, 4), (1, 2, 3, 6), (1, 6, 4, 5), (3, 4, 6, 7), (1, 3, 4, 6)]
_VOXEL = [tuple((0, 1, 3, 2, 4, 5, 7, 6)[corner] for corner in four) for four in _HEXAHEDRON]
_WEDGE = [(0, 1, 2, 5), (0, 1, 5, 4), (0, 4, 5, 3)]
_PYRAMID = [(0, 1, 2, 4), (0, 2, 3, 4)]

# Tetrahedra whose signed volumes add up to that of a cell, by VTK's numbers of cell types. The
# corners of quadratic, Lagrange and Bezier cells come first.
TETRAHEDRA = {
    **dict.fromkeys((10, 24, 71, 78), _TETRAHEDRON),
    **dict.fromkeys((12, 25, 29, 33, 72, 79), _HEXAHEDRON),
    11: _VOXEL,
    **dict.fromkeys((13, 26, 31, 32, 73, 80), _WEDGE),
    **dict.fromkeys((14, 27, 37, 74, 81), _PYRAMID),
}


@np.errstate(invalid="ignore")  # points may be NaN
def inverted(grid, before, after):
    """Number of cells whose volume has another sign than before.

    Parameters
    ----------
    grid : vtkUnstructuredGrid
        Its cells of three dimensions are looked at, but for polyhedra and prisms of more sides.
    before, after : (n, 3) arrays
        Places of its points.
    """
    if grid.GetNumberOfCells() == 0:
        return 0
    types = arrays.cell_types(grid)
    cells = grid.GetCells()
    corners = arrays.to_numpy(cells.GetConnectivityArray())
    starts = arrays.to_numpy(cells.GetOffsetsArray())[:-1]
    count = 0
    for kind in np.unique(types):
        tetrahedra = TETRAHEDRA.get(int(kind), [])
        first = starts[types == kind]
        volumes = np.zeros((2, len(first)))
        for tetrahedron in tetrahedra:
            a, b, c, d = (corners[first + corner] for corner in tetrahedron)
            for total, x in zip(volumes, (before, after)):
                ab, ac, ad = (x[end].astype(np.float64) - x[a] for end in (b, c, d))
                total += np.sum(np.cross(ab, ac) * ad, axis=1)
        count += np.count_nonzero(np.sign(volumes[0]) * np.sign(volumes[1]) < 0)
    return count
