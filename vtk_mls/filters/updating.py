"""Updates of filters that raise their errors and log their warnings."""

from __future__ import annotations

import re

from vtkmodules.util.misc import calldata_type
from vtkmodules.vtkCommonCore import VTK_STRING

from vtk_mls.base.messages import warn


def update(algorithm, progress=None, names=None):
    """Update a filter; its warnings go to `base.messages`, as PyVista hides VTK's output window.

    Parameters
    ----------
    algorithm : vtkAlgorithm
    progress : callable, optional
        Called with the completed fraction, from 0 to 1.
    names : dict, optional
        Replacements, by argument, for the names in backticks in errors.

    Raises
    ------
    ValueError
        The first error of the filter or of its blocks.
    """
    errors, warnings = [], []

    @calldata_type(VTK_STRING)
    def add_error(caller, event, text):
        errors.append(text.partition(": ")[2])

    @calldata_type(VTK_STRING)
    def add_warning(caller, event, text):
        warnings.append(text.partition(": ")[2])

    tags = [
        algorithm.AddObserver("ErrorEvent", add_error),
        algorithm.AddObserver("WarningEvent", add_warning),
    ]
    if progress:

        def report(caller, event):
            progress(caller.GetProgress())

        tags.append(algorithm.AddObserver("ProgressEvent", report))
    try:
        is_updated = algorithm.GetExecutive().Update()
    finally:
        for tag in tags:
            algorithm.RemoveObserver(tag)
    for sentence in warnings:
        warn(sentence)
    if errors or not is_updated:
        sentence = errors[0] if errors else "the deformation failed"
        names = names or {}
        raise ValueError(re.sub("`(\\w+)`", lambda match: names.get(match[1], match[0]), sentence))
