"""The frame of a mesh file, as 3D Slicer writes it: `SPACE=RAS` or `SPACE=LPS`.

It stands in the title of .vtk, the header of .stl, a comment of .ply and .obj, and in VTK's XML
files in a field array "SPACE". Such meshes are taken to LPS when they are read, with their active
vectors and normals and the displacements of control points, and back when they are written. Others
are taken as they are, as Slicer takes them too.
"""

from __future__ import annotations

import re

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPointSet

from vtk_mls.files import frames, provenance, vtk_io
from vtk_mls.vtk import arrays

_FIELD = "SPACE"
_DISPLACEMENT = "Displacement"


def read(reader, path):
    """A mesh by a reader of VTK's, in LPS.

    Raises
    ------
    ValueError
        If its space is not known.
    """
    dataset = vtk_io.read(reader, path)
    space = _space_of(reader, dataset)
    if not space or dataset is None:
        return dataset
    if not isinstance(dataset, vtkPointSet) or frames.signs(space).prod() < 0:
        raise ValueError(f"its SPACE must be LPS or RAS, and of a mesh with points, got {space}")
    dataset.GetFieldData().RemoveArray(_FIELD)  # what is in memory is LPS
    provenance.keep(dataset, provenance.FILE_SPACE, [space])
    return _mirrored(dataset, space)


def back(dataset, writer):
    """A mesh in the frame of the file that it came from; its writer is told to say which."""
    space = _known("".join(provenance.kept(dataset, provenance.FILE_SPACE)[:1]))
    if not space or not isinstance(dataset, vtkPointSet):
        return dataset
    mesh, text = _mirrored(dataset, space), f"{_FIELD}={space}"
    if hasattr(writer, "AddComment"):  # .ply
        writer.AddComment(text)
    elif hasattr(writer, "SetHeader"):  # .vtk and .stl
        writer.SetHeader(f"vtk_mls {text}")
    else:
        provenance.keep(mesh, _FIELD, [space])
    return mesh


def _space_of(reader, dataset):
    """The anatomical frame that a file names, or ""."""
    texts = []
    if dataset is not None:
        texts += [f"{_FIELD}={text}" for text in provenance.kept(dataset, _FIELD)[:1]]
    for name in ("GetHeader", "GetComment", "GetComments"):
        found = getattr(reader, name, lambda: None)()
        if hasattr(found, "GetNumberOfValues"):
            texts += [found.GetValue(i) for i in range(found.GetNumberOfValues())]
        else:
            texts.append(found or "")
    texts = [text if isinstance(text, str) else text.decode("latin-1") for text in texts]
    found = re.search(rf"\b{_FIELD}=(\w+)", "\n".join(texts))
    return _known(found[1]) if found else ""


def _known(space):
    """An anatomical frame in capitals, or "" for other words, which Slicer ignores too."""
    try:
        frames.signs(space)
    except ValueError:
        return ""
    return space.upper()


def _mirrored(mesh, space):
    """A mesh between LPS and another frame."""
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
        roles = attributes.GetVectors(), attributes.GetNormals(), attributes.GetArray(_DISPLACEMENT)
        for name in {each.GetName() for each in roles if each is not None}:
            if attributes.GetArray(name).GetNumberOfComponents() == 3:
                values = arrays.to_numpy(attributes.GetArray(name))
                arrays.replace(attributes, name, (values * signs).astype(values.dtype))
    return mirrored


def _times(array, signs):
    """Points (n, 3) times signs; unsigned ones have no opposite, and become float64."""
    values = arrays.to_numpy(array)
    if values.dtype.kind == "u":
        return arrays.from_numpy(values * signs.astype(np.float64), VTK_DOUBLE)
    return arrays.from_numpy((values * signs).astype(values.dtype), array.GetDataType())
