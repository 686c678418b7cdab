"""Single meshes as files, in the frame that a file says (see `mesh_frames`)."""

from __future__ import annotations

from vtkmodules.vtkFiltersCore import vtkTriangleFilter
from vtkmodules.vtkIOGeometry import vtkSTLWriter
from vtkmodules.vtkIOPLY import vtkPLYWriter

from vtk_mls.files import mesh_frames, vtk_io


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
    """Write the points and polygons of polydata, which must have no lines."""
    _check_has_no(polydata, path, "Lines")
    if polydata.GetNumberOfStrips():
        triangles = vtkTriangleFilter()
        triangles.SetInputData(polydata)
        triangles.Update()
        polydata = triangles.GetOutput()
    corners = polydata.GetPolys().GetMaxCellSize()
    if corners > 255:
        raise ValueError(f"`{path}` cannot hold a face of {corners} corners; write .vtp instead")
    _write(vtkPLYWriter(), polydata, path)
    vtk_io.check_size(path, _size_of_ply(polydata, path))


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
    of_vertex = 4 * header.count(b"property float") + header.count(b"property uchar")
    faces = polydata.GetPolys()
    size = len(header + b"end_header\n") + of_vertex * polydata.GetNumberOfPoints()
    return size + faces.GetNumberOfCells() + 4 * faces.GetNumberOfConnectivityIds()
