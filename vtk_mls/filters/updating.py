"""Running a filter whose error becomes an exception."""

from __future__ import annotations

from vtkmodules.util.misc import calldata_type
from vtkmodules.vtkCommonCore import VTK_STRING


def update(algorithm, progress=None):
    """Update a filter.

    Parameters
    ----------
    algorithm : vtkAlgorithm
    progress : callable, optional
        Called with the share that is done, from 0 to 1.

    Raises
    ------
    ValueError
        What the filter complains of, or the first of its blocks.
    """
    errors = []

    @calldata_type(VTK_STRING)
    def heard(caller, event, text):
        errors.append(text.partition(": ")[2])

    tags = [algorithm.AddObserver("ErrorEvent", heard)]
    if progress:

        def moved(caller, event):
            progress(caller.GetProgress())

        tags.append(algorithm.AddObserver("ProgressEvent", moved))
    try:
        updated = algorithm.GetExecutive().Update()
    finally:
        for tag in tags:
            algorithm.RemoveObserver(tag)
    if errors or not updated:
        raise ValueError(errors[0] if errors else "the deformation failed")
