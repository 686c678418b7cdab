"""Updates of filters that raise their errors and log their warnings."""

import re

from vtkmodules.util.misc import calldata_type
from vtkmodules.vtkCommonCore import VTK_STRING

from vtk_mls.base.messages import warn
from vtk_mls.base.progress import Aborted


def update(algorithm, progress=None, names=None):
    """Update a filter; its warnings go to `base.messages`, as PyVista hides VTK's output window.

    `progress` is called with the completed fraction, from 0 to 1; a true return value stops with
    `Aborted`. ValueError is the first error of the filter or of its blocks, with the fields of an
    `InputError`; `names` are replacements, by argument, for the names in backticks.
    """
    errors, warnings, is_stopped = [], [], False
    sentences = {"ErrorEvent": errors, "WarningEvent": warnings}

    @calldata_type(VTK_STRING)
    def hear(caller, event, text):
        sentences[event].append(text.partition(": ")[2])

    tags = [algorithm.AddObserver(event, hear) for event in sentences]
    if progress:

        def report(caller, event):
            nonlocal is_stopped
            if progress(caller.GetProgress()):
                is_stopped = True
                caller.AbortExecuteOn()

        tags.append(algorithm.AddObserver("ProgressEvent", report))
    try:
        is_updated = algorithm.GetExecutive().Update()
    finally:
        for tag in tags:
            algorithm.RemoveObserver(tag)
        algorithm.AbortExecuteOff()
    if is_stopped:
        raise Aborted("stopped as `progress` asked")
    for sentence in warnings:
        warn(sentence)
    if errors or not is_updated:
        sentence = errors[0] if errors else "the deformation failed"
        error = getattr(algorithm, "last_error", None)
        if not names and str(error) == sentence:
            raise error
        names = names or {}
        raise ValueError(re.sub("`(\\w+)`", lambda match: names.get(match[1], match[0]), sentence))
