"""Reading files and running filters, with what the terminal is to see of it."""

from __future__ import annotations

import sys

from vtk_mls.supervision import step

_BAR = 40  # characters


def read(reader, path):
    """What a reader of files makes of one."""
    with step("read", path):
        return reader(path)


def update(algorithm, options, done=0, total=1):
    """Run a filter on the file and the control points of the options.

    Parameters
    ----------
    algorithm : vtkAlgorithm
    options : argparse.Namespace
    done, total : int
        How often it has been run before, and will be in all: for the progress bar.

    Raises
    ------
    ValueError
        What the filter complains of, with the names of the files.
    """
    with step("deform", options.input):
        try:
            _update(algorithm, options.progress or sys.stderr.isatty(), done, total)
        except ValueError as error:  # the command has files, not inputs
            text = str(error).replace("`ControlPoints`", f"`{options.handles}`")
            text = text.replace("where the data are", f"where the data of `{options.input}` are")
            raise ValueError(text) from error


def _update(algorithm, shows_progress, done, total):
    """Run a filter; its error, or that of a block of its input, becomes an exception."""
    from vtkmodules.util.misc import calldata_type
    from vtkmodules.vtkCommonCore import VTK_STRING

    errors = []

    @calldata_type(VTK_STRING)
    def heard(caller, event, text):
        errors.append(text.partition(": ")[2])

    def moved(caller, event):
        fraction = (done + caller.GetProgress()) / total
        full = round(_BAR * fraction)
        bar = "#" * full + "." * (_BAR - full)
        print(f"\r[{bar}] {fraction:4.0%}", end="", file=sys.stderr, flush=True)

    tags = [algorithm.AddObserver("ErrorEvent", heard)]
    if shows_progress:
        tags.append(algorithm.AddObserver("ProgressEvent", moved))
    updated = algorithm.GetExecutive().Update()
    for tag in tags:
        algorithm.RemoveObserver(tag)
    if shows_progress and (done + 1 == total or errors or not updated):
        print(file=sys.stderr)
    if errors or not updated:
        raise ValueError(errors[0] if errors else "the deformation failed")
