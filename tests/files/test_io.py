"""Files keep values, types and places, and say what is wrong with them."""

import re

import numpy as np
import pytest
from file_fixtures import MESHES, assert_refused, assert_same_place, image_with, scalars
from vtk_fixtures import TURNED, TYPES, add_array, make_image
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkImageData
from vtkmodules.vtkFiltersCore import vtkStripper
from vtkmodules.vtkFiltersSources import vtkSphereSource

from vtk_mls import io
from vtk_mls.vtk.objects import output_of

SUFFIXES = (".vti", ".vtk", ".mha", ".mhd", ".nii", ".nii.gz", ".nrrd", ".nhdr")


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("name", ["unsigned char", "short", "int", "float", "double"])
def test_values_and_places_come_back(tmp_path, suffix, name, rng):
    for shape, direction in (((24,), TURNED), ((24, 3), TURNED * [1, -1, 1])):
        place = {} if suffix == ".vtk" else {"direction": direction}
        image = image_with(rng.integers(0, 200, shape), TYPES[name], start=(2, -1, 3), **place)
        io.write_dataset(image, tmp_path / f"x{suffix}")
        back = io.read_dataset(str(tmp_path / f"x{suffix}"))
        assert back.GetPointData().GetScalars().GetDataType() == TYPES[name]
        np.testing.assert_array_equal(scalars(back), scalars(image))
        # NIfTI has float32 spacings
        assert_same_place(back, image, 1e-5 if ".nii" in suffix else 1e-12)


def test_legacy_files_refuse_a_direction_rather_than_lose_it(tmp_path):
    image = image_with(np.arange(24), TYPES["short"], direction=TURNED)
    with pytest.raises(ValueError, match=r"`.*x\.vtk` cannot hold the image's direction matrix"):
        io.write_dataset(image, tmp_path / "x.vtk")


def test_everything_fits_into_vti(tmp_path):
    image = image_with(np.arange(24), TYPES["id type"], start=(3, 4, 5))
    add_array(image.GetCellData(), "cells", np.arange(6), TYPES["char"])
    add_array(image.GetFieldData(), "field", [3])
    io.write_dataset(image, tmp_path / "x.vti")
    back = io.read_dataset(tmp_path / "x.vti")
    assert back.GetExtent() == image.GetExtent()
    assert back.GetCellData().GetArray("cells").GetNumberOfTuples() == 6
    assert back.GetFieldData().GetArray("field").GetValue(0) == 3


def test_the_only_array_is_written_where_there_is_room_for_one(tmp_path):
    image = make_image((4, 3, 2))
    add_array(image.GetPointData(), "a", np.arange(24), TYPES["float"])
    for suffix in (".mha", ".nii"):
        io.write_dataset(image, tmp_path / f"x{suffix}")
        np.testing.assert_array_equal(
            scalars(io.read_dataset(tmp_path / f"x{suffix}")), np.arange(24)
        )
    add_array(image.GetPointData(), "b", np.arange(24), TYPES["float"])
    with pytest.raises(ValueError, match=r"x\.mha` can hold one array, and none of `a`, `b` is"):
        io.write_dataset(image, tmp_path / "x.mha")


def test_every_reading_error_names_the_file(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"there is no file `.*missing\.vti`"):
        io.read_dataset(tmp_path / "missing.vti")
    (tmp_path / "x.png").touch()
    with pytest.raises(
        ValueError, match=r"cannot read an image or a mesh from `.*x\.png`.* \.vti, .*\.vtk,"
    ):
        io.read_dataset(tmp_path / "x.png")
    for suffix in SUFFIXES:
        path = tmp_path / f"broken{suffix}"
        assert_refused(path, b"nothing of use\n" * 20, re.escape(f"broken{suffix}`"))


@pytest.mark.parametrize("suffix", MESHES)
def test_meshes_come_back(suffix, tmp_path):
    mesh = MESHES[suffix]()
    io.write_dataset(mesh, tmp_path / f"x{suffix}")
    back = io.read_dataset(tmp_path / f"x{suffix}")
    assert back.GetClassName() == mesh.GetClassName()
    assert back.GetNumberOfCells() == mesh.GetNumberOfCells() > 0
    np.testing.assert_allclose(back.GetBounds(), mesh.GetBounds(), atol=1e-6)


def test_every_writing_error_names_the_file(tmp_path):
    image = image_with(np.arange(24), TYPES["short"])
    with pytest.raises(ValueError, match=r"cannot write an image to `.*x\.png`: .*\.nii\.gz"):
        io.write_dataset(image, tmp_path / "x.png")
    with pytest.raises(FileNotFoundError, match="there is no folder `.*none` to write `x.vti` in"):
        io.write_dataset(image, tmp_path / "none" / "x.vti")
    (tmp_path / "x.vti").mkdir()
    with pytest.raises((OSError, ValueError), match=r"x\.vti"):
        io.write_dataset(image, tmp_path / "x.vti")


def _tetrahedron(corners="0 1 2 3", kind=10, size=4, values="5"):
    return (
        "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n"
        f"0 0 0  1 0 0  0 1 0  0 0 1\nCELLS 1 {size + 1}\n{size} {corners}\nCELL_TYPES 1\n{kind}\n"
        f"CELL_DATA 1\nSCALARS a float\nLOOKUP_TABLE default\n{values}\n"
    )


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"corners": "0 1 2 9"}, "point ids of its cells must be from 0 to 3, got 0 to 9"),
        ({"corners": "0 1 2 -1"}, "point ids of its cells must be from 0 to 3, got -1 to 2"),
        ({"corners": "0 1 2", "size": 3}, "a vtkTetra has 4 points, got one with 3"),
        ({"kind": 12}, "a vtkHexahedron has 8 points, got one with 4"),
        ({"kind": 71, "corners": "0 1 2", "size": 3}, "a vtkLagrangeTetra has 4 points, got"),
        ({"kind": 200}, "type 200|type: 200"),
    ],
)
def test_meshes_that_would_crash_a_filter(tmp_path, change, sentence):
    path = tmp_path / "x.vtk"
    path.write_text(_tetrahedron())
    assert io.read_dataset(path).GetNumberOfCells() == 1
    assert_refused(path, _tetrahedron(**change), rf"x\.vtk`.*{sentence}")


def test_polydata_that_would_crash_a_filter(tmp_path):
    head = "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n"
    for kind in ("VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS"):
        text = head + f"0 0 0  1 0 0  0 1 0\n{kind} 1 4\n3 0 1 3\n"
        sentence = r"x\.vtk` cannot be used: .*from 0 to 2, got 0 to 3"
        assert_refused(tmp_path / "x.vtk", text, sentence)


def test_arrays_and_axes_of_another_length(tmp_path):
    path = tmp_path / "x.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 0 1\nf 1//1 2//2 3//2\n")
    io.read_dataset(path)
    sentence = r"x\.obj` cannot be used: array `.*` must have one tuple"
    assert_refused(path, path.read_text().replace("3//2", "3//3"), sentence)
    axes = "X_COORDINATES 2 float\n0 1\nY_COORDINATES 2 float\n0 1\n"
    text = "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET RECTILINEAR_GRID\n"
    sentence = r"x\.vtk` cannot be used: .* \(2, 2, 2\) coordinates"
    assert_refused(tmp_path / "x.vtk", f"{text}DIMENSIONS 2 2 2\n{axes}", sentence)


def test_a_legacy_file_that_is_no_text(tmp_path):
    path = tmp_path / "x.vtk"
    data = _tetrahedron().encode().replace(b"CELLS", b"\xff\xfe\x01")
    assert_refused(path, data, r"x\.vtk`: VTK says: .*\ufffd\ufffd\?")
    data = b"# vtk DataFile Version 3.0\n\xff\xfe\nASCII\nDATASET \xff\xfe\x01\n"
    assert_refused(path, data, r"x\.vtk` holds no image and no mesh")


def test_errors_of_vtk_are_one_short_line(tmp_path):
    text = _tetrahedron().replace("CELLS", 500 * "x")
    assert_refused(tmp_path / "x.vtk", text, r"x\.vtk`: VTK says")
    text = "<VTKFile type='ImageData'><ImageData"
    assert_refused(tmp_path / "x.vti", text, r"x\.vti`: VTK says: (?!.*0x).*[Pp]ars")


def test_control_points_that_cannot_be_used(tmp_path):
    path = tmp_path / "x.vtp"
    io.write_handles(path, [(1, 2, 3)], [(1.5, 2, 3)])
    path.write_text(path.read_text().replace("Displacement", "Moved"))
    with pytest.raises(ValueError, match=r"x\.vtp` cannot be used: .* `Displacement`.*`Moved`"):
        io.read_control_points(path)
    polydata = io.read_dataset(path)
    add_array(polydata.GetPointData(), "Displacement", [(np.nan, 0, 0)])
    io.write_dataset(polydata, path)
    with pytest.raises(ValueError, match=r"x\.vtp` cannot be used: `deformed` must be finite"):
        io.read_control_points(path)


def test_cuts_are_the_connected_surfaces(tmp_path):
    path = tmp_path / "x.stl"
    facet = "facet normal 1 0 0\nouter loop\nvertex {0} 0 0\nvertex {0} 1 0\nvertex {0} 0 1\n"
    facets = [facet.format(x) + "endloop\nendfacet\n" for x in (0, 5)]
    path.write_text(f"solid cut\n{''.join(facets)}endsolid cut\n")
    assert [cut.points[0, 0] for cut in io.read_cuts(path)] == [0, 5]
    path.write_text(f"solid cut\n{facets[0].replace('1 0 0', '1 nan 0')}endsolid cut\n")
    path.write_text(path.read_text().replace("vertex 0 1 0", "vertex 0 0 2"))
    with pytest.raises(ValueError, match=r"x\.stl` cannot be used: `Cuts` has no"):
        io.read_cuts(path)


@pytest.mark.parametrize("suffix", [".ply", ".stl"])
def test_strips_of_triangles_are_written_as_triangles(tmp_path, suffix):
    settings = {"InputData": output_of(vtkSphereSource()), "PassThroughCellIds": False}
    strips = output_of(vtkStripper(), **settings)
    assert strips.GetNumberOfStrips() > 0
    assert strips.GetNumberOfPolys() == 0
    io.write_dataset(strips, tmp_path / f"x{suffix}")
    back = io.read_dataset(tmp_path / f"x{suffix}")
    assert back.GetNumberOfPolys() == output_of(vtkSphereSource()).GetNumberOfPolys()


@pytest.mark.parametrize(
    ("suffix", "kind"), [(".ply", "lines"), (".stl", "lines"), (".stl", "verts")]
)
def test_cells_that_a_format_cannot_hold_are_not_left_out(tmp_path, suffix, kind):
    polydata, cells = output_of(vtkSphereSource()), vtkCellArray()
    cells.InsertNextCell(2, [0, 1])
    {"lines": polydata.SetLines, "verts": polydata.SetVerts}[kind](cells)
    with pytest.raises(ValueError, match=rf"cannot hold {kind}; write \.vtp"):
        io.write_dataset(polydata, tmp_path / f"x{suffix}")
    assert not list(tmp_path.iterdir())


def test_the_output_of_a_filter_that_failed_is_not_written(tmp_path):
    path = tmp_path / "out.nii.gz"
    with pytest.raises(ValueError, match="is not written: the image is empty; has its filter"):
        io.write_dataset(vtkImageData(), path)
    assert not path.exists()
