"""A writable cache folder, also for pyopencl and for drivers that require one."""

import hashlib
import os
import platform
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

from vtk_mls.base import lazy

_OLDEST_LOCK = 5  # seconds; pyopencl holds its lock for milliseconds


@lazy.cached
def folder():
    """The user's cache folder, else a private temporary folder; None if neither is writable.

    The temporary folder is also set as `XDG_CACHE_HOME`, for the caches of pyopencl and PoCL,
    which fail in a folder that is not writable.
    """
    usual = _usual_folder()
    if usual and _is_writable(usual):
        return usual
    path = Path(tempfile.gettempdir(), f"vtk_mls-{getattr(os, 'getuid', int)()}")
    if not (_is_writable(path) and _is_own(path)):
        return None
    os.environ["XDG_CACHE_HOME"] = str(path)
    return path


def kernel_folder():
    """The folder where pyopencl keeps kernels built for this processor; None for its own.

    pyopencl finds a kernel there by its text, options and driver. A process that is killed while it
    holds the lock of the folder leaves the lock there, and pyopencl then waits a minute for each
    kernel. Such a lock is removed.
    """
    parent = folder()
    if parent is None:
        return None
    digest = hashlib.sha256(repr(processor()).encode()).hexdigest()[:8]
    path = parent / "vtk_mls" / "kernels" / digest
    with suppress(OSError):
        lock = path / "lock"
        if time.time() - lock.stat().st_mtime > _OLDEST_LOCK:
            lock.unlink()
    return str(path)


@lazy.cached
def processor():
    """The processor that a CPU driver compiles for; machines may share a home folder."""
    try:
        with open("/proc/cpuinfo") as info:
            lines = info.read(8192).splitlines()
    except OSError:
        return [platform.machine(), platform.processor()]
    return [line for line in lines if line.startswith(("model name", "flags", "Features"))][:2]


def _usual_folder():
    variable = "LOCALAPPDATA" if sys.platform == "win32" else "XDG_CACHE_HOME"
    defaults = {"win32": "~/AppData/Local", "darwin": "~/Library/Caches"}
    path = os.environ.get(variable) or defaults.get(sys.platform, "~/.cache")
    expanded = os.path.expanduser(path)
    return None if expanded.startswith("~") else Path(expanded)  # without a home


def _is_writable(path):
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            return True
    except OSError:
        return False


def _is_own(path):
    """Whether no other user can have written to a folder."""
    if not hasattr(os, "getuid"):
        return True
    status = path.lstat()
    return status.st_uid == os.getuid() and not status.st_mode & 0o022
