"""Arrays, colors and frames in files of meshes, and what the command says of them."""

import re

import numpy as np
import pytest
import slicer_peer
from file_fixtures import MESHES, assert_refused
from mesh_fixtures import FLAT_PINCHED, plate
from slicer_peer import needs_slicer
from vtk_fixtures import DEFORMED, REST, TYPES, add_array, polydata_of
from vtkmodules.vtkCommonCore import VTK_FLOAT, VTK_UNSIGNED_CHAR, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkStructuredGrid, vtkUnstructuredGrid
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
from vtkmodules.vtkFiltersSources import vtkConeSource, vtkSphereSource
from vtkmodules.vtkIOPLY import vtkPLYReader

from vtk_mls import Deformation, io
from vtk_mls.commands import cli
from vtk_mls.files import control_point_files, metadata
from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import set_positions
from vtk_mls.vtk.objects import output_of


def scan():
    return output_of(vtkSphereSource(), Center=(4, 4, 3), Radius=2)


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
    mesh = scan()
    mesh.SetVerts(polydata_of(REST, Verts=[[0], [1], [2]]).GetVerts())
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
    set_positions(handles, REST, VTK_FLOAT)
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
    mesh, points = polydata_of([(1, 2, 3)], Verts=[[0]]), vtkPoints()
    points.SetDataType(TYPES["short" if dtype == "int16" else "unsigned short"])
    points.InsertNextPoint(1, 2, 3)
    mesh.SetPoints(points)
    arrays.add_texts(mesh.GetFieldData(), "SPACE", ["RAS"])
    io.write_dataset(mesh, "a.vtp")
    found = io.read_dataset("a.vtp")
    assert found.GetPoint(0) == (-1, -2, 3)
    io.write_dataset(found, "b.vtp")
    assert io.read_dataset("b.vtp").GetPoint(0) == (-1, -2, 3)


# Frames: files that say SPACE=RAS, as 3D Slicer writes them

TURN = [-1, -1, 1]
OBJ = "# 3D Slicer output. SPACE={space}\nv 1 2 3\nv 4 5 6\nv 1 0 7\nf 1 2 3\n"


def points(mesh):
    return arrays.to_numpy(mesh.GetPoints().GetData())


def cone():
    source = output_of(vtkConeSource(), Center=(4, 3, 2), Direction=(1, 2, 3))
    return output_of(vtkPolyDataNormals(), InputData=source)


def a_mesh(suffix):
    return MESHES[suffix]() if suffix in (".vtu", ".vts") else cone()


@pytest.mark.parametrize("suffix", [".vtk", ".vtp", ".stl", ".ply", ".vtu", ".vts"])
@pytest.mark.parametrize("space", ["RAS", "LPS"])
def test_a_mesh_goes_back_into_its_frame(tmp_path, suffix, space):
    mesh = a_mesh(suffix)
    io.write_dataset(mesh, tmp_path / f"none{suffix}")
    before = io.read_dataset(tmp_path / f"none{suffix}")
    assert metadata.load(before, metadata.FILE_SPACE) == ()
    metadata.store(mesh, metadata.FILE_SPACE, [space])
    io.write_dataset(mesh, tmp_path / f"x{suffix}")
    assert not mesh.GetFieldData().HasArray("SPACE")
    content = (tmp_path / f"x{suffix}").read_bytes()
    assert b"SPACE" in content
    back = io.read_dataset(tmp_path / f"x{suffix}")
    np.testing.assert_array_equal(points(back), points(before))
    assert metadata.load(back, metadata.FILE_SPACE) == (space,)
    assert not back.GetFieldData().HasArray("SPACE")
    for name, other in (("RAS", "LPS"), ("LPS", "RAS")):  # the same numbers in the other frame
        if name == space and suffix in (".vtk", ".stl", ".ply"):
            old, new = f"SPACE={name}".encode(), f"SPACE={other}".encode()
            (tmp_path / f"y{suffix}").write_bytes(content.replace(old, new))
            turned = points(io.read_dataset(tmp_path / f"y{suffix}"))
            np.testing.assert_array_equal(turned, points(before) * TURN)


def test_vectors_and_normals_turn(tmp_path):
    mesh = cone()
    count = mesh.GetNumberOfPoints()
    for name in ("Displacement", "ForwardDisplacement", "flow", "color"):
        add_array(mesh.GetPointData(), name, np.tile([1.0, 2.0, 3.0], (count, 1)))
    mesh.GetPointData().SetActiveVectors("flow")
    metadata.store(mesh, metadata.FILE_SPACE, ["RAS"])
    io.write_dataset(mesh, tmp_path / "x.vtp")
    content = (tmp_path / "x.vtp").read_bytes()
    back = io.read_dataset(tmp_path / "x.vtp").GetPointData()
    for name in ("Displacement", "ForwardDisplacement", "flow", "color", "Normals"):
        values = [arrays.to_numpy(data.GetArray(name)) for data in (back, mesh.GetPointData())]
        np.testing.assert_array_equal(*values)
    # without a SPACE these are the numbers of the file
    (tmp_path / "x.vtp").write_bytes(content.replace(b'"SPACE"', b'"ECAPS"'))
    file = io.read_dataset(tmp_path / "x.vtp").GetPointData()
    for name in ("Displacement", "ForwardDisplacement", "flow", "color", "Normals"):
        values = [arrays.to_numpy(data.GetArray(name)) for data in (file, back)]
        np.testing.assert_array_equal(values[0], values[1] * (1 if name == "color" else TURN))


def test_obj(tmp_path):
    (tmp_path / "x.obj").write_text(OBJ.format(space="RAS"))
    mesh = io.read_dataset(tmp_path / "x.obj")
    np.testing.assert_array_equal(points(mesh), [(-1, -2, 3), (-4, -5, 6), (-1, 0, 7)])
    (tmp_path / "x.obj").write_text(OBJ.format(space="elsewhere"))
    np.testing.assert_array_equal(points(io.read_dataset(tmp_path / "x.obj"))[0], (1, 2, 3))
    sentence = r"x\.obj` cannot be used: its SPACE must be .* got LAS"
    assert_refused(tmp_path / "x.obj", OBJ.format(space="LAS"), sentence)


@pytest.mark.parametrize("suffix", [".vtu", ".stl"])
def test_a_mesh_is_deformed_in_lps(tmp_path, suffix):
    """Also where it is cut, and its type changes."""
    control_point_files.write(tmp_path / "h.csv", REST, DEFORMED)
    outputs = []
    for space in ("RAS", "LPS"):
        mesh = a_mesh(suffix)
        metadata.store(mesh, metadata.FILE_SPACE, [space])
        io.write_dataset(mesh, tmp_path / f"{space}{suffix}")
        arguments = [tmp_path / f"{space}{suffix}", tmp_path / "h.csv", tmp_path / f"out{suffix}"]
        options = ["--cut-plane", "4.3,0,0,1,0,0"]
        assert cli.main(["deform", *map(str, arguments), *options]) == 0
        outputs.append(io.read_dataset(tmp_path / f"out{suffix}"))
        assert metadata.load(outputs[-1], metadata.FILE_SPACE) == (space,)
    np.testing.assert_array_equal(points(outputs[0]), points(outputs[1]))
    assert np.abs(points(outputs[0])).max() > 1


WRITE = """
import sys, slicer, vtk
scene, source = slicer.vtkMRMLScene(), vtk.vtkConeSource()
source.SetCenter(10, 20, 30)
source.SetDirection(1, 2, 3)
source.Update()
for path in sys.argv[1:]:
    node, storage = slicer.vtkMRMLModelNode(), slicer.vtkMRMLModelStorageNode()
    node.SetAndObserveMesh(source.GetOutput())
    scene.AddNode(node)
    scene.AddNode(storage)
    space = "RAS" if "RAS" in path else "LPS"
    storage.SetCoordinateSystem(getattr(storage, "CoordinateSystem" + space))
    storage.SetFileName(path)
    assert storage.WriteData(node)
"""
READ = """
import sys, slicer
scene = slicer.vtkMRMLScene()
for path in sys.argv[1:]:
    node, storage = slicer.vtkMRMLModelNode(), slicer.vtkMRMLModelStorageNode()
    scene.AddNode(node)
    scene.AddNode(storage)
    storage.SetFileName(path)
    assert storage.ReadData(node)
    print("#", *node.GetMesh().GetBounds())
"""


def _bounds_in_slicer(paths):
    printed = slicer_peer.run(READ, *paths).splitlines()
    lines = [line.split()[1:] for line in printed if line.startswith("#")]
    return np.reshape(lines, (len(paths), 3, 2)).astype(float)


@needs_slicer
def test_slicer_and_we_agree(tmp_path):
    suffixes = (".vtk", ".vtp", ".stl", ".ply")
    paths = [tmp_path / f"x{space}{suffix}" for space in ("RAS", "LPS") for suffix in suffixes]
    slicer_peer.run(WRITE, *paths)
    before = _bounds_in_slicer(paths)
    np.testing.assert_allclose(before, np.tile(before[0], (8, 1, 1)), atol=1e-4)
    for path in paths:
        mesh = io.read_dataset(path)
        bounds = np.sort(np.reshape(mesh.GetBounds(), (3, 2)) * np.c_[TURN])
        np.testing.assert_allclose(bounds, before[0], atol=1e-4)
        io.write_dataset(mesh, path)
    np.testing.assert_allclose(_bounds_in_slicer(paths), before, atol=1e-4)
