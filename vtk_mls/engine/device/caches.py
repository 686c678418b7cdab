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
    for path in _usual_folders():
        if _can_be_written(path):
            return path
    path = Path(tempfile.gettempdir(), f"vtk_mls-{getattr(os, 'getuid', int)()}")
    if not (_can_be_written(path) and _is_own(path)):
        return None
    os.environ["XDG_CACHE_HOME"] = str(path)
    return path


def _usual_folders():
    if sys.platform == "win32":
        told = [os.environ.get("LOCALAPPDATA")]
        usual = "~/AppData/Local"
    else:
        told = [os.environ.get("XDG_CACHE_HOME")]
        usual = "~/Library/Caches" if sys.platform == "darwin" else "~/.cache"
    home = [usual] if os.path.expanduser("~") != "~" else []
    return [Path(os.path.expanduser(path)) for path in [*filter(None, told), *home][:1]]


def _can_be_written(path):
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            return True
    except OSError:
        return False


def _is_own(path):
    """Whether nobody else can have put files in a folder that all may make."""
    if not hasattr(os, "getuid"):
        return True
    status = path.lstat()
    return status.st_uid == os.getuid() and not status.st_mode & 0o022
