"""Colors in .ply, what the command says of other arrays, and of cells that are inside out."""

import re

import numpy as np
import pytest
from mesh_fixtures import FLAT_PINCHED, plate
from vtk_fixtures import DEFORMED, REST, TYPES, add_array
from vtkmodules.vtkCommonCore import VTK_UNSIGNED_CHAR, vtkPoints
from vtkmodules.vtkCommonDataModel import (
    vtkCellArray,
    vtkPolyData,
    vtkStructuredGrid,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkIOPLY import vtkPLYReader

from vtk_mls import Deformation, io
from vtk_mls.commands import cli
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import output_of


def scan():
    mesh = vtkPolyData()
    mesh.ShallowCopy(output_of(vtkSphereSource(), Center=(4, 4, 3), Radius=2))
    return mesh


def colors(rng, count, components):
    return rng.integers(0, 256, (count, components))


def read_by_vtk(mesh, tmp_path):
    """The mesh of a file that we write, as VTK reads it."""
    io.write_dataset(mesh, tmp_path / "a.ply")
    return output_of(vtkPLYReader(), FileName=str(tmp_path / "a.ply"))


def values(attributes, name):
    return arrays.to_numpy(attributes.GetArray(name))


@pytest.mark.parametrize("name", ["RGB", "RGBA", "color of the scanner"])
@pytest.mark.parametrize("components", [3, 4])
@pytest.mark.parametrize("of", ["Point", "Cell"])
def test_colors_stay(of, components, name, tmp_path, rng):
    mesh = scan()
    rows = colors(rng, getattr(mesh, f"GetNumberOf{of}s")(), components)
    add_array(getattr(mesh, f"Get{of}Data")(), name, rows, VTK_UNSIGNED_CHAR)
    data = getattr(read_by_vtk(mesh, tmp_path), f"Get{of}Data")()
    np.testing.assert_array_equal(values(data, "RGB" if components == 3 else "RGBA"), rows)


def test_colors_of_points_and_of_cells(tmp_path, rng):
    """Of different depth; vertices stand before the polygons."""
    mesh, vertices = scan(), vtkCellArray()
    for i in range(3):
        vertices.InsertNextCell(1, [i])
    mesh.SetVerts(vertices)
    of_points = colors(rng, mesh.GetNumberOfPoints(), 3)
    of_cells = colors(rng, mesh.GetNumberOfCells(), 4)
    add_array(mesh.GetPointData(), "paint", of_points, VTK_UNSIGNED_CHAR)
    add_array(mesh.GetCellData(), "ink", of_cells, VTK_UNSIGNED_CHAR)
    output = read_by_vtk(mesh, tmp_path)
    found = values(output.GetPointData(), "RGBA")
    np.testing.assert_array_equal(found[:, :3], of_points)
    assert (found[:, 3] == 255).all()
    np.testing.assert_array_equal(values(output.GetCellData(), "RGBA"), of_cells[3:])
    assert output.GetPointData().GetNormals() is not None


def test_of_several_colors_the_active_ones_count(tmp_path, rng):
    mesh = scan()
    rows = [colors(rng, mesh.GetNumberOfPoints(), 3) for _ in range(3)]
    for name, color in zip(("first", "RGB", "last"), rows):
        add_array(mesh.GetPointData(), name, color, VTK_UNSIGNED_CHAR)
    data = read_by_vtk(mesh, tmp_path).GetPointData()
    np.testing.assert_array_equal(values(data, "RGB"), rows[1])
    mesh.GetPointData().SetActiveScalars("last")
    data = read_by_vtk(mesh, tmp_path).GetPointData()
    np.testing.assert_array_equal(values(data, "RGB"), rows[2])


@pytest.mark.parametrize(
    ("output", "sentence"),
    [
        ("o.ply", "; without `temperature`, `part`, which .ply cannot hold\n"),
        ("o.stl", "; without `Normals`, `RGB`, `temperature`, `part`, which .stl cannot hold\n"),
        ("o.vtp", ""),
    ],
)
def test_losses_of_a_file_format_are_reported(output, sentence, folder, capsys, rng):
    mesh = scan()
    rows = colors(rng, mesh.GetNumberOfPoints(), 3)
    add_array(mesh.GetPointData(), "RGB", rows, VTK_UNSIGNED_CHAR)
    add_array(mesh.GetPointData(), "temperature", np.arange(mesh.GetNumberOfPoints()))
    add_array(mesh.GetCellData(), "part", np.arange(mesh.GetNumberOfCells()), TYPES["int"])
    io.write_dataset(mesh, "scan.vtp")
    assert cli.main(["deform", "scan.vtp", "handles.csv", output]) == 0
    printed = capsys.readouterr().out
    assert printed.endswith(sentence or "rigid\n")
    if output == "o.ply":
        data = io.read_dataset("o.ply").GetPointData()
        np.testing.assert_array_equal(values(data, "RGB"), rows)


@pytest.mark.parametrize("push", [0.0, 1.8])
def test_the_command_counts_cells_that_are_inside_out(push, folder, capsys):
    io.write_dataset(plate(), "plate.vtu")
    moved = FLAT_PINCHED.copy()
    moved[4:, 0] += (push, -push)
    np.savetxt("p.csv", np.hstack([FLAT_PINCHED, moved]), "%.17g", ",")
    # alpha 2 turns the plate over between the two handles, which areas in its plane cannot tell
    options = ["--alpha", "1"]
    arguments = ["deform", "plate.vtu", "p.csv", "o.vtu", *options]
    assert cli.main([*arguments, "--allow-identity"]) == 0
    printed = capsys.readouterr().out
    output = io.read_dataset("o.vtu")
    x = arrays.to_numpy(output.GetPoints().GetData()).reshape(21, 21, 3)
    corners = [x[:-1, :-1], x[:-1, 1:], x[1:, 1:], x[1:, :-1]]
    edges = [b - a for a, b in zip(corners, corners[1:] + corners[:1])]
    turns = [np.cross(a, b)[..., 2] for a, b in zip(edges, edges[1:] + edges[:1])]
    count = (np.min(turns, axis=0) <= 0).sum()
    assert (count > 0) == (push > 0)
    assert ("inside out" in printed) == (push > 0)
    if push:
        assert f"; {count} cells inside out (at most --blend " in printed
        blend = float(re.search(r"at most --blend (.+) inverts no cell\)", printed)[1])
        for more in (0, 0.01):
            assert cli.main([*arguments, "--blend", str(blend + more)]) == 0
            assert ("inside out" in capsys.readouterr().out) == (more > 0)
    # the file is as it was before anybody counted
    assert not output.GetPointData().HasArray("JacobianDeterminant")
    for name in ("InvertedCells", "UncheckedCells", "LargestBlend"):
        assert not output.GetFieldData().HasArray(name)


@pytest.mark.parametrize("ending", [".vtu", ".vts", ".vtk"])
def test_control_points_of_any_point_set(ending, folder):
    """As those of .vtp."""
    handles = vtkUnstructuredGrid() if ending != ".vts" else vtkStructuredGrid()
    points = vtkPoints()
    for place in REST:
        points.InsertNextPoint(place)
    handles.SetPoints(points)
    add_array(handles.GetPointData(), "Displacement", DEFORMED - REST)
    if ending == ".vts":
        handles.SetDimensions(2, 2, 2)
    io.write_dataset(handles, f"h{ending}")
    read = io.read_control_points(f"h{ending}")
    found = arrays.control_points(read, "Displacement")
    np.testing.assert_allclose(found[0], REST, atol=1e-6)
    np.testing.assert_allclose(found[1], DEFORMED, atol=1e-6)


def test_integer_points_of_files(folder, capsys):
    text = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 int\n"
    (folder / "a.vtk").write_text(f"{text}1 1 1 7 1 1 1 7 1\nPOLYGONS 1 4\n3 0 1 2\n")
    assert cli.main(["deform", "a.vtk", "handles.csv", "o.vtp"]) == 0
    assert "3 points, 1 cells" in capsys.readouterr().out
    points = io.read_dataset("o.vtp").GetPoints()
    expected = Deformation(REST, DEFORMED, device="reference").forward(REST[[0, 1, 2]])
    np.testing.assert_allclose(arrays.to_numpy(points.GetData()), expected, atol=5e-5)


@pytest.mark.parametrize("dtype", ["int16", "uint16"])
def test_integer_points_in_another_frame(dtype, folder):
    """Of 3D Slicer's RAS: unsigned numbers have no opposite."""
    mesh, points = vtkPolyData(), vtkPoints()
    points.SetDataType(TYPES["short" if dtype == "int16" else "unsigned short"])
    points.InsertNextPoint(1, 2, 3)
    mesh.SetPoints(points)
    cells = vtkCellArray()
    cells.InsertNextCell(1, [0])
    mesh.SetVerts(cells)
    arrays.add_texts(mesh.GetFieldData(), "SPACE", ["RAS"])
    io.write_dataset(mesh, "a.vtp")
    found = io.read_dataset("a.vtp")
    assert found.GetPoint(0) == (-1, -2, 3)
    io.write_dataset(found, "b.vtp")
    assert io.read_dataset("b.vtp").GetPoint(0) == (-1, -2, 3)
