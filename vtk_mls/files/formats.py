"""The table of file formats: endings, contents, readers, writers and frames.

Reading, writing, error messages, ParaView's file dialogs and docs/formats.md use this table. A new
format is a line here and one or two functions.
"""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from vtk_mls.base.errors import InputError
from vtk_mls.files.ome_zarr import SUFFIX, has_metadata

# Contents that files are read as or written from.
IMAGE, MEDICAL = "image", "image of a patient"
MESH, POLYDATA, STRUCTURED, UNSTRUCTURED = "mesh", "polydata", "structured", "unstructured"
BLOCKS = "blocks"  # also pieces and time steps
SURFACE = "surface of a cut"
POINTS, PAIRS = "points", "pairs"  # text: places with labels; p and q
POINT_DATA = "control-point polydata"
FIELD, AFFINE = "displacement field", "affine transform"

# Frames of coordinates in a file.
AS_IS = "not stated, used as it is"
LPS, RAS = "LPS", "RAS"
HEADER = "stated in its header"
AXES = "`orientation` of its axes, else used as it is"
SPACE = "`SPACE=` of 3D Slicer, else used as it is"
CALLER = "`--handles-space`, unless its columns state it"

_Texts = tuple[str, ...]
_DICOM = ".dcm"  # files of DICOM often have no ending


@dataclass(frozen=True)
class Format:
    """A line of the table.

    A reader or writer is `module.function` in this folder and its first arguments, separated by
    blanks. The last argument of a reader is a path; those of a writer are the content and a path.
    Writers of points and pairs take an open text file, and `Landmarks` or `Pairs` in LPS; points
    that are not placed are left out, but in .mrk.json. A writer of images in time is a context
    manager of a path and the times, with a function that adds an image.
    """

    name: str  # in the documentation
    endings: str  # of file names, in lower case, separated by blanks
    frame: str
    reads: _Texts = ()  # contents to read it as
    reader: str = ""
    writes: _Texts = ()  # contents to write to it
    writer: str = ""
    has_times: bool = False  # whether the reader returns times, as `block_files.open_file`
    needs: str = ""  # a package that must be installed
    is_folder: bool = False  # whether it is a folder with a name of that ending
    series_writer: str = ""

    def ending(self, path: Path) -> str:
        """The ending of a file name, if it is of this format; "" for others."""
        endings = [ending for ending in self.endings.split() if path.name.lower().endswith(ending)]
        return max(endings, key=len, default="")

    @property
    def read(self) -> Callable[..., Any]:
        """The function that reads a path."""
        return _function(*self.reader.split())

    @property
    def write(self) -> Callable[..., Any]:
        """The function that writes to a path or, for text formats, to an open file."""
        return _function(*self.writer.split())

    @property
    def write_series(self) -> Callable[..., Any]:
        """The function that writes images in time."""
        return _function(*self.series_writer.split())


def _image(name: str, endings: str, frame: str, array: str) -> Format:
    """A format of images of patients; `array` is the name of the array."""
    return Format(
        *(name, endings, frame, (IMAGE, MEDICAL), f"image_files.open_volumes {array}"),
        *((IMAGE,), f"image_files.write_volume {array}"),
        has_times=True,
        series_writer=f"image_files.writing_volumes {array}",
    )


def _field(name: str, endings: str, frame: str, array: str) -> Format:
    reader, writer = f"field_files.read_volume {array}", f"field_files.write_volume {array}"
    return Format(name, endings, frame, (FIELD,), reader, (FIELD,), writer)


def _itk(name: str, endings: str, writes: _Texts) -> Format:
    reader, writer = "itk_transforms.read", "itk_transforms.write_field"
    return Format(name, endings, LPS, (FIELD, AFFINE), reader, writes, writer, needs="SimpleITK")


def _mesh(
    name: str, ending: str, reads: _Texts, kind: str, writes: _Texts = (), writer: str = ""
) -> Format:
    """A format of meshes, which VTK's `kind`Reader reads; by default `kind`Writer writes it."""
    if writes and not writer:
        writer = f"mesh_files.write {kind}Writer"
    return Format(name, ending, SPACE, reads, f"mesh_files.read {kind}Reader", writes, writer)


def _blocks(name: str, endings: str, reader: str, writes: _Texts = (), writer: str = "") -> Format:
    reader = f"block_files.open_file {reader}"
    writer = writer and f"block_files.{writer}"
    return Format(name, endings, AS_IS, (BLOCKS,), reader, writes, writer, has_times=True)


def _xml_blocks(ending: str, kind: str, writer: str = "") -> Format:
    reader, writes = f"vtkIOXML.vtkXML{kind}Reader xml", (BLOCKS,) if writer else ()
    return _blocks("VTK XML", ending, reader, writes, writer)


def _points(name: str, endings: str, frame: str, reader: str, writer: str) -> Format:
    return Format(name, endings, frame, (POINTS,), reader, (POINTS,), writer)


_TIFF: dict[str, Any] = {"reader": "tiff.open_file", "has_times": True, "needs": "tifffile"}
_ROLES = (MESH, SURFACE, POINT_DATA)
_VTI = "image_files.read_xml", (IMAGE,), "image_files.write_xml"
_VTK = "mesh_files.read vtkIOLegacy.vtkDataSetReader", (IMAGE,), "image_files.write_legacy"
_ZARR = "image_files.read_ome_zarr"
_VTR = "mesh_files.read vtkIOXML.vtkXMLRectilinearGridReader"
_TEXT = CALLER, "control_point_files.read_text"
_MESHIO = ".msh .inp .bdf .nas .fem .med .mesh .meshb .vol .su2 .avs .off"

TABLE = (
    # images
    Format("VTK XML", ".vti", AS_IS, (IMAGE,), *_VTI),
    Format("VTK legacy", ".vtk", AS_IS, (IMAGE,), *_VTK),
    _image("MetaImage", ".mha .mhd", LPS, "MetaImage"),
    _image("NRRD", ".nrrd .nhdr .seg.nrrd", HEADER, "NRRD"),
    _image("NIfTI", ".nii .nii.gz", RAS, "NIFTI"),
    Format(
        "NIfTI with .img", ".hdr", RAS, (IMAGE,), "image_files.open_volumes NIFTI", has_times=True
    ),
    Format("DICOM, one series", ".dcm", LPS, (IMAGE,), "dicom.read", needs="SimpleITK"),
    Format("TIFF", ".tif .tiff", AS_IS, (IMAGE,), **_TIFF),
    Format("OME-Zarr", ".ome.zarr .zarr", AXES, (IMAGE,), _ZARR, needs="zarr", is_folder=True),
    # transforms
    _field("NIfTI", ".nii.gz .nii", RAS, "NIFTI"),
    _field("NRRD", ".nrrd .nhdr", LPS, "NRRD"),
    _field("MetaImage", ".mha .mhd", LPS, "MetaImage"),
    _itk("ITK", ".h5 .hdf5", (FIELD, AFFINE)),
    Format("ITK, matrices in text", ".tfm .txt", LPS, (FIELD, AFFINE), "itk_transforms.read_text"),
    replace(_itk("ITK, text", ".tfm .txt", (FIELD, AFFINE)), reads=()),
    _itk("ITK, one affine transform", ".mat", (AFFINE,)),
    # meshes
    _mesh(
        "STL", ".stl", (MESH, SURFACE), "vtkIOGeometry.vtkSTL", (POLYDATA,), "mesh_files.write_stl"
    ),
    _mesh("VTK XML", ".vtp", _ROLES, "vtkIOXML.vtkXMLPolyData", (POLYDATA,)),
    _mesh("VTK legacy", ".vtk", _ROLES, "vtkIOLegacy.vtkDataSet", (MESH,)),
    _mesh(
        "VTK XML", ".vtu", (MESH, POINT_DATA), "vtkIOXML.vtkXMLUnstructuredGrid", (UNSTRUCTURED,)
    ),
    _mesh("VTK XML", ".vts", (MESH, POINT_DATA), "vtkIOXML.vtkXMLStructuredGrid", (STRUCTURED,)),
    Format("VTK XML", ".vtr", AS_IS, (MESH,), _VTR),
    _mesh("PLY", ".ply", (MESH,), "vtkIOPLY.vtkPLY", (POLYDATA,), "mesh_files.write_ply"),
    _mesh("Wavefront", ".obj", (MESH,), "vtkIOGeometry.vtkOBJ"),
    # blocks, pieces, time steps; the last word is the syntax by which a file names others
    _xml_blocks(".vtm", "MultiBlockData", "write_blocks"),
    _xml_blocks(".vtmb", "MultiBlockData"),
    _xml_blocks(".vtpc", "PartitionedDataSetCollection", "write_partitions"),
    _xml_blocks(".pvti", "PImageData"),
    _xml_blocks(".pvtu", "PUnstructuredGrid"),
    _xml_blocks(".pvtp", "PPolyData"),
    _xml_blocks(".pvts", "PStructuredGrid"),
    _xml_blocks(".pvtr", "PRectilinearGrid"),
    _blocks("VTK HDF", ".vtkhdf", "vtkIOHDF.vtkHDFReader none", (MESH, BLOCKS), "write_hdf"),
    _blocks("VTK HDF", ".hdf", "vtkIOHDF.vtkHDFReader none"),
    _blocks("CGNS", ".cgns", "vtkIOCGNSReader.vtkCGNSReader none"),
    _blocks("Exodus", ".ex2 .e .exo", "vtkIOIOSS.vtkIOSSReader none"),
    _blocks("EnSight", ".case", "vtkIOEnSight.vtkGenericEnSightReader case"),
    _blocks("XDMF", ".xdmf .xmf", "vtkIOXdmf2.vtkXdmfReader xdmf"),
    Format("read by meshio", _MESHIO, AS_IS, (MESH,), "block_files.read_by_meshio", needs="meshio"),
    # points in text
    _points("table", ".csv", *_TEXT, "point_tables.write"),
    _points("table, elastix, or (read) IDAV Landmark", ".txt .pts", *_TEXT, "point_lists.write"),
    Format("table", ".csv .txt", CALLER, (), "", (PAIRS,), "point_tables.write_pairs"),
    _points("tag points of MINC", ".tag", RAS, "point_lists.read_tags", "point_lists.write_tags"),
    Format("tag points of MINC", ".tag", RAS, (), "", (PAIRS,), "point_lists.write_tag_pairs"),
    _points("markups of 3D Slicer", ".fcsv", HEADER, "markups.read_fcsv", "markups.write_fcsv"),
    _points("markups of 3D Slicer", ".mrk.json", HEADER, "markups.read_json", "markups.write_json"),
)


def endings(*, reads: _Texts = (), writes: _Texts = ()) -> _Texts:
    """Endings of files that can be read as, or be written from, one of these contents."""
    lines = _lines(reads, writes)
    return tuple(dict.fromkeys(ending for line in lines for ending in line.endings.split()))


def extensions(reads: str) -> str:
    """Endings without the first dot, separated by blanks, for ParaView's file dialogs."""
    return " ".join(ending[1:] for ending in endings(reads=(reads,)))


def find(path: Path, **contents: _Texts) -> Format | None:
    """The line for a file name and contents as of `endings`; None without."""
    return next((line for line in _lines(**contents) if line.ending(path)), None)


def choose(path: Path, purpose: str, **contents: _Texts) -> Format:
    """The line for a file name and contents as of `endings`.

    Errors (OSError, ValueError) have the purpose, such as "read a surface from", and the endings
    that are possible; or the package that the file needs.
    """
    line = find(path, **contents)
    if line is None and has_metadata(path):  # an image in an OME-Zarr
        line = find(Path(SUFFIX), **contents)
    if IMAGE in contents.get("reads", ()) and _is_dicom(path, line):
        line = find(Path(_DICOM), **contents)
    elif line is None and path.is_dir():
        raise IsADirectoryError(f"`{path}` is a folder; expected a file")
    if line is None:
        raise ValueError(
            f"cannot {purpose} `{path}`: its name must end in one of "
            f"{', '.join(endings(**contents))}"
        )
    if line.needs and importlib.util.find_spec(line.needs) is None:
        raise InputError(f"needs the package {line.needs}: pip install {line.needs}", path=path)
    return line


def _is_dicom(path: Path, line: Format | None) -> bool:
    """Whether it is another folder, or a file without a known ending that begins as DICOM does."""
    if line is not None or not path.is_file():
        return path.is_dir() and not (line and line.is_folder)
    return is_dicom_file(path)


def is_dicom_file(path: Path) -> bool:
    """Whether a file begins as DICOM does."""
    with path.open("rb") as file:
        return file.read(132)[128:] == b"DICM"


def _lines(reads: _Texts = (), writes: _Texts = ()) -> list[Format]:
    return [line for line in TABLE if {*line.reads} & {*reads} or {*line.writes} & {*writes}]


def _function(name: str, *arguments: str) -> Callable[..., Any]:
    module, _, name = name.partition(".")
    function = getattr(importlib.import_module(f"vtk_mls.files.{module}"), name)
    return partial(function, *arguments) if arguments else function
