"""What stands in a view for something that ParaView shows."""

from __future__ import annotations

from vtk_mls.paraview.server_manager import find

_PLACEMENT = ("Position", "Orientation", "Scale", "Origin", "UserMatrix")


class LiveProp:
    """A prop of our own with the properties of ParaView's, which is hidden.

    Subclasses have `can_draw(display, data)` and `_show(pending, is_held)`. They are made of the
    first three parameters and the data's index among the blocks of the display.

    Parameters
    ----------
    display : proxy of a representation
        One that `can_draw` accepts.
    data : vtkDataSet
        To be drawn.
    renderer : vtkRenderer
    prop : vtkActor or vtkVolume
        What will be drawn.
    """

    has_failed = False  # whether the graphics card cannot draw it, which was said

    def __init__(self, display, data, renderer, prop):
        self._data, self._renderer, self._prop = data, renderer, prop
        self._display, self._hidden = display.GetGlobalID(), shown_prop(display)
        self._look, self._latest = self.look(display), None
        prop.SetProperty(self._hidden.GetProperty())
        prop.PickableOff()
        renderer.AddViewProp(prop)

    @staticmethod
    def look(display):
        """What of a display makes another prop necessary when it changes."""
        raise NotImplementedError

    def is_of(self, display, data):
        """Whether this still draws what the display shows."""
        return (
            data is self._data
            and self.can_draw(display, data)
            and shown_prop(display) is self._hidden
            and self.look(display) == self._look
        )

    def update(self, pending, is_held):
        """Draw the data as pending edits have them.

        Parameters
        ----------
        pending : PendingFilter
        is_held : bool
            Whether the mouse holds a handle: what is drawn may be coarser then.
        """
        self._hidden.SetVisibility(False)
        for name in _PLACEMENT:
            getattr(self._prop, f"Set{name}")(getattr(self._hidden, f"Get{name}")())
        latest = pending.edits, is_held, self._data.GetMTime()
        if self._latest != latest:
            self._latest = latest
            self._show(pending, is_held)
            self._renderer.ResetCameraClippingRange()

    def end(self):
        """Let what ParaView shows be seen again."""
        self._renderer.RemoveViewProp(self._prop)
        display = find(self._display, "representations")
        if display and shown_prop(display) is self._hidden:
            self._hidden.SetVisibility(display.GetProperty("Visibility").GetElement(0))


def shown_prop(display):
    """ParaView's own actor or volume of a display; None where it has none here."""
    active = display.GetClientSideObject().GetActiveRepresentation()
    return active.GetActor() if hasattr(active, "GetActor") else None


def shown_as(display):
    """What a display shows its data as: "Surface", "Volume" and so on; None if it does not say."""
    shows = display.GetProperty("Representation")
    return None if shows is None else shows.GetElement(0)
