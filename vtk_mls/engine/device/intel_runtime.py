"""Intel's OpenCL runtime for CPUs as pip installs it: its driver, at a path that it can bear."""

from __future__ import annotations

import contextlib
import hashlib
import importlib.metadata
import os
import shutil
import sys
import tempfile
from pathlib import Path

from vtk_mls.engine.device import caches

# The wheel, those that it needs, and the driver in it.
_PACKAGES = ("intel-opencl-rt", "intel-cmplr-lib-rt", "tbb", "tcmlib")
_LIBRARIES = ("libintelocl.so", "intelocl64.dll")


def library() -> Path | None:
    """Path of the driver; None if it is not installed."""
    for file in _files(_PACKAGES[0]):
        if file.name in _LIBRARIES and file.exists():
            return file if sys.platform == "win32" or _is_plain(file) else _elsewhere(file)
    return None


def _files(package):
    """Paths of what a package has installed."""
    with contextlib.suppress(importlib.metadata.PackageNotFoundError):
        for file in importlib.metadata.files(package) or ():
            yield Path(os.path.realpath(file.locate()))


def _is_plain(path):
    """Whether the runtime finds its own files: it cuts its path at the first space."""
    return not any(letter.isspace() for letter in str(path))


def _elsewhere(driver):
    """The driver under a path without spaces: links to all its files, or else copies.

    The runtime asks the system for the path, which sees through symbolic links.
    """
    name = hashlib.sha256(str(driver).encode()).hexdigest()[:12]
    paths = [caches.folder(), Path(tempfile.gettempdir())]
    for path in filter(None, paths):
        folder = path / "vtk_mls" / "intel" / name
        if not _is_plain(folder):
            continue
        with contextlib.suppress(OSError):
            if not folder.exists():
                _forget_what_is_gone(folder.parent)
                _fill(folder, driver)
            return folder / driver.name
    return None


def _fill(folder, driver):
    beside = folder.with_name(f"{folder.name}.{os.getpid()}")
    beside.mkdir(mode=0o700, parents=True)
    for package in _PACKAGES:
        for file in _files(package):
            if file.parent == driver.parent:
                try:
                    os.link(file, beside / file.name)
                except OSError:  # another file system
                    shutil.copy2(file, beside / file.name)
    (beside / "driver").write_text(str(driver))
    try:
        beside.rename(folder)
    except OSError:  # another process was faster
        shutil.rmtree(beside, ignore_errors=True)
        folder.stat()


def _forget_what_is_gone(folder):
    """Remove what belongs to environments that are no more."""
    for source in folder.glob("*/driver"):
        if not Path(source.read_text()).exists():
            shutil.rmtree(source.parent, ignore_errors=True)
