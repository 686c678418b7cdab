"""Images, meshes, control points and surfaces from files, and datasets to files.

Functions raise OSError or ValueError, which name the file, also for broken files; unless they make
VTK's reader crash, which ends the process. The command line runs in a child process for that reason
(see `supervision`).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray
from vtkmodules.vtkCommonDataModel import (
    vtkDataObject,
    vtkDataSet,
    vtkImageData,
    vtkPointSet,
    vtkPolyData,
)

from vtk_mls.base import validation
from vtk_mls.base.errors import InputError
from vtk_mls.files import control_point_files, field_files, formats, mesh_files, metadata, vtk_io
from vtk_mls.files.block_files import COMPOSITE, block_writer, blocks, leaves
from vtk_mls.files.field_files import FieldContent, read_transform, write_transform
from vtk_mls.files.landmarks import Landmarks, paired
from vtk_mls.files.paths import check_replaceable, existing_file, replacing
from vtk_mls.files.vtk_io import failures_named
from vtk_mls.filters.map_inputs import surfaces
from vtk_mls.model import arguments
from vtk_mls.model.cuts import Surface
from vtk_mls.model.handles.handle import Handle
from vtk_mls.model.handles.handle_cells import cells_of_handles, handles_of_cells
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.control_point_polydata import cells_of, fill_polydata, path_of

__all__ = [
    "control_points",
    "read_control_points",
    "read_cuts",
    "read_dataset",
    "read_handles",
    "read_landmarks",
    "read_surface",
    "read_transform",
    "write_dataset",
    "write_field",
    "write_handles",
    "write_transform",
]
_PathLike = Union[str, PathLike[str]]
DATASETS = (formats.IMAGE, formats.MESH, formats.BLOCKS)


def read_dataset(path: _PathLike) -> vtkDataObject:
    """Read an image or a mesh.

    Parameters
    ----------
    path : path
        Of an image, a mesh, blocks or pieces, as docs/formats.md lists them; or a folder with the
        slices of a series of DICOM.

    Returns
    -------
    vtkDataSet, vtkMultiBlockDataSet, vtkPartitionedDataSet or vtkPartitionedDataSetCollection
        In LPS (see docs/frames.md), images with the file's direction matrix. Field data hold the
        names of label arrays and what a file of the same format gets again (see `metadata`).
    """
    times, read = open_dataset(path)
    if len(times) > 1:
        raise InputError(
            f"has {len(times)} time steps, expected one; write one of them to a file, for only the "
            "input of `vtk-mls deform` may have several",
            path=path,
        )
    return read(0)


def open_dataset(path: _PathLike) -> tuple[tuple[float, ...], Callable[[int], vtkDataObject]]:
    """The times of a file for `read_dataset`, in seconds if the file states a unit, () without any,
    and a function that reads the dataset of one by its index (0 without any).
    """
    path = Path(path) if os.fspath(path) and Path(path).is_dir() else existing_file(path)
    line = formats.choose(path, "read an image or a mesh from", reads=DATASETS)
    times, read = (), lambda index: line.read(path)
    if line.has_times:
        with failures_named(path):
            times, read = line.read(path)
    kinds = (vtkDataSet, *COMPOSITE)
    return times, lambda index: _checked(
        lambda: read(index), path, kinds, "no image and no mesh that can be deformed"
    )


def write_dataset(dataset: vtkDataObject, path: _PathLike) -> None:
    """Write an image or a mesh.

    Parameters
    ----------
    dataset : vtkDataSet or composite data
    path : path
        Of a format that docs/formats.md lists for this type of data. Composite data with one
        dataset can be written as that dataset. VTK's formats hold everything (.vtk no direction
        matrix), other image formats the active scalars or the only point array, .stl the shape,
        .ply the shape with normals, texture coordinates and colors (3 or 4 unsigned char). An old
        file is replaced when the new one is complete.
    """
    path = Path(path)
    line = check_writable(path, dataset)
    if isinstance(dataset, vtkImageData) and dataset.GetNumberOfPoints() == 0:
        raise InputError("is not written: the image is empty; has its filter failed?", path=path)
    parts = blocks(dataset)
    if formats.BLOCKS not in line.writes and len(parts) == 1:
        dataset = parts[0]
    with replacing(path) as new, failures_named(new):
        line.write(dataset, new)


def left_out(dataset: vtkDataObject, path: _PathLike) -> list[str]:
    """Names of the point and cell arrays of a mesh that `write_dataset` leaves out of a file.

    Or the classes of blocks, such as tables.
    """
    parts = blocks(dataset)
    polydata = parts[0] if len(parts) == 1 else dataset
    names: list[str] = []
    if isinstance(polydata, vtkPolyData):
        names = mesh_files.left_out(polydata, Path(path))
    has_blocks = formats.BLOCKS in check_writable(path, dataset).writes
    others = (leaf for leaf in leaves(dataset) if not isinstance(leaf, vtkDataSet))
    return names + [o.GetClassName() for o in others if not has_blocks or block_writer(o) is None]


def check_writable(path: _PathLike, dataset: vtkDataObject) -> formats.Format:
    """The format of a file, if a dataset of this type can be written to it."""
    path = Path(path)
    thing = "an image" if isinstance(dataset, vtkImageData) else f"a {dataset.GetClassName()}"
    line = formats.choose(path, f"write {thing} to", writes=_types(dataset))
    check_replaceable(path)
    return line


def _types(dataset: vtkDataObject) -> tuple[str, ...]:
    """The types of a dataset in `formats`."""
    if isinstance(dataset, vtkImageData):
        return (formats.IMAGE,)
    if isinstance(dataset, COMPOSITE):
        parts = blocks(dataset)
        return (formats.BLOCKS, *(_types(parts[0]) if len(parts) == 1 else ()))
    types = {
        "vtkPolyData": formats.POLYDATA,
        "vtkStructuredGrid": formats.STRUCTURED,
        "vtkUnstructuredGrid": formats.UNSTRUCTURED,
    }
    return (formats.MESH, *(kind for name, kind in types.items() if dataset.IsA(name)))


def write_field(image: vtkImageData, path: _PathLike, convention: str = "itk") -> None:
    """Write a displacement field, the active scalars of an image, as a transform.

    Parameters
    ----------
    image : vtkImageData
    path, convention
        As of `field_files.write`, as a transform; or a path as of `write_dataset`.
    """
    path = check_field_writable(path)
    field_files.check_convention(convention)
    as_transform = formats.find(path, writes=(formats.FIELD,))
    if as_transform is None:
        write_dataset(image, path)
        return
    array = image.GetPointData().GetScalars()
    content = FieldContent(
        arrays.to_numpy(array).reshape(*image.GetDimensions()[::-1], 3),
        ImageGeometry.of_image(image).grid,
        array.GetName() == metadata.FORWARD_DISPLACEMENT,
        metadata.load(image, metadata.NIFTI_HEADER),
        convention,
        "".join(metadata.load(image, metadata.LENGTH_UNIT)),
    )
    with replacing(path) as new, failures_named(new):
        as_transform.write(content, new)


def check_field_writable(path: _PathLike) -> Path:
    """`path` as a Path, if a field can be written to it."""
    path = Path(path)
    formats.choose(path, "write a displacement field to", writes=(formats.FIELD, formats.IMAGE))
    check_replaceable(path)
    return path


def read_control_points(
    path: _PathLike, deformed_path: _PathLike | None = None, space: str = "LPS"
) -> vtkPolyData:
    """Read control points.

    Parameters
    ----------
    path : path
        Of points in text, as docs/formats.md lists them; or of VTK's points (.vtp, .vtu, .vts,
        .vtk), with point vectors "Displacement" q - p and perhaps "Path".
    deformed_path : path, optional
        Another file, whose positions are q (see `landmarks.paired`).
    space : str
        The frame of files that do not say theirs, as in `frames.signs`.

    Returns
    -------
    vtkPolyData
        As `control_point_polydata.fill_polydata` makes it, in LPS, with the lines and surfaces of
        .vtp, .vtu, .vts and .vtk and the curves of .mrk.json.
    """
    rest = read_landmarks(path, space, is_alone=not deformed_path)
    return control_points(rest, read_landmarks(deformed_path, space) if deformed_path else None)


def read_handles(
    path: _PathLike, deformed_path: _PathLike | None = None, space: str = "LPS"
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any] | None, list[Handle]]:
    """Read control points, curves and rigid regions.

    Parameters
    ----------
    path, deformed_path, space
        As of `read_control_points`. Vertices, and points without a cell, are points; lines, and
        the curves of .mrk.json, are curves; closed surfaces that move rigidly are regions.

    Returns
    -------
    rest, deformed : (n, 3) float64, LPS
        Of points.
    weights : (n,) float64 or None
    handles : list of CurveHandle and RegionHandle
    """
    with failures_named(path):
        return handles_of(read_control_points(path, deformed_path, space))


def handles_of(
    polydata: vtkPolyData,
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any] | None, list[Handle]]:
    """The handles of control-point polydata, as `read_handles` returns them."""
    weight = "Weight" if polydata.GetPointData().HasArray("Weight") else None
    rest, deformed, weights = arrays.control_points(polydata, "Displacement", weight)
    return handles_of_cells(rest, deformed, weights, cells_of(polydata))


def write_handles(
    path: _PathLike,
    rest: ArrayLike = (),
    deformed: ArrayLike = (),
    weights: ArrayLike | None = None,
    handles: Sequence[Handle] = (),
    between: ArrayLike | None = None,
) -> None:
    """Write control points, curves and rigid regions, for `read_handles`.

    Parameters
    ----------
    path : path
        Ending in .vtp or .vtk.
    rest, deformed : (n, 3) array_like, LPS
        Of points.
    weights : (n,) array_like, optional
    handles : sequence of CurveHandle and RegionHandle
        Regions must have the shape Solid.
    between : (k, n, 3) array_like, LPS, optional
        Intermediate places of points, the `path` of a `Deformation`.

    Raises
    ------
    OSError, TypeError, ValueError
        Naming the argument or the file.
    """
    formats.choose(Path(path), "write handles to", reads=(formats.POINT_DATA,))
    p = arguments.control_points("rest", rest)
    q = arguments.control_points("deformed", deformed)
    validation.same_count(p, q)
    shaped = validation.values_of("handles", handles, Handle)
    places = arguments.path(between, len(p), "between")
    all_p, all_q, cells = cells_of_handles(p, q, shaped)
    factors = None
    if weights is not None:
        factors = np.ones(len(all_p))
        factors[: len(p)] = arguments.positive_weights(weights, len(p))
    polydata = vtkPolyData()
    path_of_all = np.tile(all_p, (len(places), 1, 1))  # the path of shapes does not count
    path_of_all[:, : len(p)] = places
    fill_polydata(polydata, all_p, all_q, factors, cells=cells, path=path_of_all)
    metadata.store(polydata, metadata.SPACE, ["LPS"])
    write_dataset(polydata, path)


def read_landmarks(
    path: _PathLike, space: str = "LPS", is_alone: bool = False, time: float | None = None
) -> Landmarks:
    """Read points with their labels.

    Parameters
    ----------
    path : path
        As of `read_control_points`.
    space : str
        As of `read_control_points`.
    is_alone : bool
        Whether these are control points without a second file for q. A table must then have pairs,
        or a header without them.
    time : float, optional
        Of a table with a column of times, the points of the last time that is not later, or the
        first ones. By default control points of several times are an error.

    Returns
    -------
    Landmarks
        In LPS.
    """
    path = existing_file(path)
    roles = (formats.POINTS, formats.POINT_DATA)
    line = formats.choose(path, "read control points from", reads=roles)
    if formats.POINTS in line.reads:
        with failures_named(path):
            return control_point_files.read_landmarks(path, space, is_alone, time)
    point_set = _checked(lambda: line.read(path), path, vtkPointSet, "no control points")
    with failures_named(path):
        return _landmarks_of(point_set, path, is_alone).in_lps(space)


def _landmarks_of(point_set: vtkPointSet, path: Path, is_alone: bool) -> Landmarks:
    """Points in the frame of their file. They must have partners if the file `is_alone`."""
    data, partners, more = point_set.GetPointData(), None, {}
    weight = "Weight" if data.HasArray("Weight") else None
    if is_alone or data.HasArray("Displacement"):
        points, partners, weights = arrays.control_points(point_set, "Displacement", weight)
        validation.points("deformed", partners)
        more["places"] = path_of(point_set)
    else:
        points = arrays.to_numpy(point_set.GetPoints().GetData()).astype(float)
        weights = weight and arrays.to_numpy(data.GetArray(weight)).astype(float)
    validation.points("rest", points)
    is_lps = bool(metadata.load(point_set, metadata.FILE_SPACE))
    frame = "LPS" if is_lps else "".join(metadata.load(point_set, metadata.SPACE))
    labels = arrays.texts(data, "Label")
    cells = cells_of(point_set)
    more["cells"] = cells if cells.has_shapes else None
    return Landmarks(path, points, frame, labels, partners=partners, weights=weights, **more)


def control_points(
    rest: Landmarks,
    deformed: Landmarks | None = None,
    between: Sequence[Landmarks] = (),
    pair_by: str = "",
) -> vtkPolyData:
    """Control-point polydata of `landmarks.paired(...)`, checked as for a map."""
    pairs = paired(rest, deformed, between, pair_by)
    polydata = vtkPolyData()
    with failures_named(rest.path):
        fill_polydata(polydata, *pairs)
        validation.points("rest", pairs.rest)
        validation.points("deformed", pairs.deformed)
        arguments.positive_weights(pairs.weights, len(pairs.rest))
    metadata.store(polydata, metadata.SPACE, ["LPS"])
    return polydata


def read_surface(path: _PathLike) -> vtkPolyData:
    """Read the surface of a cut.

    Parameters
    ----------
    path : path
        VTK polydata (.vtp, .vtk) or .stl.

    Returns
    -------
    vtkPolyData
    """
    path = existing_file(path)
    line = formats.choose(path, "read a surface from", reads=(formats.SURFACE,))
    polydata: vtkPolyData = _checked(lambda: line.read(path), path, vtkPolyData, "no surface")
    if not (polydata.GetNumberOfPolys() or polydata.GetNumberOfStrips()):
        raise InputError("holds no surface", path=path)
    return polydata


def read_cuts(path: _PathLike) -> list[Surface]:
    """Read the surface of cuts.

    Parameters
    ----------
    path : path
        As of `read_surface`.

    Returns
    -------
    list of Surface
        One for each connected surface.
    """
    surface = read_surface(path)
    with failures_named(path):
        cuts: list[Surface] = surfaces(surface)
    return cuts


def _checked(
    read: Callable[[], Any], path: Path, kind: type | tuple[type, ...], absent: str
) -> Any:
    """The result of a reader, if it is of this kind, not empty, and valid."""
    with failures_named(path):
        dataset = read()
    parts = blocks(dataset) if isinstance(dataset, kind) else []
    if not parts:
        raise InputError(f"holds {absent}", path=path)
    with failures_named(path):
        for part in parts:
            vtk_io.check_dataset(part)
    return dataset
