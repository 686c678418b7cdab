"""Datasets of several blocks, and their files: .vtm, .vtpc and .vtkhdf."""

import base64
from xml.sax.saxutils import quoteattr

from vtkmodules.vtkCommonCore import vtkIndent
from vtkmodules.vtkCommonDataModel import (
    vtkCompositeDataSet,
    vtkDataObjectTreeIterator,
    vtkDataSet,
    vtkMultiBlockDataSet,
    vtkPartitionedDataSet,
    vtkPartitionedDataSetCollection,
)
from vtkmodules.vtkIOXML import vtkXMLDataObjectWriter, vtkXMLMultiBlockDataWriter

from vtk_mls.base.errors import InputError
from vtk_mls.files import vtk_io

COMPOSITE = (vtkMultiBlockDataSet, vtkPartitionedDataSet, vtkPartitionedDataSetCollection)
PIECES = {  # formats with everything, by the class of a dataset
    "vtkImageData": ".vti",
    "vtkPolyData": ".vtp",
    "vtkStructuredGrid": ".vts",
    "vtkUnstructuredGrid": ".vtu",
}
_NAME = vtkCompositeDataSet.NAME()
_HDF_END = slice(40, 48)  # where VTK's HDF5 files say how long they are


def blocks(data):
    """The datasets of composite data that are not empty; a dataset alone."""
    return [
        leaf for leaf in leaves(data) if isinstance(leaf, vtkDataSet) and leaf.GetNumberOfPoints()
    ]


def leaves(data):
    """All blocks of composite data, tables among them; a dataset alone."""
    if isinstance(data, vtkDataSet):
        return [data]
    found, iterator = [], vtkDataObjectTreeIterator()
    iterator.SetDataSet(data)
    iterator.VisitOnlyLeavesOn()
    iterator.SkipEmptyNodesOn()
    iterator.InitTraversal()
    while not iterator.IsDoneWithTraversal():
        found.append(iterator.GetCurrentDataObject())
        iterator.GoToNextItem()
    return found


def block_writer(data):
    """VTK's writer of a block; None if files of blocks cannot hold it, as a graph."""
    return vtkXMLDataObjectWriter.NewWriter(data.GetDataObjectType())


def joined(datasets):
    """A single dataset unchanged, several as blocks."""
    if len(datasets) == 1:
        return datasets[0]
    data = vtkMultiBlockDataSet()
    for index, dataset in enumerate(datasets):
        data.SetBlock(index, dataset)
    return data


def write_blocks(data, path):
    """Write a .vtm file and a folder with its blocks."""
    vtk_io.write(vtkXMLMultiBlockDataWriter(), _converted(data, "MultiBlockDataSet"), path)


def write_partitions(data, path):
    """Write a .vtpc file and a folder with its partitions.

    VTK's own writer ends the process when the disk is full.
    """
    data = _converted(data, "PartitionedDataSetCollection")
    path.with_suffix("").mkdir(exist_ok=True)
    lines = []
    for index in range(data.GetNumberOfPartitionedDataSets()):
        named = data.HasMetaData(index) and data.GetMetaData(index).Has(_NAME)
        name = data.GetMetaData(index).Get(_NAME) if named else ""
        lines.append(f'<Partitions index="{index}" name={quoteattr(name)}>')
        for part in range(data.GetNumberOfPartitions(index)):
            dataset = data.GetPartitionAsDataObject(index, part)
            writer = None if dataset is None else block_writer(dataset)
            if writer is not None:
                suffix = writer.GetDefaultFileExtension()
                file = f"{path.stem}/{path.stem}_{index}_{part}.{suffix}"
                vtk_io.write(writer, dataset, path.parent / file)
                lines.append(f'  <DataSet index="{part}" file={quoteattr(file)}/>')
        lines.append("</Partitions>")
    if data.GetDataAssembly() is not None:
        tree = base64.b64encode(data.GetDataAssembly().SerializeToXML(vtkIndent()).encode())
        lines.append(f'<DataAssembly encoding="base64">{tree.decode()}</DataAssembly>')
    kind = "vtkPartitionedDataSetCollection"
    path.write_text(
        f'<?xml version="1.0"?>\n<VTKFile type="{kind}" version="1.0" byte_order="LittleEndian">\n'
        f"<{kind}>\n" + "\n".join(lines) + f"\n</{kind}>\n</VTKFile>\n",
        encoding="utf-8",
    )


def _converted(data, kind):
    """Composite data of another class, if a file of blocks can hold them."""
    for leaf in leaves(data):
        if isinstance(leaf, vtkDataSet) and block_writer(leaf) is None:  # VTK would leave it out
            raise InputError(
                f"cannot hold a {leaf.GetClassName()}; make an unstructured grid of it (by "
                "vtkAppendFilter)"
            )
    if data.IsA(f"vtk{kind}"):
        return data
    convert = vtk_io.create(f"vtkFiltersCore.vtkConvertTo{kind}")
    convert.SetInputDataObject(data)
    convert.Update()
    return convert.GetOutputDataObject(0)


def write_hdf(data, path):
    """Write a .vtkhdf file, which VTK can from 9.4 on."""
    vtk_io.write(vtk_io.create("vtkIOHDF.vtkHDFWriter"), data, path)
    with path.open("rb") as file:
        start = file.read(_HDF_END.stop)
    vtk_io.check_size(path, int.from_bytes(start[_HDF_END], "little"))
