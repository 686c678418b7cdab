"""Opens the page in a browser of this machine."""

import os
import shutil
import subprocess
import sys
import webbrowser
from contextlib import suppress

from vtk_mls.base import display

# Browsers with windows for one page, without tabs and address: names of commands, and paths.
_COMMANDS = ["google-chrome", "chromium", "chromium-browser", "microsoft-edge", "chrome", "msedge"]
_PATHS = {
    "darwin": (
        "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
        "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    ),
    "win32": (
        r"%ProgramFiles%\Google\Chrome\Application\chrome.exe",
        r"%ProgramFiles(x86)%\Microsoft\Edge\Application\msedge.exe",
    ),
}
_START_SECONDS = 3  # in which a browser that cannot start ends


def open_page(address):
    """Open an address in a window of its own, or in the default browser; not without a display."""
    if not display.is_present() or _opens_window(address):
        return
    with suppress(webbrowser.Error):
        webbrowser.open(address)


def _opens_window(address):
    paths = [*map(shutil.which, _COMMANDS), *map(os.path.expandvars, _PATHS.get(sys.platform, ()))]
    browser = next((path for path in paths if path and os.path.exists(path)), None)
    if browser is None:
        return False
    output = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with suppress(OSError):
        process = subprocess.Popen([browser, f"--app={address}"], start_new_session=True, **output)
        try:
            return process.wait(_START_SECONDS) == 0  # it goes on in a browser that is open already
        except subprocess.TimeoutExpired:
            return True
    return False
