"""Files of simulation programs and of several blocks: read, deformed, written, read by VTK again.

`data/box.cgns`, two tetrahedra with a pressure, was made with h5py by the CGNS standard's mapping
to HDF5.
"""

import shutil
from pathlib import Path

import meshio
import numpy as np
import pytest
from command_fixtures import WITHOUT, run
from mesh_fixtures import explicit_structured
from vtk_fixtures import add_array, make_image
from vtkmodules.vtkCommonDataModel import (
    vtkCompositeDataSet,
    vtkMultiBlockDataSet,
    vtkPartitionedDataSet,
    vtkPartitionedDataSetCollection,
    vtkTable,
)
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkIOHDF import vtkHDFWriter
from vtkmodules.vtkIOIOSS import vtkIOSSWriter
from vtkmodules.vtkIOParallel import vtkEnSightWriter
from vtkmodules.vtkIOParallelXML import (
    vtkXMLPartitionedDataSetCollectionWriter,
    vtkXMLPImageDataWriter,
    vtkXMLPPolyDataWriter,
    vtkXMLPUnstructuredGridWriter,
)
from vtkmodules.vtkIOXML import vtkXMLMultiBlockDataWriter

from vtk_mls import Deformation, io
from vtk_mls.commands.cli import main
from vtk_mls.files.block_files import blocks, leaves
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured, output_of

DATA = Path(__file__).parents[1] / "data"
REST = np.array([(0.0, 0, 0), (4, 0, 0), (0, 4, 0), (0, 0, 4), (4, 4, 4)])
DEFORMED = REST + [(0, 0, 0), (0, 1, 0), (0, 0, 0), (1, 0, 0), (0, 0, 0.5)]
POINTS, CORNERS = REST, [(0, 1, 2, 3), (1, 2, 3, 4)]
VALUES = np.arange(1.0, 6)
BY_MESHIO = [".msh", ".inp", ".bdf", ".med", ".mesh", ".vol", ".su2", ".avs"]
WITH_VALUES = {".med", ".msh", ".avs", ".cgns", ".xdmf", ".pvtu", ".vtkhdf"}

XDMF = f"""<?xml version="1.0"?><Xdmf Version="2.0"><Domain><Grid Name="box">
<Topology TopologyType="Tetrahedron" NumberOfElements="2"><DataItem Dimensions="2 4"
 NumberType="Int" Format="XML">{" ".join(map(str, np.ravel(CORNERS)))}</DataItem></Topology>
<Geometry GeometryType="XYZ"><DataItem Dimensions="5 3" Format="XML">
{" ".join(map(str, POINTS.ravel()))}</DataItem></Geometry>
<Attribute Name="Pressure" Center="Node"><DataItem Dimensions="5" Format="XML">1 2 3 4 5</DataItem>
</Attribute></Grid></Domain></Xdmf>
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty folder, but for handles.csv, as the current one."""
    monkeypatch.chdir(tmp_path)
    np.savetxt("handles.csv", np.hstack([REST, DEFORMED]), "%.17g", ",")
    return tmp_path


def tetrahedra():
    """The mesh that is in every file."""
    meshio.write("tetrahedra.vtu", _by_meshio())
    return io.read_dataset("tetrahedra.vtu")


def _by_meshio():
    return meshio.Mesh(POINTS, [("tetra", CORNERS)], point_data={"Pressure": VALUES})


def image():
    image = make_image((4, 3, 5), start=(1, 0, 0))
    add_array(image.GetPointData(), "values", np.arange(60.0))
    return image


def sphere():
    return output_of(vtkSphereSource(), Center=(2, 2, 2))


def many_blocks():
    """Blocks with names, one of them empty, one of blocks again."""
    inner, outer = vtkMultiBlockDataSet(), vtkMultiBlockDataSet()
    inner.SetBlock(0, sphere())
    for number, (name, block) in enumerate(
        {"mesh": tetrahedra(), "none": None, "image": image(), "more": inner}.items()
    ):
        outer.SetBlock(number, block)
        outer.GetMetaData(number).Set(vtkCompositeDataSet.NAME(), name)
    return outer


def collection(*datasets):
    collection = vtkPartitionedDataSetCollection()
    for number, dataset in enumerate(datasets):
        partition = vtkPartitionedDataSet()
        partition.SetPartition(0, dataset)
        collection.SetPartitionedDataSet(number, partition)
        collection.GetMetaData(number).Set(vtkCompositeDataSet.NAME(), f"part {number}")
    return collection


def write(writer, data, name, **settings):
    writer.SetInputDataObject(0, data)
    assert configured(writer, FileName=name, **settings).Write()


def write_tetrahedra(suffix):
    """The name of a file with the mesh in a format."""
    name = f"in{suffix}"
    if suffix == ".cgns":
        shutil.copy(DATA / "box.cgns", name)
    elif suffix == ".pvtu":
        write(vtkXMLPUnstructuredGridWriter(), tetrahedra(), name)
    elif suffix == ".vtkhdf":
        write(vtkHDFWriter(), tetrahedra(), name)
    elif suffix == ".e":
        write(vtkIOSSWriter(), collection(tetrahedra()), name)
    elif suffix == ".case":
        grid = tetrahedra()
        arrays.add(grid.GetCellData(), "BlockId", np.ones(2, np.int64))
        write(vtkEnSightWriter(), grid, name, BaseName="in", Path=".")
        name = "in.0.case"
    elif suffix == ".xdmf":
        Path(name).write_text(XDMF)
    elif suffix == ".msh":  # gmsh's, not ANSYS's
        meshio.write(name, _by_meshio(), file_format="gmsh")
    else:
        meshio.write(name, _by_meshio())
    return name


def deform(name, output):
    assert main(["deform", name, "handles.csv", output]) == 0


def points_of(dataset):
    return arrays.to_numpy(dataset.GetPoints().GetData())


@pytest.mark.parametrize(
    "suffix", [".pvtu", ".vtkhdf", ".cgns", ".e", ".case", ".xdmf", *BY_MESHIO]
)
def test_a_mesh_in_every_format(suffix, capfd, messages):
    name = write_tetrahedra(suffix)
    messages.take()  # the writer for Exodus warns that there are no ids
    capfd.readouterr()
    deform(name, "out.vtu")
    printed = capfd.readouterr()
    assert "5 points, 2 cells, rigid" in printed.out
    output = io.read_dataset("out.vtu")
    expected = Deformation(REST, DEFORMED, device="reference").forward(POINTS)
    np.testing.assert_allclose(points_of(output), expected, atol=1e-5)
    np.testing.assert_allclose(expected, DEFORMED, atol=1e-6)
    corners = arrays.to_numpy(output.GetCells().GetConnectivityArray()).reshape(2, 4)
    np.testing.assert_array_equal(corners, CORNERS)
    if suffix in WITH_VALUES:
        found = arrays.to_numpy(output.GetPointData().GetArray("Pressure"))
        np.testing.assert_array_equal(found.ravel(), VALUES)


@pytest.mark.parametrize(
    ("suffix", "writer", "make"),
    [
        (".pvti", vtkXMLPImageDataWriter, image),
        (".pvtp", vtkXMLPPolyDataWriter, sphere),
        (".vtkhdf", vtkHDFWriter, image),
        (".vtkhdf", vtkHDFWriter, sphere),
    ],
)
def test_images_and_surfaces(suffix, writer, make):
    write(writer(), make(), f"in{suffix}")
    read, source = io.read_dataset(f"in{suffix}"), make()
    assert read.GetClassName() == source.GetClassName()
    for number in range(0, source.GetNumberOfPoints(), 7):
        np.testing.assert_allclose(read.GetPoint(number), source.GetPoint(number), atol=1e-6)
    assert read.GetPointData().GetNumberOfArrays() == source.GetPointData().GetNumberOfArrays()


@pytest.mark.parametrize("suffix", [".vtm", ".vtpc", ".vtkhdf"])
@pytest.mark.parametrize("target", [".vtm", ".vtpc", ".vtkhdf"])
def test_blocks_stay_blocks(suffix, target, capsys):
    data = many_blocks()
    if suffix == ".vtpc":
        data = collection(tetrahedra(), image(), sphere())
        write(vtkXMLPartitionedDataSetCollectionWriter(), data, "in.vtpc")
    else:
        writer = vtkXMLMultiBlockDataWriter() if suffix == ".vtm" else vtkHDFWriter()
        write(writer, data, f"in{suffix}")
    deform(f"in{suffix}", f"out{target}")
    assert "3 blocks, 115 points" in capsys.readouterr().out
    output = io.read_dataset(f"out{target}")
    mesh, volume, surface = blocks(output)
    value = Deformation(REST, DEFORMED, device="reference")
    np.testing.assert_allclose(points_of(mesh), value.forward(POINTS), atol=1e-5)
    np.testing.assert_allclose(points_of(surface), value.forward(points_of(sphere())), atol=1e-4)
    assert volume.GetDimensions() == (4, 3, 5)
    before = np.arange(60.0)
    after = arrays.to_numpy(volume.GetPointData().GetArray("values"))
    assert np.abs(after - before).max() > 1
    if target == ".vtm" and suffix == ".vtm":
        names = [output.GetMetaData(i).Get(vtkCompositeDataSet.NAME()) for i in range(4)]
        assert names == ["mesh", "none", "image", "more"]


def test_blocks_of_vtm_have_a_folder_and_what_is_in_it_stays(folder):
    write(vtkXMLMultiBlockDataWriter(), many_blocks(), "in.vtm")
    (folder / "out").mkdir()
    (folder / "out" / "mine.txt").write_text("mine")
    deform("in.vtm", "out.vtm")
    deform("in.vtm", "out.vtm")
    assert (folder / "out" / "mine.txt").read_text() == "mine"
    names = sorted(path.name for path in folder.iterdir())
    assert names == ["handles.csv", "in", "in.vtm", "out", "out.vtm", "tetrahedra.vtu"]


@pytest.mark.parametrize("target", [".vtm", ".vtpc", ".vtkhdf", ".vtp"])
def test_a_table_among_blocks_passes_or_is_named(target, capsys):
    data, table = vtkMultiBlockDataSet(), vtkTable()
    add_array(table.GetRowData(), "history", [1.0, 2.0])
    data.SetBlock(0, sphere())
    data.SetBlock(1, table)
    write(vtkXMLMultiBlockDataWriter(), data, "in.vtm")
    deform("in.vtm", f"out{target}")
    said, is_single = capsys.readouterr().out, target == ".vtp"
    assert ("without `vtkTable`, which .vtp cannot hold" in said) == is_single
    rest = leaves(io.read_dataset(f"out{target}"))[1:]
    assert [leaf.GetClassName() for leaf in rest] == ["vtkTable"] * (not is_single)


@pytest.mark.parametrize("target", [".vtm", ".vtpc"])
def test_a_dataset_that_files_of_blocks_cannot_hold(target):
    data = vtkMultiBlockDataSet()
    data.SetBlock(0, sphere())
    data.SetBlock(1, explicit_structured())
    with pytest.raises(ValueError, match="cannot hold a vtkExplicitStructuredGrid; make an uns"):
        io.write_dataset(data, f"x{target}")


def test_a_name_that_xml_writes_otherwise():
    write(vtkXMLMultiBlockDataWriter(), many_blocks(), "a & b's.vtm")
    assert len(blocks(io.read_dataset("a & b's.vtm"))) == 3
    io.write_dataset(collection(sphere()), "a & b's.vtpc")
    assert len(blocks(io.read_dataset("a & b's.vtpc"))) == 1


def test_the_field_of_blocks_is_over_all_of_them():
    write(vtkXMLMultiBlockDataWriter(), many_blocks(), "in.vtm")
    arguments = ["field", "in.vtm", "handles.csv", "field.vti"]
    assert main([*arguments, "--dimensions", "5,6,7"]) == 0
    field = io.read_dataset("field.vti")
    assert field.GetDimensions() == (5, 6, 7)
    every = [block.GetBounds() for block in blocks(many_blocks())]
    low, high = np.min(every, axis=0)[::2], np.max(every, axis=0)[1::2]
    np.testing.assert_allclose(field.GetBounds(), np.column_stack([low, high]).ravel())


def test_a_dataset_alone_is_not_written_as_blocks(refused):
    write(vtkXMLPPolyDataWriter(), sphere(), "in.pvtp")
    error = refused("deform", "in.pvtp", "handles.csv", "out.vtm")
    assert error.startswith("cannot write a vtkPolyData to `out.vtm`")


@pytest.mark.parametrize(
    ("name", "missing", "sentence"),
    [
        ("in.msh", "meshio", "`in.msh` needs the package meshio"),
        (
            "in.cgns",
            "vtkmodules.vtkIOCGNSReader",
            "has no vtkCGNSReader; `pip install vtk` does",
        ),
    ],
)
def test_missing_packages_are_named(folder, name, missing, sentence):
    (folder / name).write_text("something")
    arguments = ["deform", name, "handles.csv", "out.vtu"]
    status, _, error = run(*arguments, code=WITHOUT.format(names=[missing]))
    assert status == 1
    assert sentence in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("name", ["../x.vtu", "/etc/passwd", "sub/../../x.vtu", "C:\\x.vtu"])
def test_pieces_in_other_folders_are_refused(folder, name):
    text = '<VTKFile type="vtkMultiBlockDataSet" version="1.0"><vtkMultiBlockDataSet>'
    text += f'<DataSet index="0" file="{name}"/></vtkMultiBlockDataSet></VTKFile>'
    (folder / "in.vtm").write_text(text)
    with pytest.raises(ValueError, match=r"`in\.vtm` cannot be used: .* not in its own folder"):
        io.read_dataset("in.vtm")


def test_a_piece_that_is_not_there_is_no_empty_block(folder):
    write(vtkXMLMultiBlockDataWriter(), many_blocks(), "in.vtm")
    next((folder / "in").glob("*.vtu")).unlink()
    with pytest.raises(ValueError, match=r"`in\.vtm` cannot be used: there is no data file"):
        io.read_dataset("in.vtm")


def test_meshio_that_gives_up_is_a_sentence(folder, capfd):
    (folder / "in.msh").write_text("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 2 x\n")
    assert main(["deform", "in.msh", "handles.csv", "out.vtu"]) == 1
    printed = capfd.readouterr()
    assert "`in.msh` cannot be used: meshio says: " in printed.err
    assert printed.out == ""


def test_readers_are_imported_when_they_are_needed():
    code = "import sys, vtk_mls.io; print([n for n in sys.modules if 'IOSS' in n or 'HDF' in n])"
    status, out, _ = run(code=code)
    assert (status, out) == (0, "[]\n")
