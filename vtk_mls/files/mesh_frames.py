"""The frame of a mesh file, as 3D Slicer writes it: `SPACE=RAS` or `SPACE=LPS`.

It is in the title of .vtk, the header of .stl, a comment of .ply and .obj, and in a field array
"SPACE" of VTK's XML files. Such meshes are converted to LPS when they are read, with their active
vectors, normals, and displacements and paths of control points, and back when they are written.
Meshes without it are not converted, as in Slicer.
"""

import re

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPointSet

from vtk_mls.files import frames, metadata, vtk_io
from vtk_mls.vtk import arrays
from vtk_mls.vtk.control_point_polydata import DISPLACEMENT, PATH

_FIELD = "SPACE"


def read(reader, path):
    """Read a mesh in LPS; a ValueError says that its space is not possible for a mesh."""
    dataset = vtk_io.read(reader, path)
    space = _space_of(reader, dataset)
    if not space or dataset is None:
        return dataset
    if not isinstance(dataset, vtkPointSet) or frames.signs(space).prod() < 0:
        raise ValueError(f"its SPACE must be LPS or RAS, and of a mesh with points, got {space}")
    dataset.GetFieldData().RemoveArray(_FIELD)  # data in memory are LPS
    metadata.store(dataset, metadata.FILE_SPACE, [space])
    return _mirrored(dataset, space)


def back(dataset, writer):
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
    mirrored = mesh.NewInstance()
    mirrored.ShallowCopy(mesh)
    if (signs == 1).all():
        return mirrored
    if mesh.GetPoints() is not None:
        points = vtkPoints()
        points.SetData(_times(mesh.GetPoints().GetData(), signs))
        mirrored.SetPoints(points)
    for attributes in (mirrored.GetPointData(), mirrored.GetCellData()):
        roles = [attributes.GetVectors(), attributes.GetNormals()]
        roles += [attributes.GetArray(name) for name in (DISPLACEMENT, PATH)]
        for name in {array.GetName() for array in roles if array is not None}:
            components = attributes.GetArray(name).GetNumberOfComponents()
            if components == 3 or (name == PATH and components % 3 == 0):
                values = arrays.to_numpy(attributes.GetArray(name))
                factors = np.tile(signs, components // 3)
                arrays.replace(attributes, name, (values * factors).astype(values.dtype))
    return mirrored


def _times(array, signs):
    """Points (n, 3) times signs; unsigned integers become float64."""
    values = arrays.to_numpy(array)
    if values.dtype.kind == "u":
        return arrays.from_numpy(values * signs.astype(np.float64), VTK_DOUBLE)
    return arrays.from_numpy((values * signs).astype(values.dtype), array.GetDataType())
