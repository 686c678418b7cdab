"""Reading files and running filters, with what the terminal is to see of it."""

from __future__ import annotations

import sys

from vtk_mls.supervision import step

_BAR = 40  # characters


def read(reader, path):
    """What a reader of files makes of one."""
    with step("read", path):
        return reader(path)


def update(algorithm, options):
    """Run a filter on the file and the control points of the options.

    Raises
    ------
    ValueError
        What the filter complains of, with the names of the files.
    """
    with step("deform", options.input):
        try:
            _update(algorithm, options.progress or sys.stderr.isatty())
        except ValueError as error:  # the command has files, not inputs
            text = str(error).replace("`ControlPoints`", f"`{options.handles}`")
            text = text.replace("where the data are", f"where the data of `{options.input}` are")
            raise ValueError(text) from error


def _update(algorithm, shows_progress):
    """Run a filter; its error becomes an exception."""
    from vtkmodules.util.misc import calldata_type
    from vtkmodules.vtkCommonCore import VTK_STRING

    errors = []

    @calldata_type(VTK_STRING)
    def heard(caller, event, text):
        errors.append(text.partition(": ")[2])

    def moved(caller, event):
        done = round(_BAR * caller.GetProgress())
        bar = "#" * done + "." * (_BAR - done)
        print(f"\r[{bar}] {caller.GetProgress():4.0%}", end="", file=sys.stderr, flush=True)

    algorithm.AddObserver("ErrorEvent", heard)
    if shows_progress:
        algorithm.AddObserver("ProgressEvent", moved)
    updated = algorithm.GetExecutive().Update()
    if shows_progress:
        print(file=sys.stderr)
    if not updated:
        raise ValueError(errors[0] if errors else "the deformation failed")
