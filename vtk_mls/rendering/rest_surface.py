"""The surface of a dataset at rest, split along cuts."""

from dataclasses import fields

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes, vtkPolyData
from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter

from vtk_mls.base.progress import SILENT
from vtk_mls.filters import derived_arrays, warping
from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import convert_integer_points, is_empty, set_positions, without_empty
from vtk_mls.vtk.objects import configured, output_of, shallow_copy
from vtk_mls.vtk.splitting import split

REST_POSITION, DETERMINANT = "RestPosition", "JacobianDeterminant"  # names of arrays
_POINT = "_Point"  # name of an array of point ids


class RestSurface:
    """The surface of a dataset at rest, split along cuts so that their sides move separately.

    `surface` is a vtkPolyData, and `positions` (n, 3) are its points.
    """

    def __init__(self, mesh, cuts):
        arrays.check_lengths(mesh)
        closest = side = np.zeros((0, 3))
        if cuts and mesh.GetNumberOfCells() > 0:
            mesh, closest, side = split(mesh, cuts)
        if isinstance(mesh, vtkPolyData):
            self.surface = shallow_copy(mesh)
        else:
            self.surface, rows = _surface_of(mesh)
            closest, side = (array[rows] if len(array) else array for array in (closest, side))
        arrays.name_normals(self.surface)
        self.positions = np.empty((0, 3))
        if self.surface.GetNumberOfPoints() > 0:
            convert_integer_points(self.surface)
            self.positions = arrays.to_numpy(self.surface.GetPoints().GetData())
        self._on_cut = np.flatnonzero(side.any(axis=1))
        self._closest, self._side = closest[self._on_cut], side[self._on_cut]

    def material(self, deformation):
        """`positions`, with points on a cut moved slightly to the side of their cells."""
        if len(self._on_cut) == 0:
            return self.positions
        x, on_cut = self.positions.astype(np.float64), self._on_cut
        x[on_cut] += warping.offset_from_cuts(deformation, x[on_cut], self._closest, self._side)
        return x

    def moved(self, deformation, has_distortion=False):
        """The surface as vtkPolyData, deformed by the exact forward map.

        With `has_distortion` it has the point arrays of `add_distortion`.
        """
        output, material = shallow_copy(self.surface), self.material(deformation)
        field = deformation.forward_field(material)
        positions = self.positions + field.displacement
        set_positions(output, positions, self.surface.GetPoints().GetDataType())
        data = output.GetPointData(), output.GetCellData()
        normals = derived_arrays.DirectionArrays((), (), False)
        point_arrays, cell_arrays = (normals.of(attributes) for attributes in data)
        if point_arrays:
            parts = jacobians(deformation, positions, self.positions, material)
            warping.transform(data[0], point_arrays, parts, unit=True)
        if cell_arrays:
            moved, rest = (warping.cell_centers(surface) for surface in (output, self.surface))
            parts = jacobians(deformation, moved, rest, rest)
            parts = warping.with_identity(parts, is_empty(output))
            warping.transform(data[1], cell_arrays, parts, unit=True)
        if has_distortion:
            parts = jacobians(deformation, positions, self.positions, material)
            self.add_distortion(output, determinants(parts, field.found))
        return output

    def add_distortion(self, output, values):
        """Add the point arrays "RestPosition" and "JacobianDeterminant", `values` (n,)."""
        arrays.add(output.GetPointData(), REST_POSITION, self.positions.astype(np.float32))
        arrays.add(output.GetPointData(), DETERMINANT, values)

    def with_points(self, points, normals):
        """The surface with other vtkPoints, and other point normals or None.

        Cell normals are removed: mappers compute them.
        """
        output = configured(shallow_copy(self.surface), Points=points)
        if normals is not None:
            output.GetPointData().SetNormals(normals)
        if output.GetCellData().GetNormals() is not None:
            for data in (output.GetPointData(), output.GetCellData()):
                data.SetActiveAttribute(-1, vtkDataSetAttributes.NORMALS)
        return output


def jacobians(deformation, moved, before, material):
    """`warping.jacobians` at moved points (n, 3), from rest positions `before` and `material`."""
    if deformation.in_rest_frame:
        return warping.jacobians(deformation, moved, material, SILENT)
    return warping.jacobians(deformation, moved + (material - before), None, SILENT)


def determinants(parts, found):
    """det J_G (n,) float32 from parts of `jacobians`; not above 0 where F has no value."""
    values = np.empty(len(found), np.float32)
    for part, jacobian in parts:
        values[part] = np.linalg.det(jacobian)
    return np.where(found, values, np.minimum(values, 0))


def state_of(cuts):
    """A value that is equal for equal cuts."""
    return [
        (type(cut), *(np.asarray(getattr(cut, field.name)).tobytes() for field in fields(cut)))
        for cut in cuts
    ]


def _surface_of(mesh):
    """The surface of a dataset, as mappers extract it, and its point ids (n,)."""
    copy = shallow_copy(without_empty(mesh))
    arrays.add(copy.GetPointData(), _POINT, np.arange(mesh.GetNumberOfPoints()))
    surface = shallow_copy(output_of(vtkDataSetSurfaceFilter(), InputData=copy))
    rows = surface.GetPointData().GetArray(_POINT)
    surface.GetPointData().RemoveArray(_POINT)
    return surface, np.zeros(0, np.int64) if rows is None else arrays.to_numpy(rows)
