"""PyVista's metadata stay: bool and complex types, active arrays, and user data."""

from __future__ import annotations

import importlib

import numpy as np
import pytest

from vtk_mls import Plane

pyvista = pytest.importorskip("pyvista", "0.48", reason="PyVista is not installed")
importlib.import_module("vtk_mls.pyvista")  # registers `mesh.mls`

pytestmark = pytest.mark.usefixtures("numpy_computes")
REST = np.array([(x, y, z) for x in (-4, 4) for y in (-4, 4) for z in (-4, 4)], float)
DEFORMED = REST + (REST[:, :1] > 0) * [1.1, 0.4, 0]
CUT = Plane((0.1, 0, 0), (1, 0, 0))

IMAGE = pyvista.ImageData(dimensions=(7, 6, 5), origin=(-3, -3, -3))
MESHES = {
    "surface": pyvista.Sphere(radius=3, theta_resolution=8, phi_resolution=8),
    "grid": IMAGE.cast_to_unstructured_grid(),
    "structured": IMAGE.cast_to_structured_grid(),
    "rectilinear": IMAGE.cast_to_rectilinear_grid(),
    "explicit": pyvista.ExplicitStructuredGrid(IMAGE.cast_to_structured_grid()),
    "points": pyvista.PointSet(REST / 2),
}


def with_arrays(dataset):
    """A copy with arrays of all types that PyVista keeps beside VTK's."""
    result = dataset.copy()
    x = result.points[:, 0]
    result.point_data["flags"] = x > 0
    result.point_data["vector flags"] = result.points > 0
    result.point_data["single"] = (x + 2j * x).astype(np.complex64)
    result.point_data["double"] = x + 1j * result.points[:, 1].astype(float)
    result.point_data["speed"] = result.points.copy()
    result.point_data["height"] = x.copy()
    if result.n_cells and not isinstance(result, pyvista.PointSet):
        result.cell_data["cell flags"] = np.arange(result.n_cells) % 2 == 0
        result.cell_data["cell phase"] = np.arange(result.n_cells) * 1j
    result.field_data["field flags"] = np.array([True, False])
    result.field_data["field phase"] = np.array([1 + 2j, 3j])
    result.field_data["title"] = ["a", "b"]
    result.user_dict = {"who": "me", "n": 3}
    result.set_active_vectors("speed")
    result.set_active_scalars("height")
    return result


def assert_types(found, before):
    """All that `before` has is in `found`, with the same types."""
    for attributes in ("point_data", "cell_data", "field_data"):
        old, new = getattr(before, attributes), getattr(found, attributes)
        for name, values in old.items():
            assert np.asarray(new[name]).dtype == np.asarray(values).dtype, name
            assert np.shape(new[name])[1:] == np.shape(values)[1:], name
    for name, values in before.field_data.items():
        np.testing.assert_array_equal(found.field_data[name], values)
    assert found.user_dict == before.user_dict
    assert found.active_scalars_name == before.active_scalars_name
    assert found.active_vectors_name == before.active_vectors_name


@pytest.mark.parametrize("cuts", [(), CUT], ids=["whole", "cut"])
@pytest.mark.parametrize("name", MESHES)
def test_arrays_of_meshes_keep_their_types(name, cuts):
    mesh = with_arrays(MESHES[name])
    found = mesh.mls.deform(REST, DEFORMED, cuts=cuts)
    assert_types(found, mesh)
    if found.n_points == mesh.n_points:
        for key in {*mesh.point_data.keys()} - {"Normals"}:  # which turn
            np.testing.assert_array_equal(found.point_data[key], mesh.point_data[key])
    before = found.points - found["ForwardDisplacement"]
    clear = np.abs(before[:, 0]) > 0.2  # points on the cut are interpolated
    np.testing.assert_array_equal(found["flags"][clear], before[clear, 0] > 0)
    assert found.points[found["flags"]].shape == (np.count_nonzero(found["flags"]), 3)
    np.testing.assert_allclose(found["single"].imag, 2 * found["single"].real, atol=1e-6)


@pytest.mark.parametrize("background", [0, 3, -1000, np.nan])
@pytest.mark.parametrize("interpolation", ["linear", "cubic"])
def test_bools_of_images_are_those_of_the_nearest_point(interpolation, background):
    image = with_arrays(IMAGE)
    image.point_data["bytes"] = image["flags"].astype(np.uint8)
    options = {"interpolation": interpolation, "background": background, "cuts": CUT}
    found = image.mls.deform(REST, DEFORMED, **options)
    assert_types(found, image)
    options["background"] = 0 if np.isnan(background) else int(background != 0)
    nearest = image.mls.deform(REST, DEFORMED, label_arrays="bytes", **options)
    np.testing.assert_array_equal(found["flags"].view(np.uint8), nearest["bytes"])
    for name in ("flags", "vector flags", "cell flags"):
        assert set(np.unique(found[name].view(np.uint8))) <= {0, 1}
    assert found["flags"].any()
    assert not found["flags"].all()


@pytest.mark.parametrize("interpolation", ["nearest", "linear", "cubic"])
def test_complex_numbers_of_images_are_two_reals(interpolation):
    image = with_arrays(IMAGE)
    for name in ("single", "double"):
        image.point_data[f"real {name}"] = image[name].real.copy()
        image.point_data[f"imag {name}"] = image[name].imag.copy()
    found = image.mls.deform(REST, DEFORMED, interpolation=interpolation)
    for name in ("single", "double"):
        expected = found[f"real {name}"] + 1j * found[f"imag {name}"]
        np.testing.assert_array_equal(found[name], expected)


def test_blocks_keep_their_types_names_and_places():
    """Also where arrays of one name have different types."""
    other = IMAGE.copy()
    other.point_data["flags"] = other.points[:, 0].astype(np.uint8)
    other.cell_data["single"] = np.arange(other.n_cells) % 2 == 0
    other.point_data["cell flags"] = 10 * other.points[:, 0]
    blocks = pyvista.MultiBlock({"mesh": with_arrays(MESHES["surface"]), "none": None})
    inner = pyvista.MultiBlock({"image": with_arrays(IMAGE), "other": other})
    inner.append(None, "nothing")
    blocks.append(inner, "inner")
    found = blocks.mls.deform(REST, DEFORMED)
    assert found.keys() == ["mesh", "none", "inner"]
    assert found["inner"].keys() == ["image", "other", "nothing"]
    assert found["none"] is None
    assert found["inner"]["nothing"] is None
    for before, after in (
        (blocks["mesh"], found["mesh"]),
        (inner["image"], found["inner"]["image"]),
        (other, found["inner"]["other"]),
    ):
        assert type(after) is type(before)
        assert_types(after, before)
        assert after == before.mls.deform(REST, DEFORMED)
    assert found["inner"]["other"]["flags"].dtype == np.uint8
    interpolated = found["inner"]["other"].point_data["cell flags"]
    assert (interpolated % 10 != 0).any()


def test_the_field_keeps_field_data():
    for data in (with_arrays(MESHES["surface"]), with_arrays(IMAGE)):
        field = data.mls.field(REST, DEFORMED, sample_dimensions=(4, 4, 4))
        assert field.field_data["field flags"].dtype == bool
        np.testing.assert_array_equal(field.field_data["field phase"], [1 + 2j, 3j])
        assert field.user_dict == data.user_dict
        assert field.active_scalars_name == "BackwardDisplacement"
        assert field.active_vectors_name == "BackwardDisplacement"


def test_arrays_that_a_filter_writes_have_its_types():
    """Where the input has other ones of the same name."""
    mesh = MESHES["surface"].copy()
    mesh.point_data["ForwardDisplacement"] = mesh.points[:, 0] * 1j
    mesh.field_data["FailedInverses"] = np.array([True])
    found = mesh.mls.deform(REST, DEFORMED)
    assert found["ForwardDisplacement"].dtype == np.float32
    assert found["ForwardDisplacement"].shape == (mesh.n_points, 3)
    assert found.field_data["FailedInverses"].dtype == np.int64
    assert mesh["ForwardDisplacement"].dtype.kind == "c"


def test_the_input_is_not_changed():
    data = with_arrays(MESHES["surface"])
    data.user_dict = None  # copies of datasets with one are not equal to these
    copy = data.copy(deep=True)
    found = data.mls.deform(REST, DEFORMED)
    found.point_data.remove("flags")
    found.point_data["single"] = np.zeros(found.n_points)
    assert data == copy
    assert_types(data, copy)
