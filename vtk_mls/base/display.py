"""Whether there is a display to open windows on."""

import os
import sys

_NAMES = "DISPLAY", "WAYLAND_DISPLAY"


def check():
    """Raise OSError if there is none."""
    if sys.platform == "linux" and not any(map(os.environ.get, _NAMES)):
        raise missing()


def missing():
    """The error that says so, for those who find out otherwise."""
    return OSError(
        "there is no display to open a window on; set DISPLAY, or work where there is one"
        + " (over ssh: ssh -X)" * (sys.platform != "win32")
        + "; `vtk-mls view --web` needs none, but a browser"
    )
