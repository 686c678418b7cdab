"""Files of single meshes.

3D Slicer states their frame: `SPACE=RAS` or `SPACE=LPS` is in the title of .vtk, the header of
.stl, a comment of .ply and .obj, and in a field array "SPACE" of VTK's XML files. Such meshes are
converted to LPS when they are read, with their active vectors, normals, displacements and paths,
and back when they are written. Meshes without it are not converted, as in
Slicer.
"""

import re

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE, VTK_UNSIGNED_CHAR, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPointSet, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkTriangleFilter
from vtkmodules.vtkIOPLY import vtkPLYWriter

from vtk_mls.base.errors import InputError
from vtk_mls.files import frames, metadata, vtk_io
from vtk_mls.vtk import arrays
from vtk_mls.vtk.control_point_polydata import DISPLACEMENT, PATH
from vtk_mls.vtk.objects import configured, output_of, shallow_copy

_FIELD = "SPACE"
_MIRRORED = DISPLACEMENT, PATH, metadata.FORWARD_DISPLACEMENT  # with active vectors and normals
_COLORS = "_Colors"  # by which a PLY writer finds them


def read(reader, path):
    """Read a mesh in LPS with a reader named as in `vtk_io.create`; a ValueError says that its
    space is not possible for a mesh.
    """
    reader = vtk_io.create(reader)
    dataset = vtk_io.read(reader, path)
    space = _space_of(reader, dataset)
    if not space or dataset is None:
        return dataset
    if not isinstance(dataset, vtkPointSet) or frames.signs(space).prod() < 0:
        raise ValueError(f"its SPACE must be LPS or RAS, and of a mesh with points, got {space}")
    dataset.GetFieldData().RemoveArray(_FIELD)  # data in memory are LPS
    metadata.store(dataset, metadata.FILE_SPACE, [space])
    return _mirrored(dataset, space)


def write(writer, dataset, path):
    """Write a mesh with a writer named as in `vtk_io.create`."""
    _write(vtk_io.create(writer), dataset, path)


def write_stl(polydata, path):
    """Write polydata that have polygons only."""
    _check_has_no(polydata, "Verts", "Lines")
    write("vtkIOGeometry.vtkSTLWriter", polydata, path)


def write_ply(polydata, path):
    """Write points and polygons with their colors. Polydata with lines are refused."""
    _check_has_no(polydata, "Lines")
    if polydata.GetNumberOfStrips():
        polydata = output_of(vtkTriangleFilter(), InputData=polydata)
    size = polydata.GetPolys().GetMaxCellSize()
    if size > 255:
        raise InputError(f"cannot hold a face of {size} points; write .vtp instead")
    writer = vtkPLYWriter()
    _write(writer, _colored(polydata, writer), path)
    vtk_io.check_size(path, _size_of_ply(polydata, path))


def left_out(polydata, path):
    """Names of the point and cell arrays that are not written to a file of this name."""
    points, cells = polydata.GetPointData(), polydata.GetCellData()
    suffix = path.suffix.lower()
    if suffix not in (".stl", ".ply"):
        return []
    written = []
    if suffix == ".ply":
        written = [points.GetNormals(), points.GetTCoords(), *map(_colors, (points, cells))]
    found = [*arrays.all_arrays(points), *arrays.all_arrays(cells)]
    names = [a.GetName() for a in found if not any(a is other for other in written)]
    return list(dict.fromkeys(names))


def _colored(polydata, writer):
    """The polygons of polydata, with colors in the array of the PLY writer."""
    colors = [_colors(polydata.GetPointData()), _colors(polydata.GetCellData())]
    counts = [array.GetNumberOfComponents() for array in colors if array is not None]
    if not counts:
        return polydata
    components = max(counts)
    configured(writer, ArrayName=_COLORS, EnableAlpha=components == 4)
    colored = configured(vtkPolyData(), Points=polydata.GetPoints(), Polys=polydata.GetPolys())
    colored.GetPointData().ShallowCopy(polydata.GetPointData())
    colored.GetFieldData().ShallowCopy(polydata.GetFieldData())
    rows = slice(None), slice(polydata.GetNumberOfVerts(), None)  # polygons come after vertices
    for array, target, part in zip(colors, (colored.GetPointData(), colored.GetCellData()), rows):
        if array is not None:
            values = arrays.to_numpy(array)[part]
            opaque = np.full((len(values), components - values.shape[1]), 255, np.uint8)
            arrays.add(target, _COLORS, np.hstack([values, opaque]))
    return colored


def _colors(attributes):
    """The array with the colors of points or cells; None without.

    The active array comes first, then the names that VTK's PLY reader uses, then the first array.
    """
    colors = [
        array
        for array in arrays.all_arrays(attributes)
        if array.GetDataType() == VTK_UNSIGNED_CHAR and array.GetNumberOfComponents() in (3, 4)
    ]
    active, rank = attributes.GetScalars(), {"RGBA": 1, "RGB": 2}
    return min(colors, key=lambda a: 0 if a is active else rank.get(a.GetName(), 3), default=None)


def _write(writer, dataset, path):
    if hasattr(writer, "SetFileTypeToBinary"):
        writer.SetFileTypeToBinary()
    vtk_io.write(writer, _in_file_frame(dataset, writer), path)


def _check_has_no(polydata, *kinds):
    """Raise InputError if polydata have cells that VTK's writer leaves out."""
    for kind in kinds:
        if getattr(polydata, f"GetNumberOf{kind}")():
            raise InputError(f"cannot hold {kind.lower()}; write .vtp instead")


def _size_of_ply(polydata, path):
    """The size of a .ply file in bytes, by its own header."""
    with path.open("rb") as file:
        header = file.read(4096).partition(b"end_header\n")[0]
    vertex_size, face_size = (
        4 * element.count(b"property float") + element.count(b"property uchar")
        for element in header.partition(b"element face")[::2]  # it can be cut off
    )
    faces = polydata.GetPolys()
    size = len(header + b"end_header\n") + vertex_size * polydata.GetNumberOfPoints()
    size += (1 + face_size) * faces.GetNumberOfCells()
    return size + 4 * faces.GetNumberOfConnectivityIds()


def _in_file_frame(dataset, writer):
    """A mesh in the frame of its source file, which the writer gets as text."""
    space = _valid_frame("".join(metadata.load(dataset, metadata.FILE_SPACE)[:1]))
    if not space or not isinstance(dataset, vtkPointSet):
        return dataset
    mesh, text = _mirrored(dataset, space), f"{_FIELD}={space}"
    if hasattr(writer, "AddComment"):  # .ply
        writer.AddComment(text)
    elif hasattr(writer, "SetHeader"):  # .vtk and .stl
        writer.SetHeader(f"vtk_mls {text}")
    else:
        metadata.store(mesh, _FIELD, [space])
    return mesh


def _space_of(reader, dataset):
    """The anatomical frame that a file names, or ""."""
    texts = []
    if dataset is not None:
        texts += [f"{_FIELD}={text}" for text in metadata.load(dataset, _FIELD)[:1]]
    for name in ("GetHeader", "GetComment", "GetComments"):
        text = getattr(reader, name, lambda: None)()
        if hasattr(text, "GetNumberOfValues"):
            texts += [text.GetValue(i) for i in range(text.GetNumberOfValues())]
        else:
            texts.append(text or "")
    texts = [text if isinstance(text, str) else text.decode("latin-1") for text in texts]
    match = re.search(rf"\b{_FIELD}=(\w+)", "\n".join(texts))
    return _valid_frame(match[1]) if match else ""


def _valid_frame(space):
    """An anatomical frame in capitals, or "" for other words, which Slicer ignores."""
    try:
        frames.signs(space)
    except ValueError:
        return ""
    return space.upper()


def _mirrored(mesh, space):
    """A mesh converted between LPS and another frame."""
    signs = frames.signs(space)
    mirrored = shallow_copy(mesh)
    if (signs == 1).all():
        return mirrored
    if mesh.GetPoints() is not None:
        points = mesh.GetPoints().GetData()
        values, kind = arrays.to_numpy(points), points.GetDataType()
        if values.dtype.kind == "u":
            values, kind = values.astype(np.float64), VTK_DOUBLE
        points = arrays.from_numpy((values * signs).astype(values.dtype), kind)
        mirrored.SetPoints(configured(vtkPoints(), Data=points))
    for attributes in (mirrored.GetPointData(), mirrored.GetCellData()):
        roles = [attributes.GetVectors(), attributes.GetNormals()]
        roles += [attributes.GetArray(name) for name in _MIRRORED]
        for name in {array.GetName() for array in roles if array is not None}:
            components = attributes.GetArray(name).GetNumberOfComponents()
            if components == 3 or (name == PATH and components % 3 == 0):
                values = arrays.to_numpy(attributes.GetArray(name))
                factors = np.tile(signs, components // 3)
                arrays.replace(attributes, name, (values * factors).astype(values.dtype))
    return mirrored
