"""Base of the editor's widgets: callbacks and visibility of a VTK widget."""


class DragWidget:
    """A VTK widget that reports its value while the mouse drags it.

    A subclass defines `_has_value` and `_value`.
    """

    def __init__(self, interactor, renderer, widget, representation):
        self._interactor, self._renderer, self._widget = interactor, renderer, widget
        self._is_visible, self._is_dragged = True, False
        self._on_change = self._on_end = None
        widget.SetInteractor(interactor)
        widget.SetRepresentation(representation)
        widget.KeyPressActivationOff()
        widget.AddObserver("StartInteractionEvent", self._start)
        widget.AddObserver("InteractionEvent", self._move)
        widget.AddObserver("EndInteractionEvent", self._end)

    @property
    def _has_value(self):
        """Whether the widget has something to show."""
        raise NotImplementedError

    def _value(self):
        """The value at the position of the widget."""
        raise NotImplementedError

    def set_callbacks(self, on_change, on_end):
        """Call `on_change(value)` at each movement of the mouse, and `on_end()` after the last."""
        self._on_change, self._on_end = on_change, on_end

    def set_visible(self, is_visible):
        """Hide or show the widget."""
        self._is_visible = is_visible
        self._update()

    def finish(self):
        """Release the widget if the mouse drags it."""
        if self._is_dragged:
            # the widget receives mouse events until the button is released, even if disabled
            self._interactor.InvokeEvent("LeftButtonReleaseEvent")

    def detach(self):
        """Remove the widget from the view."""
        self.finish()
        self._widget.SetEnabled(False)
        self._widget.SetInteractor(None)

    def _start(self, widget, event):
        self._is_dragged = True

    def _move(self, widget, event):
        self._on_change(self._value())

    def _end(self, widget, event):
        self._is_dragged = False
        self._on_change(self._value())
        self._on_end()

    def _update(self):
        """Show or hide the widget; whether it is shown."""
        is_enabled = self._is_visible and self._has_value
        if is_enabled != bool(self._widget.GetEnabled()):
            # the widget forgets its renderer, and would take the one under the mouse
            self._widget.SetCurrentRenderer(self._renderer)
            self._widget.SetEnabled(is_enabled)
        return is_enabled
