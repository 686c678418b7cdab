"""The formats of files: what each ending can hold, what reads it, what writes it, and its frame.

Everything that must know an ending asks this table: reading, writing, the sentences of errors,
ParaView's file dialogs and docs/formats.md. A new format is a line here and a function or two.
"""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

# What a file is read as or written from.
IMAGE, MEDICAL = "image", "image of a patient"
MESH, POLYDATA, STRUCTURED, UNSTRUCTURED = "mesh", "polydata", "structured", "unstructured"
BLOCKS = "blocks"  # also pieces and time steps
SURFACE = "surface of a cut"
POINTS, PAIRS = "points", "pairs"  # text: places with labels; p and q
POINT_DATA = "control-point polydata"
FIELD = "displacement field"

# What coordinates in a file mean.
AS_IS = "not said; taken as it is"
LPS, RAS = "LPS", "RAS"
HEADER = "said by its header"
SPACE = "`SPACE=` of 3D Slicer, else taken as it is"
CALLER = "`--handles-space`, unless its columns say it"


@dataclass(frozen=True)
class Format:
    """A line of the table.

    Parameters
    ----------
    name : str
        In the documentation.
    endings : str
        Of names of files, in small letters, between blanks.
    frame : str
    reads, writes : tuples of str
        What it is read as, and what can be written to it.
    reader, writer : str
        `module.function` in this folder, and between blanks its first arguments. A reader takes a
        path besides, a writer what it writes and a path.
    has_times : bool
        Whether the reader is of the kind of `simulation_files.open_file`, which gives times.
    needs : str
        A package that must be installed.
    """

    name: str
    endings: str
    frame: str
    reads: tuple[str, ...] = ()
    reader: str = ""
    writes: tuple[str, ...] = ()
    writer: str = ""
    has_times: bool = False
    needs: str = ""

    def ending(self, path: Path) -> str:
        """How the name of a file ends, if it is one of this format; "" for others."""
        found = [each for each in self.endings.split() if path.name.lower().endswith(each)]
        return max(found, key=len, default="")

    @property
    def read(self) -> Callable[..., Any]:
        """The function that reads a path."""
        return _function(*self.reader.split())

    @property
    def write(self) -> Callable[..., Any]:
        """The function that writes something to a path; text formats, to an open file."""
        return _function(*self.writer.split())


_READ, _WRITE = "mesh_files.read", "mesh_files.write"
_OPEN = "simulation_files.open_file"
_ROLES = (MESH, SURFACE, POINT_DATA)
_BLOCKS = (BLOCKS,)

TABLE = (
    # images
    Format(
        "VTK XML",
        ".vti",
        AS_IS,
        (IMAGE,),
        "image_files.read_xml",
        (IMAGE,),
        "image_files.write_xml",
    ),
    Format(
        "VTK legacy",
        ".vtk",
        AS_IS,
        (IMAGE,),
        f"{_READ} vtkIOLegacy.vtkDataSetReader",
        (IMAGE,),
        "image_files.write_legacy",
    ),
    Format(
        "MetaImage",
        ".mha .mhd",
        LPS,
        (IMAGE, MEDICAL),
        "image_files.read_volume MetaImage",
        (IMAGE,),
        "image_files.write_volume MetaImage",
    ),
    Format(
        "NRRD",
        ".nrrd .nhdr .seg.nrrd",
        HEADER,
        (IMAGE, MEDICAL),
        "image_files.read_volume NRRD",
        (IMAGE,),
        "image_files.write_volume NRRD",
    ),
    Format(
        "NIfTI",
        ".nii .nii.gz",
        RAS,
        (IMAGE, MEDICAL),
        "image_files.read_volume NIFTI",
        (IMAGE,),
        "image_files.write_volume NIFTI",
    ),
    Format("NIfTI with .img", ".hdr", RAS, (IMAGE,), "image_files.read_volume NIFTI"),
    # displacement fields
    Format("NIfTI", ".nii.gz .nii", RAS, (), "", (FIELD,), "field_files.write_volume NIFTI"),
    Format("NRRD", ".nrrd .nhdr", LPS, (), "", (FIELD,), "field_files.write_volume NRRD"),
    Format("MetaImage", ".mha .mhd", LPS, (), "", (FIELD,), "field_files.write_volume MetaImage"),
    # meshes
    Format(
        "STL",
        ".stl",
        SPACE,
        (MESH, SURFACE),
        f"{_READ} vtkIOGeometry.vtkSTLReader",
        (POLYDATA,),
        "mesh_files.write_stl",
    ),
    Format(
        "VTK XML",
        ".vtp",
        SPACE,
        _ROLES,
        f"{_READ} vtkIOXML.vtkXMLPolyDataReader",
        (POLYDATA,),
        f"{_WRITE} vtkIOXML.vtkXMLPolyDataWriter",
    ),
    Format(
        "VTK legacy",
        ".vtk",
        SPACE,
        _ROLES,
        f"{_READ} vtkIOLegacy.vtkDataSetReader",
        (MESH,),
        f"{_WRITE} vtkIOLegacy.vtkDataSetWriter",
    ),
    Format(
        "VTK XML",
        ".vtu",
        SPACE,
        (MESH, POINT_DATA),
        f"{_READ} vtkIOXML.vtkXMLUnstructuredGridReader",
        (UNSTRUCTURED,),
        f"{_WRITE} vtkIOXML.vtkXMLUnstructuredGridWriter",
    ),
    Format(
        "VTK XML",
        ".vts",
        SPACE,
        (MESH, POINT_DATA),
        f"{_READ} vtkIOXML.vtkXMLStructuredGridReader",
        (STRUCTURED,),
        f"{_WRITE} vtkIOXML.vtkXMLStructuredGridWriter",
    ),
    Format("VTK XML", ".vtr", AS_IS, (MESH,), f"{_READ} vtkIOXML.vtkXMLRectilinearGridReader"),
    Format(
        "PLY",
        ".ply",
        SPACE,
        (MESH,),
        f"{_READ} vtkIOPLY.vtkPLYReader",
        (POLYDATA,),
        "mesh_files.write_ply",
    ),
    Format("Wavefront", ".obj", SPACE, (MESH,), f"{_READ} vtkIOGeometry.vtkOBJReader"),
    # blocks, pieces, time steps; the last argument is how a file names others
    Format(
        "VTK XML",
        ".vtm",
        AS_IS,
        _BLOCKS,
        f"{_OPEN} vtkIOXML.vtkXMLMultiBlockDataReader xml",
        _BLOCKS,
        "block_files.write_blocks",
        True,
    ),
    Format(
        "VTK XML",
        ".vtmb",
        AS_IS,
        _BLOCKS,
        f"{_OPEN} vtkIOXML.vtkXMLMultiBlockDataReader xml",
        has_times=True,
    ),
    Format(
        "VTK XML",
        ".vtpc",
        AS_IS,
        _BLOCKS,
        f"{_OPEN} vtkIOXML.vtkXMLPartitionedDataSetCollectionReader xml",
        _BLOCKS,
        "block_files.write_partitions",
        True,
    ),
    *(
        Format("VTK XML", ending, AS_IS, _BLOCKS, f"{_OPEN} vtkIOXML.{name} xml", has_times=True)
        for ending, name in (
            (".pvti", "vtkXMLPImageDataReader"),
            (".pvtu", "vtkXMLPUnstructuredGridReader"),
            (".pvtp", "vtkXMLPPolyDataReader"),
            (".pvts", "vtkXMLPStructuredGridReader"),
            (".pvtr", "vtkXMLPRectilinearGridReader"),
        )
    ),
    Format(
        "VTK HDF",
        ".vtkhdf",
        AS_IS,
        _BLOCKS,
        f"{_OPEN} vtkIOHDF.vtkHDFReader none",
        (MESH, BLOCKS),
        "block_files.write_hdf",
        True,
    ),
    *(
        Format(name, endings, AS_IS, _BLOCKS, f"{_OPEN} {reader}", has_times=True)
        for name, endings, reader in (
            ("VTK HDF", ".hdf", "vtkIOHDF.vtkHDFReader none"),
            ("CGNS", ".cgns", "vtkIOCGNSReader.vtkCGNSReader none"),
            ("Exodus", ".ex2 .e .exo", "vtkIOIOSS.vtkIOSSReader none"),
            ("EnSight", ".case", "vtkIOEnSight.vtkGenericEnSightReader case"),
            ("XDMF", ".xdmf .xmf", "vtkIOXdmf2.vtkXdmfReader xdmf"),
        )
    ),
    Format(
        "read by meshio",
        ".msh .inp .bdf .nas .fem .med .mesh .meshb .vol .su2 .avs .off",
        AS_IS,
        (MESH,),
        "simulation_files.read_by_meshio",
        needs="meshio",
    ),
    # points in text
    Format(
        "table",
        ".csv",
        CALLER,
        (POINTS,),
        "control_point_files.read_text",
        (POINTS,),
        "point_tables.write",
    ),
    Format(
        "table, or elastix",
        ".txt .pts",
        CALLER,
        (POINTS,),
        "control_point_files.read_text",
        (POINTS,),
        "elastix_points.write",
    ),
    Format("table", ".csv .txt", CALLER, (), "", (PAIRS,), "point_tables.write_pairs"),
    Format(
        "markups of 3D Slicer",
        ".fcsv",
        HEADER,
        (POINTS,),
        "markups.read_fcsv",
        (POINTS,),
        "markups.write_fcsv",
    ),
    Format(
        "markups of 3D Slicer",
        ".mrk.json",
        HEADER,
        (POINTS,),
        "markups.read_json",
        (POINTS,),
        "markups.write_json",
    ),
)


def endings(*, reads: tuple[str, ...] = (), writes: tuple[str, ...] = ()) -> tuple[str, ...]:
    """Endings of what is read, or written, as one of these; each once, as the table has them."""
    lines = _lines(reads, writes)
    return tuple(dict.fromkeys(each for line in lines for each in line.endings.split()))


def extensions(reads: str) -> str:
    """Endings without their first dot, between blanks: as ParaView's file dialogs want them."""
    return " ".join(each[1:] for each in endings(reads=(reads,)))


def find(path: Path, **wanted: tuple[str, ...]) -> Format | None:
    """The line for a file, by its name; None without.

    Parameters
    ----------
    path : Path
    **wanted
        As of `endings`.
    """
    return next((line for line in _lines(**wanted) if line.ending(path)), None)


def choose(path: Path, purpose: str, **wanted: tuple[str, ...]) -> Format:
    """The line for a file, by its name.

    Parameters
    ----------
    path : Path
    purpose : str
        Such as "read a surface from", for the error.
    **wanted
        As of `endings`.

    Raises
    ------
    OSError, ValueError
        If there is none, naming the endings that there are.
    """
    found = find(path, **wanted)
    if found is None and path.is_dir():
        raise IsADirectoryError(f"`{path}` is a folder; expected a file")
    if found is None:
        raise ValueError(
            f"cannot {purpose} `{path}`: its name must end in one of "
            f"{', '.join(endings(**wanted))}{_missing(_lines(**wanted))}"
        )
    return found


def _lines(reads: tuple[str, ...] = (), writes: tuple[str, ...] = ()) -> list[Format]:
    return [line for line in TABLE if {*line.reads} & {*reads} or {*line.writes} & {*writes}]


def _missing(lines: list[Format]) -> str:
    """What could be read if something was installed, for the end of a sentence."""
    return "".join(
        f" ({', '.join(line.endings.split())} after `pip install {line.needs}`)"
        for line in lines
        if line.needs and importlib.util.find_spec(line.needs) is None
    )


def _function(name: str, *arguments: str) -> Callable[..., Any]:
    module, _, name = name.partition(".")
    function = getattr(importlib.import_module(f"vtk_mls.files.{module}"), name)
    return partial(function, *arguments) if arguments else function
