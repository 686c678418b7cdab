"""Points with equal coordinates stay together in deformed meshes: what was closed stays closed."""

import numpy as np
import pytest

pv = pytest.importorskip("pyvista")
import vtk_mls.pyvista  # noqa: E402, F401


def handles(bounds, rng):
    """Control points in the bounds, rest and deformed."""
    low, high = np.array(bounds)[::2], np.array(bounds)[1::2]
    rest = low + (high - low) * rng.random((20, 3))
    return rest, rest + rng.normal(0, 0.03, (20, 3)) * (high - low)


@pytest.mark.parametrize("kind", ["affine", "rigid", "similarity", "polynomial"])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_closed_surface_of_single_triangles_stays_closed(dtype, kind, rng):
    sphere = pv.Sphere(radius=0.5)
    triangles = sphere.regular_faces
    corners = sphere.points[triangles].reshape(-1, 3).astype(dtype)
    soup = pv.PolyData.from_regular_faces(corners, np.arange(triangles.size).reshape(-1, 3))
    cleaned = soup.mls.deform(*handles(sphere.bounds, rng), kind=kind).clean()
    assert (cleaned.n_points, cleaned.n_open_edges) == (sphere.n_points, 0)


@pytest.mark.parametrize("kind", ["affine", "rigid", "similarity", "polynomial"])
def test_blocks_share_the_face_that_they_shared(kind, rng):
    axis = np.linspace(0, 1, 17)
    left, right = (
        pv.StructuredGrid(*np.meshgrid(start + axis, axis, axis, indexing="ij")) for start in (0, 1)
    )
    blocks = pv.MultiBlock({"left": left, "right": right})
    a, b = blocks.mls.deform(*handles((0, 2, 0, 1, 0, 1), rng), kind=kind)
    np.testing.assert_array_equal(
        a.points[left.points[:, 0] == 1], b.points[right.points[:, 0] == 1]
    )
