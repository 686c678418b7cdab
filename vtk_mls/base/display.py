"""Check for a display for windows."""

import os
import sys

_VARIABLES = "DISPLAY", "WAYLAND_DISPLAY"


def check():
    """Raise OSError without a display."""
    if sys.platform == "linux" and not any(map(os.environ.get, _VARIABLES)):
        raise missing()


def missing():
    """The OSError for a missing display."""
    return OSError(
        "there is no display to open a window on; set DISPLAY, or work where there is one"
        + " (over ssh: ssh -X)" * (sys.platform != "win32")
        + "; `vtk-mls view --web` needs none, but a browser"
    )
