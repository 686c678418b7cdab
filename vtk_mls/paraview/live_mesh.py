"""A mesh that ParaView shows, drawn deformed in its stead."""

from __future__ import annotations

from paraview.modules.vtkPVVTKExtensionsFiltersRendering import vtkPVGeometryFilter
from vtkmodules.vtkCommonDataModel import vtkDataSet, vtkImageData, vtkPolyData, vtkStructuredGrid
from vtkmodules.vtkFiltersCore import vtkStructuredGridOutlineFilter
from vtkmodules.vtkFiltersModeling import vtkOutlineFilter
from vtkmodules.vtkRenderingCore import vtkActor, vtkDataSetMapper, vtkPolyDataMapper, vtkProperty

from vtk_mls.paraview import block_look, colors
from vtk_mls.paraview.block_look import BlockLook
from vtk_mls.paraview.live_prop import LiveProp, shown_as, shown_prop
from vtk_mls.paraview.server_manager import input_of
from vtk_mls.rendering import DeformedMesh
from vtk_mls.rendering.deformed_mesh import MeshDeformer

SURFACES = ("Surface", "Surface With Edges", "Wireframe", "Points")
EDGES = "Feature Edges"


class LiveMesh(LiveProp):
    """A mesh as a surface, or its edges and points.

    ParaView's own actor cannot be drawn deformed: its mapper is for many blocks. `index` is that of
    the mesh among these.
    """

    def __init__(self, display, mesh, renderer, index=0):
        mapper = vtkPolyDataMapper() if isinstance(mesh, vtkPolyData) else vtkDataSetMapper()
        mapper.SetInputDataObject(mesh)
        colors.apply(mapper, display)
        blocks = BlockLook(display, input_of(display))
        color, opacity = blocks.colors.get(index), blocks.opacities.get(index)
        if color:
            mapper.ScalarVisibilityOff()
        actor = vtkActor()
        actor.SetMapper(mapper)
        super().__init__(display, mesh, renderer, actor)
        self._drawn = DeformedMesh(actor)
        color = color or colors.of_block(display, index)
        if color or opacity is not None:
            looks = vtkProperty()
            looks.DeepCopy(self._hidden.GetProperty())
            looks.SetColor(color or looks.GetColor())
            looks.SetOpacity(looks.GetOpacity() if opacity is None else opacity)
            actor.SetProperty(looks)

    @staticmethod
    def can_draw(display, mesh):
        """Whether a display shows the mesh so."""
        return is_mesh(mesh) and shown_as(display) in SURFACES and has_actor(display)

    @staticmethod
    def look(display):
        return colors.look(display), shown_as(display), block_look.settings(display)

    def _show(self, pending, is_held):
        self._drawn.update(pending.deformation, exact=not is_held)

    def end(self):
        """Let ParaView's actor be seen again."""
        self._drawn.detach()
        super().end()


class LiveOutline(LiveProp):
    """The outline of a mesh."""

    def __init__(self, display, mesh, renderer, index=0):
        mapper = vtkPolyDataMapper()
        mapper.ScalarVisibilityOff()
        actor = vtkActor()
        actor.SetMapper(mapper)
        super().__init__(display, mesh, renderer, actor)
        self._moved = MeshDeformer()
        is_bent = isinstance(mesh, vtkStructuredGrid)  # as its edges are
        outline = vtkStructuredGridOutlineFilter() if is_bent else vtkOutlineFilter()
        first, then = (outline, self._moved) if is_bent else (self._moved, outline)
        first.SetInputDataObject(mesh)
        then.SetInputConnection(first.GetOutputPort())
        mapper.SetInputConnection(then.GetOutputPort())

    @staticmethod
    def can_draw(display, mesh):
        """Whether a display shows the mesh so."""
        return is_mesh(mesh) and shown_as(display) == "Outline" and has_actor(display)

    @staticmethod
    def look(display):
        return shown_as(display)

    def _show(self, pending, is_held):
        self._moved.deform(pending.deformation, exact=not is_held)


class LiveEdges(LiveProp):
    """The feature edges of a mesh: they are others when it is bent."""

    def __init__(self, display, mesh, renderer, index=0):
        self._moved, mapper, actor = MeshDeformer(), vtkPolyDataMapper(), vtkActor()
        self._moved.SetInputDataObject(mesh)
        edges = edges_of(self._moved)
        mapper.SetInputConnection(edges.GetOutputPort())
        colors.apply(mapper, display)
        actor.SetMapper(mapper)
        super().__init__(display, mesh, renderer, actor)

    @staticmethod
    def can_draw(display, mesh):
        """Whether a display shows the mesh so."""
        return is_mesh(mesh) and shown_as(display) == EDGES and has_actor(display)

    @staticmethod
    def look(display):
        return colors.look(display), shown_as(display)

    def _show(self, pending, is_held):
        self._moved.deform(pending.deformation, exact=not is_held)


def edges_of(surface):
    """The filter for the feature edges of what another makes, as ParaView has them."""
    edges = vtkPVGeometryFilter()
    edges.SetUseOutline(False)
    edges.SetGenerateFeatureEdges(True)
    edges.SetInputConnection(surface.GetOutputPort())
    return edges


def is_mesh(data):
    """Whether what something becomes is a mesh."""
    return isinstance(data, vtkDataSet) and not isinstance(data, vtkImageData)


def has_actor(display):
    """Whether ParaView draws a display by an actor here."""
    return isinstance(shown_prop(display), vtkActor)
