"""Images, meshes, control points and surfaces from files, and datasets to files.

A broken file raises an error, unless it makes VTK's reader crash: that ends the process. The
command survives it (see `supervision`); a program that must, reads in a process of its own too.
"""

from __future__ import annotations

import re
from contextlib import contextmanager
from pathlib import Path

from vtkmodules.vtkCommonCore import vtkLogger, vtkOutputWindow, vtkStringOutputWindow
from vtkmodules.vtkCommonDataModel import vtkDataSet, vtkImageData, vtkPolyData
from vtkmodules.vtkIOGeometry import vtkOBJReader, vtkSTLReader, vtkSTLWriter
from vtkmodules.vtkIOLegacy import vtkDataSetReader, vtkDataSetWriter
from vtkmodules.vtkIOPLY import vtkPLYReader, vtkPLYWriter
from vtkmodules.vtkIOXML import (
    vtkXMLPolyDataReader,
    vtkXMLPolyDataWriter,
    vtkXMLRectilinearGridReader,
    vtkXMLStructuredGridReader,
    vtkXMLStructuredGridWriter,
    vtkXMLUnstructuredGridReader,
    vtkXMLUnstructuredGridWriter,
)

from vtk_mls import arguments, arrays, handle_files, image_files, mesh_frames, validity
from vtk_mls.filters.cutting import surfaces
from vtk_mls.filters.handle_lists import fill_polydata
from vtk_mls.landmarks import Landmarks, handles
from vtk_mls.replacing import check_replaceable, replacing

_WEIGHT = "Weight"
_LONGEST = 200  # characters of what others say in an error


def read_dataset(path):
    """Read an image or a mesh.

    Parameters
    ----------
    path : path
        An image: VTK XML (.vti), MetaImage (.mha, .mhd), NRRD (.nrrd, .nhdr, .seg.nrrd) or NIfTI
        (.nii, .nii.gz, .hdr with .img). A mesh: VTK XML (.vtu, .vtp, .vts, .vtr), .stl, .ply or
        .obj. Either: VTK legacy (.vtk).

    Returns
    -------
    vtkDataSet
        In LPS (see `nifti`, `nrrd`, `meta_image`, `mesh_frames`), images with the file's direction
        matrix. What a file of the same format is to have again, and which arrays are labels, are
        field data (see `provenance`).

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    path = _existing(path)
    read = _choose({**image_files.READERS, **_MESH_READERS}, path, "read an image or a mesh from")
    return _read(read, path, vtkDataSet, "no image and no mesh")


def write_dataset(dataset, path):
    """Write an image or a mesh.

    Parameters
    ----------
    dataset : vtkDataSet
    path : path
        Of an image: VTK XML (.vti) with everything, VTK legacy (.vtk) with all but a direction
        matrix; MetaImage (.mha, .mhd), NRRD (.nrrd, .nhdr, .seg.nrrd) or NIfTI (.nii, .nii.gz) with
        the active scalars, or the only point array. Of a mesh: VTK XML (.vtu, .vtp, .vts) or legacy
        (.vtk) with everything, .stl or .ply with the shape of polydata. A file that is there is
        replaced when the new one is complete.

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    path = check_writable(path, dataset)
    with replacing(path) as new, _failures(new):
        _writers(dataset)[_suffix(path)](dataset, new)


def check_writable(path, dataset):
    """`path` as a Path, if there is a format for it and such a dataset, and room for a file.

    The dataset may be one of another grid: what counts is its type.
    """
    path = Path(path)
    thing = "an image" if isinstance(dataset, vtkImageData) else f"a {dataset.GetClassName()}"
    _choose(_writers(dataset), path, f"write {thing} to")
    check_replaceable(path)
    return path


def read_control_points(path, deformed_path=None, space="LPS"):
    """Read control points.

    Parameters
    ----------
    path, deformed_path, space
        As of `handle_files.read`, or a path of VTK polydata (.vtp, .vtk) with points p and point
        vectors "Displacement" q - p; as `deformed_path` the points are q.

    Returns
    -------
    vtkPolyData
        As `handle_lists.fill_polydata` makes it, in LPS.

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    rest = read_landmarks(path, space, is_alone=not deformed_path)
    return control_points(rest, read_landmarks(deformed_path, space) if deformed_path else None)


def read_landmarks(path, space="LPS", is_alone=False):
    """Read points with their labels.

    Parameters
    ----------
    path : path
        As of `read_control_points`.
    space, is_alone
        As of `handle_files.read_landmarks`.

    Returns
    -------
    Landmarks
        In LPS.

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    path = _existing(path)
    _choose(_HANDLE_FORMATS, path, "read control points from")
    if _suffix(path) not in _POLYDATA_READERS:
        with _failures(path):
            return handle_files.read_landmarks(path, space, is_alone)
    polydata = _read(_POLYDATA_READERS[_suffix(path)], path, vtkPolyData, "no control points")
    with _failures(path):
        return _landmarks(path, polydata, is_alone).in_lps(space)


def control_points(rest, deformed=None):
    """Control-point polydata of `landmarks.handles(rest, deformed)`, if a map can be made of it."""
    found = handles(rest, deformed)
    polydata = vtkPolyData()
    with _failures(rest.path):
        fill_polydata(polydata, found.rest, found.deformed, found.weights, found.labels)
        arguments.points("rest", found.rest)
        arguments.points("deformed", found.deformed)
        arguments.positive_weights(found.weights, len(found.rest))
    arrays.add_texts(polydata.GetFieldData(), "Space", ["LPS"])
    return polydata


def read_surface(path):
    """Read the surface of a cut.

    Parameters
    ----------
    path : path
        VTK polydata (.vtp, .vtk) or .stl.

    Returns
    -------
    vtkPolyData

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    path = _existing(path)
    read = _choose(_SURFACE_READERS, path, "read a surface from")
    polydata = _read(read, path, vtkPolyData, "no surface")
    if not (polydata.GetNumberOfPolys() or polydata.GetNumberOfStrips()):
        raise ValueError(f"`{path}` holds no surface")
    return polydata


def read_cuts(path):
    """Read the surface of cuts.

    Parameters
    ----------
    path : path
        As of `read_surface`.

    Returns
    -------
    list of Surface
        One for each connected surface.

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    surface = read_surface(path)
    with _failures(path):
        return surfaces(surface)


def _read(read, path, kind, nothing):
    """What a reader makes of a file, if it is of this kind, not empty, and safe to compute with."""
    with _failures(path):
        dataset = read(path)
    if not isinstance(dataset, kind) or dataset.GetNumberOfPoints() < 1:
        raise ValueError(f"`{path}` holds {nothing}")
    with _failures(path):
        validity.check(dataset)
    return dataset


def _suffix(path):
    name = path.name.lower()
    double = (".nii.gz", ".mrk.json")
    return next((each for each in double if name.endswith(each)), path.suffix.lower())


def _choose(choices, path, purpose):
    if _suffix(path) not in choices:
        raise ValueError(
            f"cannot {purpose} `{path}`: its name must end in one of {', '.join(choices)}"
        )
    return choices[_suffix(path)]


def _existing(path):
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"there is no file `{path}`")
    return path


@contextmanager
def _failures(path):
    """What goes wrong, also what VTK only reports, becomes a ValueError that names the file."""
    usual, window = vtkOutputWindow.GetInstance(), vtkStringOutputWindow()
    verbosity = vtkLogger.GetCurrentVerbosityCutoff()
    vtkOutputWindow.SetInstance(window)
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        yield
    except MemoryError:
        raise ValueError(f"`{path}` needs more memory than there is") from None
    except (ArithmeticError, ValueError) as error:
        if f"`{path}`" in str(error):
            raise
        raise ValueError(f"`{path}` cannot be used: {_sentence(str(error))}") from error
    finally:
        vtkOutputWindow.SetInstance(usual)
        vtkLogger.SetStderrVerbosity(verbosity)
    errors = _reported(window.GetOutput())
    if errors:
        raise ValueError(f"`{path}`: VTK says: {_sentence(errors[0])}")


def _reported(text):
    """Errors in what VTK has printed, those that say a reason first."""
    if isinstance(text, bytes):  # it quotes a file that is no text
        text = text.decode(errors="replace")
    found = re.findall(r"ERROR: In [^\n]*\n[^\n]*?\): ([^\n]+)", text)
    found = [error for error in found if "did not create output" not in error]  # is seen anyway
    return sorted(found, key=lambda error: "returned failure for request" in error)


def _sentence(text):
    """The beginning of a text on one line, without what is not for reading."""
    text = re.sub(r" \(0x[0-9a-f]+\)", "", " ".join(text.split()))
    text = "".join(each if each.isprintable() else "?" for each in text)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def _writers(dataset):
    """Functions of a dataset and a path, by suffix."""
    if isinstance(dataset, vtkImageData):
        return image_files.WRITERS
    found = {".vtk": _write_with(vtkDataSetWriter)}
    for name, writers in _MESH_WRITERS.items():
        if dataset.IsA(name):
            found |= writers
    return found


def _write_with(kind):
    def write(dataset, path):
        writer = kind()
        if hasattr(writer, "SetFileTypeToBinary"):
            writer.SetFileTypeToBinary()
        image_files.write(writer, mesh_frames.back(dataset, writer), path)

    return write


def _write_ply(polydata, path):
    corners = polydata.GetPolys().GetMaxCellSize()
    if corners > 255:
        raise ValueError(f"`{path}` cannot hold a face of {corners} corners; write .vtp instead")
    writer = vtkPLYWriter()
    image_files.write(writer, mesh_frames.back(polydata, writer), path)
    with path.open("rb") as file:
        header = file.read(4096).partition(b"end_header\n")[0]
    of_vertex = 4 * header.count(b"property float") + header.count(b"property uchar")
    faces = polydata.GetPolys()
    size = len(header + b"end_header\n") + of_vertex * polydata.GetNumberOfPoints()
    size += faces.GetNumberOfCells() + 4 * faces.GetNumberOfConnectivityIds()
    image_files.check_size(path, size)


def _read_with(kind):
    return lambda path: mesh_frames.read(kind(), path)


def _landmarks(path, polydata, is_alone):
    """The points of polydata, in its frame; their partners only if it `is_alone`."""
    data, partners = polydata.GetPointData(), None
    weight = _WEIGHT if data.HasArray(_WEIGHT) else None
    if is_alone:
        places, partners, weights = arrays.control_points(polydata, "Displacement", weight)
        arguments.points("deformed", partners)
    else:
        places = arrays.to_numpy(polydata.GetPoints().GetData()).astype(float)
        weights = weight and arrays.to_numpy(data.GetArray(weight)).astype(float)
    arguments.points("rest", places)
    frame = "".join(arrays.texts(polydata.GetFieldData(), "Space"))
    labels = arrays.texts(data, "Label")
    return Landmarks(path, places, frame, labels, partners=partners, weights=weights)


_SURFACE_READERS = {
    ".stl": _read_with(vtkSTLReader),
    ".vtp": _read_with(vtkXMLPolyDataReader),
    ".vtk": _read_with(vtkDataSetReader),
}
_MESH_READERS = {
    **_SURFACE_READERS,
    ".vtu": _read_with(vtkXMLUnstructuredGridReader),
    ".vts": _read_with(vtkXMLStructuredGridReader),
    ".vtr": _read_with(vtkXMLRectilinearGridReader),
    ".ply": _read_with(vtkPLYReader),
    ".obj": _read_with(vtkOBJReader),
}
_MESH_WRITERS = {
    "vtkUnstructuredGrid": {".vtu": _write_with(vtkXMLUnstructuredGridWriter)},
    "vtkPolyData": {
        ".vtp": _write_with(vtkXMLPolyDataWriter),
        ".stl": _write_with(vtkSTLWriter),
        ".ply": _write_ply,
    },
    "vtkStructuredGrid": {".vts": _write_with(vtkXMLStructuredGridWriter)},
}
_POLYDATA_READERS = {
    ".vtp": _read_with(vtkXMLPolyDataReader),
    ".vtk": _read_with(vtkDataSetReader),
}
_HANDLE_FORMATS = dict.fromkeys((*handle_files.FORMATS, *_POLYDATA_READERS))
