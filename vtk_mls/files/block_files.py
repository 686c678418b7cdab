"""Datasets of several blocks, and files of several blocks or time steps, as of simulation programs.

VTK has readers for most formats, in modules that some builds lack, so they are imported when they
are needed. meshio reads the others, if it is installed. .vtm, .vtpc and .vtkhdf are written.
"""

import base64
import contextlib
import io
import re
import tempfile
from pathlib import Path
from xml.sax.saxutils import quoteattr, unescape

from vtkmodules.vtkCommonCore import vtkIndent
from vtkmodules.vtkCommonDataModel import (
    vtkCompositeDataSet,
    vtkDataObjectTreeIterator,
    vtkDataSet,
    vtkMultiBlockDataSet,
    vtkPartitionedDataSet,
    vtkPartitionedDataSetCollection,
)
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOXML import vtkXMLDataObjectWriter, vtkXMLMultiBlockDataWriter

from vtk_mls.base.errors import InputError
from vtk_mls.files import paths, vtk_io
from vtk_mls.vtk.objects import configured, shallow_copy

COMPOSITE = (vtkMultiBlockDataSet, vtkPartitionedDataSet, vtkPartitionedDataSetCollection)
PIECES = {  # formats with everything, by the class of a dataset
    "vtkImageData": ".vti",
    "vtkPolyData": ".vtp",
    "vtkStructuredGrid": ".vts",
    "vtkUnstructuredGrid": ".vtu",
}
_NAME = vtkCompositeDataSet.NAME()
_HDF_END = slice(40, 48)  # where VTK's HDF5 files say how long they are
# Names of other files in a file.
_NAMES = {
    "xml": re.compile(r"""\b(?:file|Source)\s*=\s*(?:"([^"]*)"|'([^']*)')"""),
    "case": re.compile(r"^[^:\n]*:.*?([^\s:]+)\s*$", re.MULTILINE),
    "xdmf": re.compile(r"[>\s]([^<>\s:]+\.(?:h5|hdf5?|bin|raw)\b)"),
}


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
    configured(iterator, DataSet=data, VisitOnlyLeaves=True, SkipEmptyNodes=True)
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
    convert = configured(vtk_io.create(f"vtkFiltersCore.vtkConvertTo{kind}"), InputDataObject=data)
    convert.Update()
    return convert.GetOutputDataObject(0)


def write_hdf(data, path):
    """Write a .vtkhdf file, which VTK can from 9.4 on."""
    vtk_io.write(vtk_io.create("vtkIOHDF.vtkHDFWriter"), data, path)
    with path.open("rb") as file:
        start = file.read(_HDF_END.stop)
    vtk_io.check_size(path, int.from_bytes(start[_HDF_END], "little"))


def open_file(reader, syntax, path):
    """The time steps of a file, () without, and a function that returns the dataset of one by its
    index.

    `reader` is the module and class of VTK's reader. `syntax` ("xml", "case", "xdmf" or "none")
    says how the file names other files, which must exist in its folder. Of a broken file the
    function returns None or any dataset, with the reason in VTK's output window.
    """
    if syntax in _NAMES:
        _check_names(path, syntax)
    reader = vtk_io.create(reader)
    if hasattr(reader, "SetScanForRelatedFiles"):
        reader.SetScanForRelatedFiles(False)
    if hasattr(reader, "SetCaseFileName"):
        reader.SetCaseFileName(str(path))
    else:
        reader.SetFileName(str(path))
    if not reader.GetExecutive().UpdateInformation():
        return (), lambda index: None
    if hasattr(reader, "EnableAllPointArrays"):
        reader.EnableAllPointArrays()
        reader.EnableAllCellArrays()
    key = vtkStreamingDemandDrivenPipeline.TIME_STEPS()
    times = tuple(reader.GetOutputInformation(0).Get(key) or ())

    def read(index):
        success = reader.UpdateTimeStep(times[index]) if times else reader.GetExecutive().Update()
        data = reader.GetOutputDataObject(0)
        if not success or data is None:
            return None
        return shallow_copy(data)  # the reader writes the next step to its own

    return times, read


def _check_names(path, syntax):
    """Raise ValueError if a file names others that are missing or outside of its folder."""
    for match in _NAMES[syntax].finditer(path.read_text("utf-8", "replace")):
        name = match[match.lastindex]
        if syntax == "xml":
            paths.named_file(path, unescape(name, {"&quot;": '"', "&apos;": "'"}))
        else:
            paths.check_within(name)


def read_by_meshio(path):
    """Read a mesh with meshio, through a .vtu file."""
    import meshio

    printed = io.StringIO()
    with tempfile.TemporaryDirectory() as folder:
        vtu_path = Path(folder) / "mesh.vtu"
        with contextlib.redirect_stdout(printed):
            try:
                mesh = meshio.read(path)
                # lists, such as names in .med, are no arrays that a .vtu can hold
                mesh.field_data = {k: v for k, v in mesh.field_data.items() if hasattr(v, "dtype")}
                mesh.write(vtu_path, compression=None)
            # its parsers raise anything on broken files, and even exit
            except (Exception, SystemExit) as error:
                reason = str(error) if isinstance(error, Exception) else printed.getvalue()
                if isinstance(error, ImportError):
                    reason += f": pip install {error.name}"
                raise ValueError(f"meshio says: {reason or type(error).__name__}") from None
        return vtk_io.read(vtk_io.create("vtkIOXML.vtkXMLUnstructuredGridReader"), vtu_path)
