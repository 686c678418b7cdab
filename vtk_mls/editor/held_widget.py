"""What the editor's VTK widgets have in common: callbacks, visibility, and their end."""

from __future__ import annotations


class HeldWidget:
    """A VTK widget that reports its value while the mouse holds it.

    A subclass sets `_is_shown` and `_value`.

    Parameters
    ----------
    interactor : vtkRenderWindowInteractor
    renderer : vtkRenderer
    widget : vtkAbstractWidget
    representation : vtkWidgetRepresentation
    """

    def __init__(self, interactor, renderer, widget, representation):
        self._interactor, self._renderer, self._widget = interactor, renderer, widget
        self._is_visible, self._is_held = True, False
        self._moved = self._released = None
        widget.SetInteractor(interactor)
        widget.SetRepresentation(representation)
        widget.KeyPressActivationOff()
        widget.AddObserver("StartInteractionEvent", self._on_start)
        widget.AddObserver("InteractionEvent", self._on_move)
        widget.AddObserver("EndInteractionEvent", self._on_end)

    @property
    def _is_shown(self):
        """Whether there is something to show."""
        raise NotImplementedError

    def _value(self):
        """What the widget has been moved to."""
        raise NotImplementedError

    def set_callbacks(self, moved, released):
        """Call `moved(value)` at each movement of the mouse, and `released(value)` at its end."""
        self._moved, self._released = moved, released

    def set_visible(self, is_visible):
        """Hide or show the widget."""
        self._is_visible = is_visible
        self._update()

    def finish(self):
        """Release the widget if the mouse holds it."""
        if self._is_held:
            # the widget receives mouse events until the button is released, even if disabled
            self._interactor.InvokeEvent("LeftButtonReleaseEvent")

    def detach(self):
        """Remove the widget from the view."""
        self.finish()
        self._widget.SetEnabled(False)
        self._widget.SetInteractor(None)

    def _on_start(self, widget, event):
        self._is_held = True

    def _on_move(self, widget, event):
        self._moved(self._value())

    def _on_end(self, widget, event):
        self._is_held = False
        self._released(self._value())

    def _update(self):
        """Show or hide the widget; whether it is shown."""
        is_enabled = self._is_visible and self._is_shown
        if is_enabled != bool(self._widget.GetEnabled()):
            # the widget forgets its renderer, and would take the one under the mouse
            self._widget.SetCurrentRenderer(self._renderer)
            self._widget.SetEnabled(is_enabled)
        return is_enabled
