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
from vtkmodules.vtkFiltersCore import vtkTriangleFilter
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

from vtk_mls import arguments, arrays
from vtk_mls.arrays import ImageGeometry
from vtk_mls.files import (
    control_point_files,
    field_files,
    image_files,
    mesh_files,
    mesh_frames,
    provenance,
    validity,
)
from vtk_mls.files.landmarks import Landmarks, handles
from vtk_mls.files.replacing import check_replaceable, replacing
from vtk_mls.filters.control_point_polydata import fill_polydata
from vtk_mls.filters.cut_inputs import surfaces

_WEIGHT = "Weight"
_LONGEST = 200  # characters of what others say in an error


def read_dataset(path):
    """Read an image or a mesh.

    Parameters
    ----------
    path : path
        An image: VTK XML (.vti), MetaImage (.mha, .mhd), NRRD (.nrrd, .nhdr, .seg.nrrd) or NIfTI
        (.nii, .nii.gz, .hdr with .img). A mesh: VTK XML (.vtu, .vtp, .vts, .vtr), .stl, .ply or
        .obj. Either: VTK legacy (.vtk). Any of these, or composite data: as `mesh_files` says.

    Returns
    -------
    vtkDataSet, vtkMultiBlockDataSet, vtkPartitionedDataSet or vtkPartitionedDataSetCollection
        In LPS (see `nifti`, `nrrd`, `meta_image`, `mesh_frames`), images with the file's direction
        matrix. What a file of the same format is to have again, and which arrays are labels, are
        field data (see `provenance`).

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    times, read = open_dataset(path)
    if len(times) > 1:
        raise ValueError(
            f"`{path}` has {len(times)} time steps, and one is wanted; `vtk-mls deform` takes all "
            "of them to a .pvd file"
        )
    return read(0)


def open_dataset(path):
    """What `read_dataset` reads, of one time step or several.

    Parameters
    ----------
    path : path

    Returns
    -------
    times : tuple of float
        Of time steps; empty if the file says none.
    read : callable
        Reads the dataset of a time step by its number (0 where there are none).

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    path = _existing(path)
    formats = {**image_files.READERS, **_MESH_READERS, **dict.fromkeys(mesh_files.FORMATS)}
    read_one = _choose(formats, path, "read an image or a mesh from", mesh_files.wanting())
    times, read = (), lambda number: read_one(path)
    if read_one is None:
        with _failures(path):
            times, read = mesh_files.open_file(path)
    kinds = (vtkDataSet, *mesh_files.COMPOSITE)
    return times, lambda number: _read(
        lambda _: read(number), path, kinds, "no image and no mesh that can be deformed"
    )


def write_dataset(dataset, path):
    """Write an image or a mesh.

    Parameters
    ----------
    dataset : vtkDataSet or composite data
    path : path
        Of an image: VTK XML (.vti) with everything, VTK legacy (.vtk) with all but a direction
        matrix; MetaImage (.mha, .mhd), NRRD (.nrrd, .nhdr, .seg.nrrd) or NIfTI (.nii, .nii.gz) with
        the active scalars, or the only point array. Of a mesh: VTK XML (.vtu, .vtp, .vts) or legacy
        (.vtk) with everything, .stl or .ply with the shape of polydata. Of composite data: .vtm
        or .vtpc; or that of the dataset if it is the only one. Of meshes and composite data: also
        .vtkhdf, if VTK is 9.4 or later. A file that is there is replaced when the new one is
        complete.

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    path = check_writable(path, dataset)
    blocks = mesh_files.blocks(dataset)
    if _suffix(path) not in mesh_files.WRITERS and len(blocks) == 1:
        dataset = blocks[0]
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


def write_field(image, path):
    """Write a displacement field, the active scalars of an image, as a transform.

    Parameters
    ----------
    image : vtkImageData
    path : path
        A transform: NIfTI (.nii, .nii.gz), NRRD (.nrrd, .nhdr) or MetaImage (.mha, .mhd). Or as of
        `write_dataset`.

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    path = check_field_writable(path)
    if _suffix(path) not in field_files.FORMATS:
        write_dataset(image, path)
        return
    values = arrays.to_numpy(image.GetPointData().GetScalars())
    displacement = values.reshape(*image.GetDimensions()[::-1], 3)
    with replacing(path) as new, _failures(new):
        field_files.write(displacement, ImageGeometry.of_image(image).grid, new)


def check_field_writable(path):
    """`path` as a Path, if there is a format for it, and room for a file."""
    path = Path(path)
    formats = dict.fromkeys([*field_files.FORMATS, *image_files.WRITERS])
    _choose(formats, path, "write a displacement field to")
    check_replaceable(path)
    return path


def read_control_points(path, deformed_path=None, space="LPS"):
    """Read control points.

    Parameters
    ----------
    path, deformed_path, space
        As of `control_point_files.read`, or a path of VTK polydata (.vtp, .vtk) with points p and
        point vectors "Displacement" q - p; as `deformed_path` the points are q.

    Returns
    -------
    vtkPolyData
        As `control_point_polydata.fill_polydata` makes it, in LPS.

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
        As of `control_point_files.read_landmarks`.

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
            return control_point_files.read_landmarks(path, space, is_alone)
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
    provenance.keep(polydata, provenance.SPACE, ["LPS"])
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
    blocks = mesh_files.blocks(dataset) if isinstance(dataset, kind) else []
    if not any(block.GetNumberOfPoints() for block in blocks):
        raise ValueError(f"`{path}` holds {nothing}")
    with _failures(path):
        for block in blocks:
            validity.check(block)
    return dataset


def _suffix(path):
    name = path.name.lower()
    double = (".nii.gz", ".mrk.json")
    return next((each for each in double if name.endswith(each)), path.suffix.lower())


def _choose(choices, path, purpose, note=""):
    if _suffix(path) not in choices:
        raise ValueError(
            f"cannot {purpose} `{path}`: its name must end in one of {', '.join(choices)}{note}"
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
    if isinstance(dataset, mesh_files.COMPOSITE):
        blocks = mesh_files.blocks(dataset)
        return mesh_files.WRITERS | (_writers(blocks[0]) if len(blocks) == 1 else {})
    found = {".vtk": _write_with(vtkDataSetWriter), ".vtkhdf": mesh_files.WRITERS[".vtkhdf"]}
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


def _write_stl(polydata, path):
    _check_has_no(polydata, path, "Verts", "Lines")
    _write_with(vtkSTLWriter)(polydata, path)


def _write_ply(polydata, path):
    _check_has_no(polydata, path, "Lines")
    if polydata.GetNumberOfStrips():
        triangles = vtkTriangleFilter()
        triangles.SetInputData(polydata)
        triangles.Update()
        polydata = triangles.GetOutput()
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


def _check_has_no(polydata, path, *kinds):
    """Raise ValueError if polydata have cells of a kind, which VTK's writer would leave out."""
    for kind in kinds:
        if getattr(polydata, f"GetNumberOf{kind}")():
            raise ValueError(f"`{path}` cannot hold {kind.lower()}; write .vtp instead")


def _read_with(kind):
    return lambda path: mesh_frames.read(kind(), path)


def _landmarks(path, polydata, is_alone):
    """The points of polydata, in its frame; they must have partners if it `is_alone`."""
    data, partners = polydata.GetPointData(), None
    weight = _WEIGHT if data.HasArray(_WEIGHT) else None
    if is_alone or data.HasArray("Displacement"):
        places, partners, weights = arrays.control_points(polydata, "Displacement", weight)
        arguments.points("deformed", partners)
    else:
        places = arrays.to_numpy(polydata.GetPoints().GetData()).astype(float)
        weights = weight and arrays.to_numpy(data.GetArray(weight)).astype(float)
    arguments.points("rest", places)
    was_turned = bool(provenance.kept(polydata, provenance.FILE_SPACE))
    frame = "LPS" if was_turned else "".join(provenance.kept(polydata, provenance.SPACE))
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
        ".stl": _write_stl,
        ".ply": _write_ply,
    },
    "vtkStructuredGrid": {".vts": _write_with(vtkXMLStructuredGridWriter)},
}
_POLYDATA_READERS = {
    ".vtp": _read_with(vtkXMLPolyDataReader),
    ".vtk": _read_with(vtkDataSetReader),
}
_HANDLE_FORMATS = dict.fromkeys((*control_point_files.FORMATS, *_POLYDATA_READERS))
