"""Props that replace ParaView's own in a view: their base, and those of meshes."""

from paraview.modules.vtkPVVTKExtensionsFiltersRendering import vtkPVGeometryFilter
from vtkmodules.vtkCommonDataModel import vtkDataSet, vtkImageData, vtkPolyData, vtkStructuredGrid
from vtkmodules.vtkFiltersCore import vtkStructuredGridOutlineFilter
from vtkmodules.vtkFiltersModeling import vtkOutlineFilter
from vtkmodules.vtkRenderingCore import vtkActor, vtkDataSetMapper, vtkPolyDataMapper, vtkProperty

from vtk_mls.paraview.displays import (
    BlockSettings,
    apply_colors,
    block_settings,
    color_array,
    color_settings,
)
from vtk_mls.paraview.server_manager import find_proxy, input_data, pending_value
from vtk_mls.rendering import DeformedMesh
from vtk_mls.rendering.deformed_mesh import MeshDeformer
from vtk_mls.rendering.rest_surface import DETERMINANT
from vtk_mls.vtk.objects import configured

SURFACES = ("Surface", "Surface With Edges", "Wireframe", "Points")
FEATURE_EDGES = "Feature Edges"
_PLACEMENT = ("Position", "Orientation", "Scale", "Origin", "UserMatrix")


class LiveProp:
    """A prop of our own with the properties of ParaView's, which is hidden.

    Subclasses have `_show(pending, is_dragging)`, and a constructor whose fourth parameter is the
    index of the data among the blocks of the display. `display` is a proxy of a representation that
    `can_draw` accepts, `mapper` that of the new prop.
    """

    draws_images = False  # otherwise meshes
    representations = ()
    prop_type = vtkActor
    has_failed = False  # whether the graphics card cannot draw it, which was reported

    def __init__(self, display, data, renderer, mapper):
        self._data, self._renderer, self._prop = data, renderer, self.prop_type()
        self._display_id, self._hidden = display.GetGlobalID(), paraview_prop(display)
        self._settings, self._latest = self.settings(display), None
        self._prop.SetMapper(mapper)
        self._prop.SetProperty(self._hidden.GetProperty())
        self._prop.PickableOff()
        renderer.AddViewProp(self._prop)

    @classmethod
    def can_draw(cls, display, data):
        """Whether this draws data as a display shows them."""
        return (
            isinstance(data, vtkDataSet)
            and isinstance(data, vtkImageData) == cls.draws_images
            and representation_of(display) in cls.representations
            and isinstance(paraview_prop(display), cls.prop_type)
        )

    @staticmethod
    def settings(display):
        """The settings of a display that need a new prop when they change."""
        return color_settings(display), representation_of(display)

    def is_current(self, display, data):
        """Whether this still draws data as a display shows them."""
        return (
            data is self._data
            and self.can_draw(display, data)
            and paraview_prop(display) is self._hidden
            and self.settings(display) == self._settings
        )

    def update(self, pending, is_dragging):
        """Draw the result of a PendingFilter, possibly coarser while the mouse drags a handle."""
        self._hidden.SetVisibility(False)
        for name in _PLACEMENT:
            getattr(self._prop, f"Set{name}")(getattr(self._hidden, f"Get{name}")())
        latest = pending.version, is_dragging, self._data.GetMTime()
        if self._latest != latest:
            self._latest = latest
            self._show(pending, is_dragging)
            self._renderer.ResetCameraClippingRange()

    def end(self):
        """Show ParaView's prop again."""
        self._renderer.RemoveViewProp(self._prop)
        display = find_proxy(self._display_id, "representations")
        if display and paraview_prop(display) is self._hidden:
            self._hidden.SetVisibility(display.GetProperty("Visibility").GetElement(0))


def paraview_prop(display):
    """ParaView's own actor or volume of a display; None if this process has none."""
    active = display.GetClientSideObject().GetActiveRepresentation()
    return active.GetActor() if hasattr(active, "GetActor") else None


def representation_of(display):
    """The representation of a display, such as "Surface"; None for displays without a choice."""
    return pending_value(display, "Representation")


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
        self._moved = configured(MeshDeformer(), InputDataObject=mesh)
        edges = feature_edges(self._moved)
        mapper = configured(vtkPolyDataMapper(), InputConnection=edges.GetOutputPort())
        apply_colors(mapper, display)
        super().__init__(display, mesh, renderer, mapper)

    _show = LiveOutline._show


def feature_edges(surface):
    """A filter for the feature edges of another filter's output, as ParaView draws them."""
    edges = configured(vtkPVGeometryFilter(), UseOutline=False, GenerateFeatureEdges=True)
    return configured(edges, InputConnection=surface.GetOutputPort())
