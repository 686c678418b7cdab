"""A mesh in the scene."""

from functools import cached_property

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkRenderingCore import vtkActor, vtkDataSetMapper, vtkPolyDataMapper

from vtk_mls import Deformation, Solid
from vtk_mls.rendering import DeformedMesh, rest_lines, volume_colors
from vtk_mls.rendering.rest_surface import DETERMINANT
from vtk_mls.rendering.surfaces import SurfaceLocator
from vtk_mls.vtk.objects import configured
from vtk_mls.vtk.shape_surfaces import triangles_of

_COLOR = (0.86, 0.80, 0.70)
OUTLINE_COLOR = (0.95, 0.80, 0.55)
_SEE_THROUGH = 0.4  # opacity


class SceneMesh:
    """A deformed mesh in the `Scene`, with its actor.

    `preset_names` are one color, colors by the active point scalars if there are any, and one color
    that other objects are seen through; `outline_color` (0 to 1) is that in slices.
    """

    def __init__(self, mesh, renderer):
        self._mesh, self.outline_color = mesh, OUTLINE_COLOR
        scalars = mesh.GetPointData().GetScalars()
        colored = [f"by {scalars.GetName()}"] if scalars else []
        self.preset_names = ["plain", *colored, "see-through"]
        self._range = scalars.GetRange() if scalars else (0, 1)
        self._mapper = _mapper_of(mesh)
        self.prop = self._actor = configured(vtkActor(), Mapper=self._mapper)
        self._has_volume_colors, self._lines = False, None
        self.set_preset(0)
        material = configured(self._actor.GetProperty(), Color=_COLOR, PointSize=3)
        configured(material, Ambient=0.15, Diffuse=0.8, Specular=0.2, SpecularPower=25)
        material.SetInterpolationToPhong()
        renderer.AddActor(self._actor)
        self._deformed = DeformedMesh(self._actor)

    @property
    def bounds(self):
        """Corners (2, 3) of a box around the undeformed mesh."""
        return np.reshape(self._mesh.GetBounds(), (3, 2)).T

    def set_preset(self, index):
        """Color the mesh; the name of the preset."""
        self._preset = index % len(self.preset_names)
        self._color()
        name = self.preset_names[self._preset]
        self._actor.GetProperty().SetOpacity(_SEE_THROUGH if name == "see-through" else 1)
        return name

    def adjust(self, brightness, contrast):
        """Nothing changes: slices show outlines."""

    def set_coarseness(self, pixels, has_offset=False):
        """Nothing changes: no rays are cast for meshes."""

    def show(self, deformation, nodes, distortion, is_final):
        """Deform the mesh; None for the identity."""
        self._has_volume_colors = distortion.has_colors
        if deformation is None and distortion.mode:
            corner = self.bounds[:1]
            deformation = Deformation(corner, corner)
        if deformation is None:
            self._deformed.detach()
        else:
            self._deformed.update(deformation, is_final, distortion.mode > 0)
        self._color()
        self._draw_lines(distortion.lines if distortion.has_grid else None)

    def nearest(self, points):
        """The points of the undeformed mesh nearest to `points` (n, 3): (n, 3)."""
        return SurfaceLocator(self._mesh).nearest(points)

    def colors_at(self, points):
        """None: slices show meshes as lines."""

    def mesh(self):
        """The deformed mesh as it is drawn now."""
        self._mapper.Update()
        return self._mapper.GetInput()

    def plain_mapper(self):
        """A new mapper of the undeformed mesh in one color."""
        mapper = _mapper_of(self._mesh)
        mapper.ScalarVisibilityOff()
        return mapper

    def surface(self):
        """The `SurfaceLocator` of the deformed mesh."""
        return SurfaceLocator(self.mesh())

    def rigid_hit(self, near, far):
        """Fraction of a ray at the mesh, and a function that returns its Shape; or None."""
        hit = self.surface().hit(near, far)
        return hit and (hit[0], lambda: self._solid)

    def _color(self):
        mapper = self._mapper
        is_colored = self.preset_names[self._preset].startswith("by ")
        mapper.SetScalarVisibility(is_colored or self._has_volume_colors)
        mapper.SetInterpolateScalarsBeforeMapping(self._has_volume_colors)
        if self._has_volume_colors:
            table = volume_colors.lookup_table()
            mapper.SetLookupTable(table)
            mapper.SetScalarModeToUsePointFieldData()
            mapper.SelectColorArray(DETERMINANT)
            mapper.SetScalarRange(table.GetTableRange())
        else:
            mapper.SetLookupTable(None)
            mapper.SetScalarModeToUsePointData()
            mapper.SetScalarRange(self._range)

    def _draw_lines(self, lines):
        mapper = self._mapper
        if not isinstance(mapper, vtkPolyDataMapper):
            mapper = mapper.GetPolyDataMapper()  # None before the first picture
        if lines is not self._lines and mapper is not None:
            rest_lines.show(self._actor, mapper, lines)
            self._lines = lines

    @cached_property
    def _solid(self):
        """The undeformed mesh as a Solid; ValueError if it is not closed."""
        return Solid(*triangles_of(configured(vtkGeometryFilter(), InputData=self._mesh)))

    def detach(self):
        """Leave the mesh undeformed."""
        self._has_volume_colors = False
        self._color()
        self._draw_lines(None)
        self._deformed.detach()


def _mapper_of(mesh):
    """A mapper; surfaces without normals get smooth ones."""
    if not isinstance(mesh, vtkPolyData):
        return configured(vtkDataSetMapper(), InputData=mesh)
    if mesh.GetPointData().GetNormals() is not None or not mesh.GetNumberOfPolys():
        return configured(vtkPolyDataMapper(), InputData=mesh)
    normals = configured(vtkPolyDataNormals(), InputData=mesh, FeatureAngle=60)
    normals.Update()
    return configured(vtkPolyDataMapper(), InputConnection=normals.GetOutputPort())
