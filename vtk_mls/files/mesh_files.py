"""Single meshes as files, in the frame that a file says (see `mesh_frames`)."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonCore import VTK_UNSIGNED_CHAR
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkTriangleFilter
from vtkmodules.vtkIOGeometry import vtkSTLWriter
from vtkmodules.vtkIOPLY import vtkPLYWriter

from vtk_mls.files import mesh_frames, vtk_io
from vtk_mls.vtk import arrays

_COLORS = "_Colors"  # by which a PLY writer finds them


def read(reader, path):
    """A mesh in LPS, by a reader of VTK's, which is named by its module and class."""
    return mesh_frames.read(vtk_io.made(reader), path)


def write(writer, dataset, path):
    """Write a mesh with a writer of VTK's, which is named by its module and class."""
    _write(vtk_io.made(writer), dataset, path)


def write_stl(polydata, path):
    """Write the polygons of polydata, which must have nothing else."""
    _check_has_no(polydata, path, "Verts", "Lines")
    _write(vtkSTLWriter(), polydata, path)


def write_ply(polydata, path):
    """Write the points and polygons of polydata, which must have no lines, with their colors."""
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
    _write(writer, _colored(polydata, writer), path)
    vtk_io.check_size(path, _size_of_ply(polydata, path))


def left_out(polydata, path):
    """Names of the point and cell arrays that a file, by its name, does not get."""
    points, cells = polydata.GetPointData(), polydata.GetCellData()
    suffix = path.suffix.lower()
    if suffix not in (".stl", ".ply"):
        return []
    kept = []
    if suffix == ".ply":
        kept = [points.GetNormals(), points.GetTCoords(), *map(_colors, (points, cells))]
    held = [data.GetAbstractArray(i) for data in (points, cells) for i in _numbers(data)]
    names = [array.GetName() for array in held if not any(array is each for each in kept)]
    return list(dict.fromkeys(names))


def _colored(polydata, writer):
    """The polygons of polydata with colors where a PLY writer looks for them."""
    data = polydata.GetPointData(), polydata.GetCellData()
    colors = [_colors(attributes) for attributes in data]
    counts = [array.GetNumberOfComponents() for array in colors if array is not None]
    if not counts:
        return polydata
    components = max(counts)
    writer.SetArrayName(_COLORS)
    writer.SetEnableAlpha(components == 4)
    colored = vtkPolyData()
    colored.SetPoints(polydata.GetPoints())
    colored.SetPolys(polydata.GetPolys())
    colored.GetPointData().ShallowCopy(polydata.GetPointData())
    colored.GetFieldData().ShallowCopy(polydata.GetFieldData())
    rows = slice(None), slice(polydata.GetNumberOfVerts(), None)  # polygons come after vertices
    targets = colored.GetPointData(), colored.GetCellData()
    for array, target, part in zip(colors, targets, rows):
        if array is not None:
            values = arrays.to_numpy(array)[part]
            opaque = np.full((len(values), components - values.shape[1]), 255, np.uint8)
            arrays.add(target, _COLORS, np.hstack([values, opaque]))
    return colored


def _colors(attributes):
    """The array with the colors of points or cells; None without.

    Of several it is the active one, or that which PLY files are read with, or the first.
    """
    held = [attributes.GetArray(i) for i in _numbers(attributes)]
    found = [array for array in held if array is not None and _is_color(array)]
    scalars, names = attributes.GetScalars(), [array.GetName() for array in found]
    if any(array is scalars for array in found):
        return scalars
    usual = next((names.index(name) for name in ("RGBA", "RGB") if name in names), 0)
    return found[usual] if found else None


def _is_color(array):
    return array.GetDataType() == VTK_UNSIGNED_CHAR and array.GetNumberOfComponents() in (3, 4)


def _numbers(attributes):
    return range(attributes.GetNumberOfArrays())


def _write(writer, dataset, path):
    if hasattr(writer, "SetFileTypeToBinary"):
        writer.SetFileTypeToBinary()
    vtk_io.write(writer, mesh_frames.back(dataset, writer), path)


def _check_has_no(polydata, path, *kinds):
    """Raise ValueError if polydata have cells of a kind, which VTK's writer would leave out."""
    for kind in kinds:
        if getattr(polydata, f"GetNumberOf{kind}")():
            raise ValueError(f"`{path}` cannot hold {kind.lower()}; write .vtp instead")


def _size_of_ply(polydata, path):
    """The bytes that a .ply file must have, by its own header."""
    with path.open("rb") as file:
        header = file.read(4096).partition(b"end_header\n")[0]
    of_vertex, of_face = (
        4 * element.count(b"property float") + element.count(b"property uchar")
        for element in header.partition(b"element face")[::2]  # it can be cut off
    )
    faces = polydata.GetPolys()
    size = len(header + b"end_header\n") + of_vertex * polydata.GetNumberOfPoints()
    size += (1 + of_face) * faces.GetNumberOfCells()
    return size + 4 * faces.GetNumberOfConnectivityIds()
