"""Announcements in ParaView's GUI: a line of Output Messages, which opens for it no window.

What goes to Python's standard error would be an error there.
"""

from __future__ import annotations

import logging
import sys

from vtkmodules.vtkCommonCore import vtkOutputWindow

from vtk_mls.base import messages


def start():
    """Tell announcements to whom looks at the GUI, or at the terminal that it was started from."""
    if not any(isinstance(each, _Told) for each in messages.LOG.handlers):
        messages.LOG.addHandler(_Told())
        messages.LOG.propagate = False


class _Told(logging.Handler):
    def emit(self, record):
        line = f"{self.format(record)}\n"
        vtkOutputWindow.GetInstance().DisplayText(line)
        if sys.__stderr__ is not None:  # sys.stderr is ParaView's
            sys.__stderr__.write(line)
            sys.__stderr__.flush()
