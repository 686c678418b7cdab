"""Observers with an owner.

VTK keeps the Python function of an observer alive, but Python's garbage collector does not see
VTK's references. If only a VTK object holds the function, the collector may clear it while VTK
still calls it, and ParaView crashes. Therefore each observer has a Python object as its owner.
"""

from vtkmodules.vtkCommonCore import vtkWeakReference


class Observers:
    """Observers of VTK objects, removed together. They do not keep the objects alive."""

    def __init__(self):
        self._observers = []

    def add(self, observed, event, callback, priority=0.0):
        """Call `callback(observed, event)` at each event; returns VTK's tag of the observer."""
        reference = vtkWeakReference()
        reference.Set(observed)
        tag = observed.AddObserver(event, callback, priority)
        self._observers.append((reference, tag, callback))
        return tag

    def follow_widget(self, widget, enabled, disabled=None):
        """Call functions when a vtkAbstractWidget is enabled or disabled, and now if it is enabled.

        A representation has its renderer and its actors only while the widget is enabled.
        """
        self.add(widget, "EnableEvent", enabled)
        if disabled:
            self.add(widget, "DisableEvent", disabled)
        if widget.GetEnabled():
            enabled(widget, None)

    def end(self):
        """Remove all observers."""
        observers, self._observers = self._observers, []
        for reference, tag, _ in observers:
            observed = reference.Get()
            if observed is not None:
                observed.RemoveObserver(tag)
