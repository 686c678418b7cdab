"""Files of simulation programs, of several blocks, and of several time steps.

VTK has readers for most formats, in modules that not every VTK has: they are imported when they are
needed. Others are read by meshio, if it is installed.
"""

from __future__ import annotations

import base64
import contextlib
import importlib.util
import io
import re
import tempfile
from pathlib import Path
from xml.sax.saxutils import quoteattr, unescape

from vtkmodules.vtkCommonCore import vtkIndent, vtkVersion
from vtkmodules.vtkCommonDataModel import (
    vtkCompositeDataSet,
    vtkDataObjectTreeIterator,
    vtkDataSet,
    vtkMultiBlockDataSet,
    vtkPartitionedDataSet,
    vtkPartitionedDataSetCollection,
)
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOXML import (
    vtkXMLDataSetWriter,
    vtkXMLMultiBlockDataWriter,
    vtkXMLUnstructuredGridReader,
)

from vtk_mls.files import image_files, volumes

PIECES = {  # formats with everything, by the class of a dataset
    "vtkImageData": ".vti",
    "vtkPolyData": ".vtp",
    "vtkStructuredGrid": ".vts",
    "vtkUnstructuredGrid": ".vtu",
}
COMPOSITE = (vtkMultiBlockDataSet, vtkPartitionedDataSet, vtkPartitionedDataSetCollection)

_XML, _IOSS = "vtkIOXML", ("vtkIOIOSS", "vtkIOSSReader")
_VTK = {  # module and reader
    ".vtm": (_XML, "vtkXMLMultiBlockDataReader"),
    ".vtmb": (_XML, "vtkXMLMultiBlockDataReader"),
    ".vtpc": (_XML, "vtkXMLPartitionedDataSetCollectionReader"),
    ".pvti": (_XML, "vtkXMLPImageDataReader"),
    ".pvtu": (_XML, "vtkXMLPUnstructuredGridReader"),
    ".pvtp": (_XML, "vtkXMLPPolyDataReader"),
    ".pvts": (_XML, "vtkXMLPStructuredGridReader"),
    ".pvtr": (_XML, "vtkXMLPRectilinearGridReader"),
    ".vtkhdf": ("vtkIOHDF", "vtkHDFReader"),
    ".hdf": ("vtkIOHDF", "vtkHDFReader"),
    ".cgns": ("vtkIOCGNSReader", "vtkCGNSReader"),
    ".ex2": _IOSS,
    ".e": _IOSS,
    ".exo": _IOSS,
    ".case": ("vtkIOEnSight", "vtkGenericEnSightReader"),
    ".xdmf": ("vtkIOXdmf2", "vtkXdmfReader"),
    ".xmf": ("vtkIOXdmf2", "vtkXdmfReader"),
}
_MESHIO = (
    *(".msh", ".inp", ".bdf", ".nas", ".fem", ".med", ".mesh", ".meshb", ".vol", ".su2", ".avs"),
    *(".off",),
)
FORMATS = (*_VTK, *_MESHIO)

_NAME = vtkCompositeDataSet.NAME()
_HDF_END = slice(40, 48)  # where VTK's HDF5 files say how long they are

# Names of other files in those that name some.
_IN_XML = re.compile(r"""\b(?:file|Source)\s*=\s*(?:"([^"]*)"|'([^']*)')""")
_IN_CASE = re.compile(r"^[^:\n]*:.*?([^\s:]+)\s*$", re.MULTILINE)
_IN_XDMF = re.compile(r"[>\s]([^<>\s:]+\.(?:h5|hdf5?|bin|raw)\b)")


def open_file(path):
    """What a file holds, to be read when it is wanted.

    Parameters
    ----------
    path : Path
        Its name ends in one of `FORMATS`.

    Returns
    -------
    times : tuple of float
        Of its time steps; empty if it says none.
    read : callable
        Gives the dataset of a time step by its number. None, or a dataset of any kind, if the file
        is broken: VTK's output window has heard why.

    Raises
    ------
    ValueError
    """
    suffix = path.suffix.lower()
    if suffix in _MESHIO:
        return (), lambda number: _read_by_meshio(path)
    _check_names(path, suffix)
    reader = _vtk_reader(path, *_VTK[suffix])
    if not reader.GetExecutive().UpdateInformation():
        return (), lambda number: None
    if hasattr(reader, "EnableAllPointArrays"):
        reader.EnableAllPointArrays()
        reader.EnableAllCellArrays()
    key = vtkStreamingDemandDrivenPipeline.TIME_STEPS()
    times = tuple(reader.GetOutputInformation(0).Get(key) or ())

    def read(number):
        done = reader.UpdateTimeStep(times[number]) if times else reader.GetExecutive().Update()
        data = reader.GetOutputDataObject(0)
        if not done or data is None:
            return None
        copy = data.NewInstance()  # the reader's own is used for the next step
        copy.ShallowCopy(data)
        return copy

    return times, read


def wanting():
    """What could be read if something was installed, for the end of a sentence."""
    if importlib.util.find_spec("meshio") is not None:
        return ""
    return f" ({', '.join(_MESHIO)} after `pip install meshio`)"


def blocks(data):
    """The datasets of composite data that are not empty; a dataset alone."""
    if isinstance(data, vtkDataSet):
        return [data]
    found, each = [], vtkDataObjectTreeIterator()
    each.SetDataSet(data)
    each.VisitOnlyLeavesOn()
    each.SkipEmptyNodesOn()
    each.InitTraversal()
    while not each.IsDoneWithTraversal():
        found.append(each.GetCurrentDataObject())
        each.GoToNextItem()
    return [block for block in found if isinstance(block, vtkDataSet) and block.GetNumberOfPoints()]


def joined(datasets):
    """Datasets as one: a single one as it is, more as blocks."""
    if len(datasets) == 1:
        return datasets[0]
    together = vtkMultiBlockDataSet()
    for number, dataset in enumerate(datasets):
        together.SetBlock(number, dataset)
    return together


def _vtk_reader(path, module, name):
    try:
        reader = getattr(importlib.import_module(f"vtkmodules.{module}"), name)()
    except (AttributeError, ImportError):
        raise ValueError(
            f"this VTK, {vtkVersion.GetVTKVersion()}, has no {name}; that of `pip install vtk` has"
        ) from None
    if hasattr(reader, "SetScanForRelatedFiles"):
        reader.SetScanForRelatedFiles(False)
    if hasattr(reader, "SetCaseFileName"):
        reader.SetCaseFileName(str(path))
    else:
        reader.SetFileName(str(path))
    return reader


def _check_names(path, suffix):
    """Raise if a file names others that are not there, or not in its folder."""
    pattern = {".case": _IN_CASE, ".xdmf": _IN_XDMF, ".xmf": _IN_XDMF}.get(suffix)
    if _VTK[suffix][0] == _XML:
        pattern = _IN_XML
    if pattern is None:
        return
    for found in pattern.finditer(path.read_text("utf-8", "replace")):
        name = found[found.lastindex]
        if pattern is _IN_XML:
            volumes.beside(path, unescape(name, {"&quot;": '"', "&apos;": "'"}))
        else:
            volumes.check_within(name)


def _read_by_meshio(path):
    """A mesh as meshio reads it, by way of a file that both know."""
    try:
        import meshio
    except ImportError:
        raise ValueError(
            "it is read by meshio, which is not installed: pip install meshio"
        ) from None
    said = io.StringIO()
    with tempfile.TemporaryDirectory() as folder:
        between = Path(folder) / "mesh.vtu"
        with contextlib.redirect_stdout(said):
            try:
                meshio.read(path).write(between, compression=None)
            # whatever its parsers stumble over in a broken file; it even exits
            except (Exception, SystemExit) as error:
                reason = str(error) if isinstance(error, Exception) else said.getvalue()
                if isinstance(error, ImportError):
                    reason += f": pip install {error.name}"
                raise ValueError(f"meshio says: {reason or type(error).__name__}") from None
        return image_files.read(vtkXMLUnstructuredGridReader(), between)


def _write_blocks(data, path):
    if not isinstance(data, vtkMultiBlockDataSet):
        from vtkmodules.vtkFiltersCore import vtkConvertToMultiBlockDataSet

        data = _converted(vtkConvertToMultiBlockDataSet(), data)
    image_files.write(vtkXMLMultiBlockDataWriter(), data, path)


def _write_partitions(data, path):
    """Write a .vtpc file; VTK's own writer ends the process when the disk is full."""
    if not isinstance(data, vtkPartitionedDataSetCollection):
        from vtkmodules.vtkFiltersCore import vtkConvertToPartitionedDataSetCollection

        data = _converted(vtkConvertToPartitionedDataSetCollection(), data)
    path.with_suffix("").mkdir(exist_ok=True)
    lines = []
    for number in range(data.GetNumberOfPartitionedDataSets()):
        named = data.HasMetaData(number) and data.GetMetaData(number).Has(_NAME)
        name = data.GetMetaData(number).Get(_NAME) if named else ""
        lines.append(f'<Partitions index="{number}" name={quoteattr(name)}>')
        for part in range(data.GetNumberOfPartitions(number)):
            dataset = data.GetPartition(number, part)
            if dataset is not None:
                suffix = PIECES.get(dataset.GetClassName())
                if suffix is None:
                    raise ValueError(f"`{path}` cannot hold a {dataset.GetClassName()}")
                file = f"{path.stem}/{path.stem}_{number}_{part}{suffix}"
                image_files.write(vtkXMLDataSetWriter(), dataset, path.parent / file)
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


def _converted(algorithm, data):
    algorithm.SetInputDataObject(data)
    algorithm.Update()
    return algorithm.GetOutputDataObject(0)


def _write_hdf(data, path):
    try:
        from vtkmodules.vtkIOHDF import vtkHDFWriter
    except ImportError:
        raise ValueError(
            f"`{path}` cannot be written by VTK {vtkVersion.GetVTKVersion()}, only from 9.4 on; "
            "write .vtu, .vtp or .vtm instead"
        ) from None
    image_files.write(vtkHDFWriter(), data, path)
    with path.open("rb") as file:
        start = file.read(_HDF_END.stop)
    image_files.check_size(path, int.from_bytes(start[_HDF_END], "little"))


WRITERS = {".vtm": _write_blocks, ".vtpc": _write_partitions, ".vtkhdf": _write_hdf}
