"""Folders that last as long as a process, whatever ends it."""

from __future__ import annotations

import os
import shutil
import stat
import tempfile
import time
from contextlib import contextmanager, suppress
from pathlib import Path

try:
    import fcntl
except ModuleNotFoundError:  # Windows removes nothing that is open, and has no such locks
    fcntl = None

_PREFIX = "vtk-mls-temporary-"  # as nobody names what is to stay
_YOUNG = 600  # seconds, in which a folder may not yet be locked by the process that makes it


@contextmanager
def made():
    """A new folder, which is removed at the end; and those of processes that were killed.

    A lock that the system releases when its process ends tells whose are still in use, also across
    containers that share a folder for temporary files, where numbers of processes do not.
    """
    remove_abandoned(tempfile.gettempdir())
    with tempfile.TemporaryDirectory(prefix=_PREFIX) as folder, _locked(folder):
        yield folder


def remove_abandoned(where):
    """Remove folders of this user that nobody holds any more."""
    for folder in Path(where).glob(f"{_PREFIX}*"):
        with suppress(OSError):  # it is held, or was removed by another one
            if _may_be_abandoned(folder):
                with _locked(folder, is_needed=True):
                    shutil.rmtree(folder)


def _may_be_abandoned(folder):
    """Whether it is one of this user's, and not just being made."""
    found = folder.lstat()
    is_own = fcntl is not None and stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid()
    return is_own and time.time() - found.st_mtime > _YOUNG


@contextmanager
def _locked(folder, is_needed=False):
    """Hold the lock of a folder, where there are locks; OSError if it is needed but not free."""
    if fcntl is None:
        yield
        return
    held = os.open(folder, os.O_RDONLY)
    try:
        with suppress(*(() if is_needed else (OSError,))):  # some network drives have none
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(held)
