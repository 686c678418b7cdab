"""A mesh drawn deformed in place of ParaView's own prop."""

from paraview.modules.vtkPVVTKExtensionsFiltersRendering import vtkPVGeometryFilter
from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkStructuredGrid
from vtkmodules.vtkFiltersCore import vtkStructuredGridOutlineFilter
from vtkmodules.vtkFiltersModeling import vtkOutlineFilter
from vtkmodules.vtkRenderingCore import vtkDataSetMapper, vtkPolyDataMapper, vtkProperty

from vtk_mls.paraview.displays import BlockSettings, apply_colors, block_settings, color_array
from vtk_mls.paraview.live_prop import LiveProp
from vtk_mls.paraview.server_manager import input_data
from vtk_mls.rendering import DeformedMesh
from vtk_mls.rendering.deformed_mesh import MeshDeformer
from vtk_mls.rendering.rest_surface import DETERMINANT
from vtk_mls.vtk.objects import configured

SURFACES = ("Surface", "Surface With Edges", "Wireframe", "Points")
FEATURE_EDGES = "Feature Edges"


class LiveSurface(LiveProp):
    """A mesh as a surface, or its edges and points.

    ParaView's own actor cannot be deformed, since its mapper draws all blocks.
    """

    representations = SURFACES

    def __init__(self, display, mesh, renderer, index):
        mapper = vtkPolyDataMapper() if isinstance(mesh, vtkPolyData) else vtkDataSetMapper()
        mapper.SetInputDataObject(mesh)
        apply_colors(mapper, display)
        super().__init__(display, mesh, renderer, mapper)
        self._deformed = DeformedMesh(self._prop)
        self._has_distortion = color_array(display)[1] == DETERMINANT
        blocks = BlockSettings(display, input_data(display))
        color, opacity = blocks.color(index), blocks.opacities.get(index)
        if index in blocks.colors:
            mapper.ScalarVisibilityOff()
        if color or opacity is not None:
            prop = vtkProperty()
            prop.DeepCopy(self._hidden.GetProperty())
            prop.SetColor(color or prop.GetColor())
            prop.SetOpacity(prop.GetOpacity() if opacity is None else opacity)
            self._prop.SetProperty(prop)

    @staticmethod
    def settings(display):
        return LiveProp.settings(display), block_settings(display)

    def _show(self, pending, is_dragging):
        self._deformed.update(pending.deformation, not is_dragging, self._has_distortion)

    def end(self):
        self._deformed.detach()
        super().end()


class LiveOutline(LiveProp):
    """The outline of a mesh."""

    representations = ("Outline",)

    def __init__(self, display, mesh, renderer, index):
        mapper = configured(vtkPolyDataMapper(), ScalarVisibility=False)
        super().__init__(display, mesh, renderer, mapper)
        self._moved = MeshDeformer()
        is_curved = isinstance(mesh, vtkStructuredGrid)  # its outline follows the outer edges
        outline = vtkStructuredGridOutlineFilter() if is_curved else vtkOutlineFilter()
        first, second = (outline, self._moved) if is_curved else (self._moved, outline)
        first.SetInputDataObject(mesh)
        second.SetInputConnection(first.GetOutputPort())
        mapper.SetInputConnection(second.GetOutputPort())

    def _show(self, pending, is_dragging):
        self._moved.deform(pending.deformation, exact=not is_dragging)


class LiveEdges(LiveProp):
    """The feature edges of a mesh, which change with its shape."""

    representations = (FEATURE_EDGES,)

    def __init__(self, display, mesh, renderer, index):
        self._moved, mapper = MeshDeformer(), vtkPolyDataMapper()
        self._moved.SetInputDataObject(mesh)
        edges = feature_edges(self._moved)
        mapper.SetInputConnection(edges.GetOutputPort())
        apply_colors(mapper, display)
        super().__init__(display, mesh, renderer, mapper)

    _show = LiveOutline._show


def feature_edges(surface):
    """A filter for the feature edges of another filter's output, as ParaView draws them."""
    edges = configured(vtkPVGeometryFilter(), UseOutline=False, GenerateFeatureEdges=True)
    return configured(edges, InputConnection=surface.GetOutputPort())
