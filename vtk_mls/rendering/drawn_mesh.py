"""What a mapper draws of a dataset: its surface, divided along cuts."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes, vtkPolyData
from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter

from vtk_mls.base.progress import SILENT
from vtk_mls.filters import gradients, warping
from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import is_empty, make_points_real, set_positions, without_empty
from vtk_mls.vtk.splitting import split

_POINT = "_Point"


class DrawnMesh:
    """The surface of a dataset at rest; each side of a cut can move on its own.

    Parameters
    ----------
    mesh : vtkDataSet
        It is not changed, and may be afterwards.
    cuts : sequence of Plane, HalfPlane and Surface

    Attributes
    ----------
    surface : vtkPolyData
    positions : (n, 3) array
        Of its points.
    """

    def __init__(self, mesh, cuts):
        arrays.check_lengths(mesh)
        foot = side = np.zeros((0, 3))
        if cuts and mesh.GetNumberOfCells() > 0:
            mesh, foot, side = split(mesh, cuts)
        self.surface = vtkPolyData()
        if isinstance(mesh, vtkPolyData):
            self.surface.ShallowCopy(mesh)
        else:
            rows = _extract_surface(mesh, self.surface)
            foot, side = (each[rows] if len(each) > 0 else each for each in (foot, side))
        arrays.name_normals(self.surface)
        points = self.surface.GetPoints()
        self.positions = np.empty((0, 3))
        if points is not None and points.GetNumberOfPoints() > 0:
            make_points_real(self.surface)
            self.positions = arrays.to_numpy(self.surface.GetPoints().GetData())
        self._on_cut = np.flatnonzero(side.any(axis=1))
        self._foot, self._side = foot[self._on_cut], side[self._on_cut]

    def material(self, deformation):
        """`positions`, those on a cut a little to the side on which their cells are."""
        if len(self._on_cut) == 0:
            return self.positions
        x, on_cut = self.positions.astype(np.float64), self._on_cut
        x[on_cut] += warping.offset_from_cuts(deformation, x[on_cut], self._foot, self._side)
        return x

    def moved(self, deformation):
        """The surface as vtkPolyData, moved by the exact forward map."""
        output, material = self._copy(), self.material(deformation)
        displacement = deformation.forward_field(material).displacement
        positions = self.positions + displacement
        set_positions(output, positions, self.surface.GetPoints().GetDataType())
        data = output.GetPointData(), output.GetCellData()
        of_points, of_cells = (gradients.DirectionArrays((), (), False).of(each) for each in data)
        if of_points:
            parts = jacobians(deformation, positions, self.positions, material)
            warping.transform(data[0], of_points, parts, unit=True)
        if of_cells:
            centres, before = (warping.centres(each) for each in (output, self.surface))
            parts = jacobians(deformation, centres, before, before)
            parts = warping.with_identity(parts, is_empty(output))
            warping.transform(data[1], of_cells, parts, unit=True)
        return output

    def with_points(self, points, normals):
        """The surface with other vtkPoints, and other normals of points or None.

        It has no normals of cells: mappers find them, but for meshes whose cells are drawn as if
        they were curved.
        """
        output = self._copy()
        output.SetPoints(points)
        if normals is not None:
            output.GetPointData().SetNormals(normals)
        if output.GetCellData().GetNormals() is not None:
            for data in (output.GetPointData(), output.GetCellData()):
                data.SetActiveAttribute(-1, vtkDataSetAttributes.NORMALS)
        return output

    def _copy(self):
        output = vtkPolyData()
        output.ShallowCopy(self.surface)
        return output


def jacobians(deformation, moved, before, material):
    """As `warping.jacobians`, for points (n, 3) that were `before` and whose material is known."""
    if deformation.in_rest_frame:
        return warping.jacobians(deformation, moved, material, SILENT)
    return warping.jacobians(deformation, moved + (material - before), None, SILENT)


def state_of(cuts):
    """What is equal for equal cuts."""
    return [
        (type(cut), *(np.asarray(getattr(cut, each.name)).tobytes() for each in fields(cut)))
        for cut in cuts
    ]


def _extract_surface(mesh, surface):
    """Fill `surface` with that of a dataset as mappers see it; the points of it that are there."""
    numbered = mesh.NewInstance()
    numbered.ShallowCopy(without_empty(mesh))
    arrays.add(numbered.GetPointData(), _POINT, np.arange(mesh.GetNumberOfPoints()))
    extract = vtkDataSetSurfaceFilter()
    extract.SetInputData(numbered)
    extract.Update()
    surface.ShallowCopy(extract.GetOutput())
    rows = surface.GetPointData().GetArray(_POINT)
    surface.GetPointData().RemoveArray(_POINT)
    return np.zeros(0, np.int64) if rows is None else arrays.to_numpy(rows)
