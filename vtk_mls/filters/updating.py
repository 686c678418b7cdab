"""Running a filter whose error becomes an exception, and whose warnings Python hears."""

from __future__ import annotations

from vtkmodules.util.misc import calldata_type
from vtkmodules.vtkCommonCore import VTK_STRING

from vtk_mls.base.messages import warn


def update(algorithm, progress=None):
    """Update a filter. Its warnings are announced: PyVista drops what VTK's output window gets.

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
    errors, warnings = [], []

    @calldata_type(VTK_STRING)
    def heard(caller, event, text):
        errors.append(text.partition(": ")[2])

    @calldata_type(VTK_STRING)
    def warned(caller, event, text):
        warnings.append(text.partition(": ")[2])

    tags = [
        algorithm.AddObserver("ErrorEvent", heard),
        algorithm.AddObserver("WarningEvent", warned),
    ]
    if progress:

        def moved(caller, event):
            progress(caller.GetProgress())

        tags.append(algorithm.AddObserver("ProgressEvent", moved))
    try:
        updated = algorithm.GetExecutive().Update()
    finally:
        for tag in tags:
            algorithm.RemoveObserver(tag)
    for sentence in warnings:
        warn(sentence)
    if errors or not updated:
        raise ValueError(errors[0] if errors else "the deformation failed")
