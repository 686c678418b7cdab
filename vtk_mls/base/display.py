"""Check for a display for windows."""

import os
import sys

_VARIABLES = "DISPLAY", "WAYLAND_DISPLAY"


def check():
    """Raise OSError without a display."""
    if not is_present():
        raise missing()


def is_present():
    """Whether there may be a display."""
    return sys.platform != "linux" or any(map(os.environ.get, _VARIABLES))


def missing():
    """The OSError for a missing display."""
    return OSError(
        "there is no display to open a window on; set DISPLAY, or work where there is one"
        + " (over ssh: ssh -X)" * (sys.platform != "win32")
        + "; `vtk-mls view` without `--window` needs none, but a browser"
    )
