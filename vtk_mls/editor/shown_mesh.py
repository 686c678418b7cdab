"""A mesh that follows the handles, drawn by its look."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
from vtkmodules.vtkRenderingCore import vtkActor, vtkDataSetMapper, vtkPolyDataMapper

from vtk_mls.editor.mesh_surface import MeshSurface
from vtk_mls.rendering import DeformedMesh

_COLOUR = (0.86, 0.80, 0.70)


class ShownMesh:
    """A vtkDataSet that is no volume, deformed and drawn.

    Attributes
    ----------
    looks : list of str
        Its colour alone, and if it has numbers at points, colours by these.
    """

    def __init__(self, mesh, renderer):
        self._mesh = mesh
        scalars = mesh.GetPointData().GetScalars()
        self.looks = ["plain", *([f"by {scalars.GetName()}"] if scalars else [])]
        self._range = scalars.GetRange() if scalars else (0, 1)
        self._actor, self._mapper = vtkActor(), _mapper_of(mesh)
        self._actor.SetMapper(self._mapper)
        self.set_look(0)
        drawn_as = self._actor.GetProperty()
        drawn_as.SetColor(_COLOUR)
        drawn_as.SetInterpolationToPhong()
        drawn_as.SetAmbient(0.15)
        drawn_as.SetDiffuse(0.8)
        drawn_as.SetSpecular(0.2)
        drawn_as.SetSpecularPower(25)
        drawn_as.SetPointSize(3)
        renderer.AddActor(self._actor)
        self._drawn = DeformedMesh(self._actor)

    @property
    def bounds(self):
        """Corners (2, 3) of a box round it."""
        return np.reshape(self._mesh.GetBounds(), (3, 2)).T

    def set_look(self, number):
        """Draw it by one of the looks, whose name is returned."""
        number %= len(self.looks)
        self._mapper.SetScalarVisibility(number > 0)
        self._mapper.SetScalarModeToUsePointData()
        self._mapper.SetScalarRange(self._range)
        return self.looks[number]

    def show(self, deformation, nodes, is_final):
        """Draw it as a Deformation has it, or undeformed for None."""
        if deformation is None:
            self._drawn.detach()
        else:
            self._drawn.update(deformation, exact=is_final)

    def nearest(self, points):
        """What of it at rest is next to each of `points` (n, 3): (n, 3)."""
        return MeshSurface(self._mesh).nearest(points)

    def detach(self):
        """Leave the mesh as it is at rest."""
        self._drawn.detach()

    def set_coarseness(self, pixels):
        """Meshes are drawn for every pixel."""

    def colours_at(self, points):
        """None: in slices meshes are lines."""

    def mesh(self):
        """What is drawn of it now."""
        self._mapper.Update()
        return self._mapper.GetInput()

    def surface(self):
        """What is drawn of it now, as a `MeshSurface`."""
        return MeshSurface(self.mesh())


def _mapper_of(mesh):
    """A mapper; surfaces without normals get some, so that they look smooth."""
    if not isinstance(mesh, vtkPolyData):
        mapper = vtkDataSetMapper()
        mapper.SetInputData(mesh)
        return mapper
    mapper = vtkPolyDataMapper()
    if mesh.GetPointData().GetNormals() is not None or not mesh.GetNumberOfPolys():
        mapper.SetInputData(mesh)
        return mapper
    normals = vtkPolyDataNormals()
    normals.SetInputData(mesh)
    normals.SetFeatureAngle(60)
    normals.Update()
    mapper.SetInputConnection(normals.GetOutputPort())
    return mapper
