"""VTK's own readers and writers, whose failures become errors, and checks of what they read.

VTK's readers return the contents of a broken file unchecked: point ids out of range, arrays of
wrong lengths, unknown cell types. VTK's filters do not check them either, and access memory out of
bounds.
"""

import errno
import importlib
import math
import os
import re
from contextlib import contextmanager

import numpy as np
from vtkmodules.vtkCommonCore import vtkLogger, vtkOutputWindow, vtkStringOutputWindow, vtkVersion
from vtkmodules.vtkCommonDataModel import vtkGenericCell
from vtkmodules.vtkCommonMisc import vtkErrorCode

from vtk_mls.base.errors import InputError
from vtk_mls.files.paths import replacing
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.cells import connectivity_of, polydata_cells
from vtk_mls.vtk.objects import configured

_MAX_TEXT = 200  # characters of a quoted error
_HIGHER_ORDER = 60  # cells of this type and above have a minimum number of points


def create(name):
    """A new reader or writer by module and class, such as `vtkIOXML.vtkXMLPolyDataReader`; a
    ValueError says that this VTK has none.
    """
    module, _, kind = name.partition(".")
    try:
        return getattr(importlib.import_module(f"vtkmodules.{module}"), kind)()
    except (AttributeError, ImportError):
        raise ValueError(
            f"this VTK, {vtkVersion.GetVTKVersion()}, has no {kind}; `pip install vtk` does"
        ) from None


def read(reader, path):
    configured(reader, FileName=str(path)).Update()
    return reader.GetOutputDataObject(0)


def write(writer, dataset, path):
    configured(writer, InputData=dataset, FileName=str(path)).Write()
    code = writer.GetErrorCode()
    if code == vtkErrorCode.OutOfDiskSpaceError:
        raise _disk_full()
    if code:
        raise OSError(vtkErrorCode.GetStringFromErrorCode(code))


def write_png(picture, path):
    """Write a vtkImageData as a .png file. An old file is replaced when the new one is complete."""
    writer = configured(create("vtkIOImage.vtkPNGWriter"), InputData=picture)
    writer.SetWriteToMemory(True)  # to a file, it does not say why it fails
    writer.Write()
    with replacing(path) as new:
        new.write_bytes(memoryview(writer.GetResult()))


def check_size(path, size):
    """Raise OSError unless a file has so many bytes, for writers that miss a full disk."""
    if path.stat().st_size != size:
        raise _disk_full()


@contextmanager
def failures_named(path):
    """Turn errors, also those that VTK only prints, into an InputError of the file."""
    default_window, window = vtkOutputWindow.GetInstance(), vtkStringOutputWindow()
    verbosity = vtkLogger.GetCurrentVerbosityCutoff()
    vtkOutputWindow.SetInstance(window)
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        yield
    except MemoryError:
        raise InputError("needs more memory than there is", path=path) from None
    except (ArithmeticError, ValueError) as error:
        if getattr(error, "path", ""):
            raise
        predicate = f"cannot be used: {_sentence(str(error))}"
        if isinstance(error, InputError) and not error.name:
            predicate = error.predicate
        raise InputError(predicate, path=path) from error
    finally:
        vtkOutputWindow.SetInstance(default_window)
        vtkLogger.SetStderrVerbosity(verbosity)
    errors = _reported(window.GetOutput())
    if errors:
        raise InputError(f": VTK says: {_sentence(errors[0])}", path=path)


def _reported(text):
    """Errors that VTK has printed, those with a reason first."""
    if isinstance(text, bytes):  # it quotes a binary file
        text = text.decode(errors="replace")
    errors = re.findall(r"ERROR: In [^\n]*\n[^\n]*?\): ([^\n]+)", text)
    errors = [error for error in errors if "did not create output" not in error]  # no reason
    return sorted(errors, key=lambda error: "returned failure for request" in error)


def _sentence(text):
    """The beginning of a text on one line.

    Addresses, folders of `paths.replacing` and control characters are left out.
    """
    text = re.sub(r" \(0x[0-9a-f]+\)|\.vtk-mls-\d+-\w+[/\\]", "", " ".join(text.split()))
    text = "".join(letter if letter.isprintable() else "?" for letter in text)
    return text if len(text) <= _MAX_TEXT else f"{text[:_MAX_TEXT]}..."


def _disk_full():
    return OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def check_dataset(dataset):
    """Raise ValueError if a vtkDataSet is broken."""
    if dataset.IsA("vtkImageData") and dataset.GetNumberOfPoints():
        ImageGeometry.of_image(dataset).grid  # noqa: B018  raises if broken
    if dataset.IsA("vtkRectilinearGrid"):
        _check_axes(dataset)
    if dataset.IsA("vtkPointSet"):
        _check_points(dataset)
    if dataset.IsA("vtkPolyData"):
        for _, cells in polydata_cells(dataset):
            _check_connectivity(cells, dataset.GetNumberOfPoints())
    if dataset.IsA("vtkUnstructuredGrid"):
        _check_grid(dataset)
    arrays.check_lengths(dataset, are_exact=True)


def _check_axes(grid):
    axes = grid.GetXCoordinates(), grid.GetYCoordinates(), grid.GetZCoordinates()
    sizes = tuple(0 if axis is None else axis.GetNumberOfTuples() for axis in axes)
    if sizes != _dimensions(grid):
        raise ValueError(f"it must have {_dimensions(grid)} coordinates, got {sizes}")


def _check_points(mesh):
    points = mesh.GetPoints()
    if points is not None and points.GetData().GetNumberOfComponents() != 3:
        raise ValueError("its points must have three coordinates")
    count = 0 if points is None else points.GetNumberOfPoints()
    if mesh.IsA("vtkStructuredGrid") and math.prod(_dimensions(mesh)) != count:
        raise ValueError(f"it must have {_dimensions(mesh)} points, got {count} in all")


def _dimensions(grid):
    first, last = grid.GetExtent()[::2], grid.GetExtent()[1::2]
    dimensions = tuple(end - start + 1 for start, end in zip(first, last))
    if min(dimensions) < 1:
        raise ValueError(f"its dimensions must be positive, got {dimensions}")
    return dimensions


def _check_grid(grid):
    if grid.GetNumberOfCells() == 0:
        return
    sizes = _check_connectivity(grid.GetCells(), grid.GetNumberOfPoints())
    types = arrays.cell_types(grid)
    if len(types) != len(sizes):
        raise ValueError(f"it must have a type for each of the {len(sizes)} cells")
    for kind in np.unique(types).tolist():
        cell = vtkGenericCell.InstantiateCell(kind)
        if cell is None:
            raise ValueError(f"it has a cell of the type {kind}, which VTK does not have")
        count, counts = cell.GetNumberOfPoints(), sizes[types == kind]
        wrong = counts < count if kind >= _HIGHER_ORDER else (counts != count) & (count > 0)
        if wrong.any():
            raise ValueError(
                f"a {cell.GetClassName()} has {count} points, got one with {counts[wrong][0]}"
            )
    faces = getattr(grid, "GetPolyhedronFaces", lambda: None)()  # VTK 9.4
    if faces is not None and faces.GetNumberOfCells():
        _check_connectivity(faces, grid.GetNumberOfPoints())
        _check_connectivity(grid.GetPolyhedronFaceLocations(), faces.GetNumberOfCells())


def _check_connectivity(cells, count):
    """Number of points of each cell (n,), if all point ids are below `count`."""
    connectivity, offsets = connectivity_of(cells)
    sizes = np.diff(offsets)
    if offsets[0] != 0 or offsets[-1] != len(connectivity) or (sizes < 0).any():
        raise ValueError("its cell offsets do not fit its connectivity")
    if len(connectivity) and not 0 <= connectivity.min() <= connectivity.max() < count:
        raise ValueError(
            f"the point ids of its cells must be from 0 to {count - 1}, got "
            f"{connectivity.min()} to {connectivity.max()}"
        )
    return sizes
