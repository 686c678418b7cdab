"""A prop that replaces ParaView's own in a view."""

from vtkmodules.vtkCommonDataModel import vtkDataSet, vtkImageData
from vtkmodules.vtkRenderingCore import vtkActor

from vtk_mls.paraview.displays import color_settings
from vtk_mls.paraview.server_manager import find_proxy, pending_value

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
