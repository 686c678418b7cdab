"""A folder for caches that can be written, also for pyopencl and drivers that insist on theirs."""

from __future__ import annotations

import functools
import os
import sys
import tempfile
from pathlib import Path


@functools.cache
def folder() -> Path | None:
    """The user's folder for caches, else one of their own among the temporary files; None without.

    If it is the latter, `XDG_CACHE_HOME` says so from then on: pyopencl's caches and PoCL's follow
    it, and neither works where it cannot write.
    """
    for place in _usual_places():
        if _can_be_written(place):
            return place
    place = Path(tempfile.gettempdir(), f"vtk_mls-{getattr(os, 'getuid', int)()}")
    if not (_can_be_written(place) and _is_own(place)):
        return None
    os.environ["XDG_CACHE_HOME"] = str(place)
    return place


def _usual_places():
    if sys.platform == "win32":
        told = [os.environ.get("LOCALAPPDATA")]
        usual = "~/AppData/Local"
    else:
        told = [os.environ.get("XDG_CACHE_HOME")]
        usual = "~/Library/Caches" if sys.platform == "darwin" else "~/.cache"
    home = [usual] if os.path.expanduser("~") != "~" else []
    return [Path(os.path.expanduser(place)) for place in [*filter(None, told), *home][:1]]


def _can_be_written(place):
    try:
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=place):
            return True
    except OSError:
        return False


def _is_own(place):
    """Whether nobody else can have put files in a folder that all may make."""
    if not hasattr(os, "getuid"):
        return True
    status = place.lstat()
    return status.st_uid == os.getuid() and not status.st_mode & 0o022
