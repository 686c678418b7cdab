"""Meshes whose files say SPACE=RAS, as 3D Slicer writes them."""

import numpy as np
import pytest
import slicer_peer
from file_fixtures import MESHES
from slicer_peer import needs_slicer
from vtk_fixtures import DEFORMED, REST, add_array
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
from vtkmodules.vtkFiltersSources import vtkConeSource

from vtk_mls import io
from vtk_mls.commands.cli import main
from vtk_mls.files import control_point_files, metadata
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import output_of

TURN = [-1, -1, 1]
OBJ = "# 3D Slicer output. SPACE={space}\nv 1 2 3\nv 4 5 6\nv 1 0 7\nf 1 2 3\n"
SUFFIXES = [".vtk", ".vtp", ".stl", ".ply", ".vtu", ".vts"]


def points(mesh):
    return arrays.to_numpy(mesh.GetPoints().GetData())


def cone():
    source = output_of(vtkConeSource(), Center=(4, 3, 2), Direction=(1, 2, 3))
    return output_of(vtkPolyDataNormals(), InputData=source)


def a_mesh(suffix):
    return MESHES[suffix]() if suffix in (".vtu", ".vts") else cone()


@pytest.mark.parametrize("suffix", SUFFIXES)
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
    for name in ("Displacement", "flow", "color"):
        add_array(mesh.GetPointData(), name, np.tile([1.0, 2.0, 3.0], (count, 1)))
    mesh.GetPointData().SetActiveVectors("flow")
    metadata.store(mesh, metadata.FILE_SPACE, ["RAS"])
    io.write_dataset(mesh, tmp_path / "x.vtp")
    content = (tmp_path / "x.vtp").read_bytes()
    back = io.read_dataset(tmp_path / "x.vtp").GetPointData()
    for name in ("Displacement", "flow", "color", "Normals"):
        values = [arrays.to_numpy(data.GetArray(name)) for data in (back, mesh.GetPointData())]
        np.testing.assert_array_equal(*values)
    # without a SPACE these are the numbers of the file
    (tmp_path / "x.vtp").write_bytes(content.replace(b'"SPACE"', b'"ECAPS"'))
    file = io.read_dataset(tmp_path / "x.vtp").GetPointData()
    for name, turn in (("Displacement", TURN), ("flow", TURN), ("Normals", TURN), ("color", 1)):
        values = [arrays.to_numpy(data.GetArray(name)) for data in (file, back)]
        np.testing.assert_array_equal(values[0], values[1] * turn)


def test_obj(tmp_path):
    (tmp_path / "x.obj").write_text(OBJ.format(space="RAS"))
    mesh = io.read_dataset(tmp_path / "x.obj")
    np.testing.assert_array_equal(points(mesh), [(-1, -2, 3), (-4, -5, 6), (-1, 0, 7)])
    (tmp_path / "x.obj").write_text(OBJ.format(space="elsewhere"))
    np.testing.assert_array_equal(points(io.read_dataset(tmp_path / "x.obj"))[0], (1, 2, 3))
    (tmp_path / "x.obj").write_text(OBJ.format(space="LAS"))
    with pytest.raises(ValueError, match=r"x\.obj` cannot be used: its SPACE must be .* got LAS"):
        io.read_dataset(tmp_path / "x.obj")


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
        assert main(["deform", *map(str, arguments), *options]) == 0
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
