"""PyVista's datasets deform themselves, as the filters do, and files of control points are read."""

from __future__ import annotations

import importlib
import inspect
from pathlib import Path

import numpy as np
import pytest
from pipelines import connect, control_points, update

from vtk_mls import Affine, Ball, BallMask, FixedFace, HalfPlane, RegionHandle
from vtk_mls.files import control_point_files
from vtk_mls.filters import MLSDeform, MLSDisplacementField, property_tables
from vtk_mls.vtk.objects import configured

pyvista = pytest.importorskip("pyvista", "0.48", reason="PyVista is not installed")
mls = importlib.import_module("vtk_mls.pyvista")  # registers `mesh.mls`

pytestmark = pytest.mark.usefixtures("numpy_computes")
REST = np.array([(x, y, z) for x in (-5, 5) for y in (-5, 5) for z in (-5, 5)], float)
DEFORMED = REST + (REST[:, :1] > 0) * [2.1, 0.7, 0]
CUT = HalfPlane((0, 0, 0), (1, 0, 0), (0, 0, 1))


def output_of(algorithm, dataset, **properties):
    """The output of a filter with control points of our own source."""
    connect(algorithm, dataset, control_points(REST, DEFORMED))
    algorithm.AddCut(CUT)
    return pyvista.wrap(update(configured(algorithm, **properties)))


DATASETS = {
    "image": lambda: pyvista.Wavelet(extent=(-8, 8, -8, 8, -8, 8)),
    "surface": lambda: pyvista.Sphere(radius=6),
    "grid": lambda: pyvista.Wavelet(extent=(-4, 4, -4, 4, -4, 4)).cast_to_unstructured_grid(),
}


@pytest.mark.parametrize("name", DATASETS)
def test_equal_to_the_filter_to_the_bit(name):
    dataset = DATASETS[name]()
    found = dataset.mls.deform(REST, DEFORMED, cuts=CUT, kind="similarity", alpha=1.5)
    expected = output_of(MLSDeform(), dataset, Kind="similarity", Alpha=1.5)
    assert type(found) is type(dataset)
    assert found == expected
    assert not np.array_equal(found.points, dataset.points) or name == "image"


def test_handles_masks_and_faces():
    mesh = DATASETS["surface"]()
    motion = np.array([[0, -1, 0, 1], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    turned = mesh.mls.deform(handles=RegionHandle(Ball((0, 0, 0), 7), motion))
    np.testing.assert_allclose(
        turned.points, mesh.transform(motion, inplace=False).points, atol=1e-4
    )
    options = {"mask": BallMask((0, 0, 0), 1, 1), "constraints": [FixedFace(CUT.plane, 1)]}
    np.testing.assert_array_equal(mesh.mls.deform(REST, DEFORMED, **options).points, mesh.points)
    handles = pyvista.Sphere(radius=7)
    handles["Displacement"] = handles.transform(motion, inplace=False).points - handles.points
    as_cells = mesh.mls.deform(handles, handle_shapes="cells")
    np.testing.assert_allclose(as_cells.points, turned.points, atol=1e-4)
    with pytest.raises(TypeError, match="`rest` is missing: .*`handles`"):
        mesh.mls.deform()
    with pytest.raises(ValueError, match="`handles` must be .*RegionHandle.*3"):
        mesh.mls.deform(handles=[3])


def test_the_field_is_that_of_the_filter():
    mesh = DATASETS["surface"]()
    found = mesh.mls.field(REST, DEFORMED, cuts=[CUT], sample_dimensions=(5, 6, 7), inverse=True)
    expected = output_of(MLSDisplacementField(), mesh, SampleDimensions=(5, 6, 7), Inverse=True)
    assert found == expected
    assert found.dimensions == (5, 6, 7)


def test_a_surface_cuts():
    image = DATASETS["image"]()
    size = {"i_size": 10, "j_size": 100, "i_resolution": 1, "j_resolution": 1}
    plane = pyvista.Plane(center=(0, 0, 5), direction=(1, 0, 0), **size)
    assert image.mls.deform(REST, DEFORMED, cuts=plane)["Void"].any()
    assert "Void" not in image.mls.deform(REST, DEFORMED).point_data


def test_signatures_have_the_properties_with_their_defaults():
    parameters = inspect.signature(pyvista.PolyData.mls.deform).parameters
    table = {prop.option: prop.default for prop in property_tables.DEFORM}
    for name in ("kind", "alpha", "cut_frame", "output_grid", "generate_jacobian", "device"):
        assert parameters[name].default == table[name]
    assert not parameters.keys() & {"cut_type", "rest_points", "options"}
    assert "similarity allows a change of size" in pyvista.PolyData.mls.deform.__doc__


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        ((REST, DEFORMED), {"knd": "rigid"}, "`knd` is no option; there are kind, "),
        ((REST, DEFORMED), {"kind": "soft"}, "`kind` must be one of affine, .* got 'soft'"),
        ((REST, DEFORMED), {"output_dimensions": 3}, r"`output_dimensions` must be \(nx, ny, nz\)"),
        ((REST, DEFORMED), {"label_arrays": "no"}, "`label_arrays` names `no`, .* has `RTData`"),
        ((REST, DEFORMED), {"weights": [1]}, "`weights` must be one number per control point"),
        ((REST, DEFORMED), {"cuts": 3}, "`cuts` must be Plane, HalfPlane or Surface, got 3"),
        ((REST,), {}, "`deformed` is missing"),
        ((REST, DEFORMED[:3]), {}, r"`deformed` must have the shape \(8, 3\) of `rest`"),
        ((pyvista.PolyData(REST),), {}, "`rest` has no numeric point array `Displacement`"),
    ],
)
def test_errors_name_the_argument(arguments, options, message):
    with pytest.raises((TypeError, ValueError), match=message):
        DATASETS["image"]().mls.deform(*arguments, **options)


def test_control_points_are_read(tmp_path):
    path = tmp_path / "handles.csv"
    np.savetxt(path, np.hstack([REST, DEFORMED]), delimiter=",")
    handles = mls.read(path)
    np.testing.assert_array_equal(handles.points, REST)
    np.testing.assert_allclose(handles["Displacement"], DEFORMED - REST)
    mesh = DATASETS["surface"]()
    assert mesh.mls.deform(handles) == mesh.mls.deform(REST, DEFORMED)


def test_markups_in_two_files(tmp_path):
    for name, points in (("p", REST), ("q", DEFORMED)):
        control_point_files.write(tmp_path / f"{name}.mrk.json", points, points)
    handles = mls.read(tmp_path / "p.mrk.json", deformed=tmp_path / "q.mrk.json")
    np.testing.assert_allclose(handles["Displacement"], DEFORMED - REST)


def test_pyvista_reads_formats_of_control_points(tmp_path):
    control_point_files.write(tmp_path / "p.fcsv", REST, REST)
    np.testing.assert_allclose(pyvista.read(tmp_path / "p.fcsv").points, REST, atol=1e-5)


@pytest.mark.parametrize("name", ["table.csv", "table.txt", "other.json"])
def test_ambiguous_formats_are_not_registered(name, tmp_path):
    (tmp_path / name).write_text("1,2,3\n")
    with pytest.raises(Exception, match="meshio|not able to be automatically read|file type"):
        pyvista.read(tmp_path / name)


def test_entry_points_exist():
    from vtk_mls.pyvista import readers

    tomllib = pytest.importorskip("tomllib", reason="Python has no tomllib")
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]
    points = project["entry-points"]
    assert points["pyvista.accessors"] == {"mls": "vtk_mls.pyvista"}
    assert points["pyvista.plotter_components"] == {"mls": "vtk_mls.pyvista"}
    assert tuple(points["pyvista.readers"]) == readers.ENDINGS
    assert set(points["pyvista.readers"].values()) == {"vtk_mls.pyvista.readers:read"}


def selected(kind):
    """Points of a sphere with their displacements, as PyVista's own filters give them."""
    sphere = pyvista.Sphere(radius=6)
    sphere["height"] = sphere.points[:, 2]
    top = sphere.points[:, 2] > 2
    extracted = sphere.extract_points(top, include_cells=False)
    makers = {
        "extracted": lambda: extracted,
        "threshold": lambda: sphere.threshold(2.0, scalars="height"),
        "point set": lambda: extracted.cast_to_poly_points().cast_to_pointset(),
        "structured": lambda: pyvista.StructuredGrid(*sphere.points[:24].reshape(3, 2, 4, 3).T[:3]),
    }
    handles = makers[kind]()
    handles["Displacement"] = 0.1 * handles.points
    return handles


@pytest.mark.parametrize("kind", ["extracted", "threshold", "point set", "structured"])
def test_control_points_of_a_selection(kind):
    """As the positions themselves, alone, with `deformed`, and for the field."""
    handles, mesh = selected(kind), DATASETS["surface"]()
    moved = handles.points + handles["Displacement"]
    expected = mesh.mls.deform(np.array(handles.points, float), np.array(moved, float)).points
    for arguments in ((handles,), (handles, moved), (handles, pyvista.PolyData(moved))):
        found = mesh.mls.deform(*arguments).points
        np.testing.assert_allclose(found, expected, atol=1e-5)
    field = mesh.mls.field(handles, sample_dimensions=(3, 3, 3))
    assert np.abs(field["BackwardDisplacement"]).max() > 0.1


@pytest.mark.parametrize(
    ("handles", "error", "sentence"),
    [
        (pyvista.Sphere, ValueError, "`rest` has no numeric point array `Displacement`; it has"),
        (pyvista.ImageData, TypeError, "`rest` must be positions or a dataset with points of its"),
        (pyvista.MultiBlock, TypeError, "`rest` must be positions or a dataset with points of its"),
    ],
)
def test_invalid_control_points_are_named(handles, error, sentence):
    with pytest.raises(error, match=sentence):
        DATASETS["surface"]().mls.deform(handles())


def test_an_initial_transform_is_an_option():
    mesh, shift = pyvista.Sphere(), np.eye(4)
    shift[0, 3] = 2
    bent = mesh.mls.deform(
        [(2, 0, 0)], [(2, 1, 0)], initial_transform=Affine(shift), device="reference"
    )
    np.testing.assert_allclose(bent.points, mesh.points + [2, 1, 0], atol=1e-6)


def test_a_reference_is_an_option():
    image, target = pyvista.ImageData(dimensions=(5, 5, 5)), pyvista.ImageData(dimensions=(3, 4, 2))
    target.origin = 101, 0, 0
    image["x"] = image.points[:, 0]
    moved = image.mls.deform([(0, 0, 0)], [(100, 0, 0)], reference=target, device="reference")
    assert moved.dimensions == target.dimensions
    np.testing.assert_allclose(moved["x"], target.points[:, 0] - 100)
