"""Observers with an owner.

VTK keeps an observer's Python function alive, but Python's garbage collector does not know of VTK.
If only an object of VTK leads to the function, the collector can empty the function while VTK still
calls it, and ParaView crashes. So every observer here belongs to a Python object that lives longer.
"""

from __future__ import annotations

from vtkmodules.vtkCommonCore import vtkWeakReference


class Observers:
    """Observers of VTK objects, which are removed together.

    The observed objects are not kept alive.
    """

    def __init__(self):
        self._observers = []

    def add(self, observed, event, callback, priority=0.0):
        """Call a function at each event of an object.

        Parameters
        ----------
        observed : vtkObject
        event : str
        callback : callable
            Called with the object and the event.
        priority : float, optional
            Observers of a higher priority are called first.

        Returns
        -------
        int
            VTK's tag of the observer.
        """
        reference = vtkWeakReference()
        reference.Set(observed)
        tag = observed.AddObserver(event, callback, priority)
        self._observers.append((reference, tag, callback))
        return tag

    def end(self):
        """Remove all of them."""
        observers, self._observers = self._observers, []
        for reference, tag, _ in observers:
            observed = reference.Get()
            if observed is not None:
                observed.RemoveObserver(tag)
