"""Intel's OpenCL runtime for CPUs, installed by pip: its driver, at a path without spaces."""

import contextlib
import hashlib
import importlib.metadata
import os
import shutil
import sys
import tempfile
from pathlib import Path

from vtk_mls.engine.device import caches

# The wheel, its dependencies, and the driver in it.
_PACKAGES = ("intel-opencl-rt", "intel-cmplr-lib-rt", "tbb", "tcmlib")
_LIBRARIES = ("libintelocl.so", "intelocl64.dll")


def library():
    """Path of the driver; None if it is not installed."""
    for file in _files(_PACKAGES[0]):
        if file.name in _LIBRARIES and file.exists():
            return file if sys.platform == "win32" or _has_no_spaces(file) else _linked(file)
    return None


def _files(package):
    """Paths of the installed files of a package."""
    with contextlib.suppress(importlib.metadata.PackageNotFoundError):
        for file in importlib.metadata.files(package) or ():
            yield Path(os.path.realpath(file.locate()))


def _has_no_spaces(path):
    """Whether the runtime finds its own files: it truncates its path at the first space."""
    return not any(letter.isspace() for letter in str(path))


def _linked(driver):
    """The driver at a path without spaces: hard links to its files, or else copies.

    Symbolic links do not help, because the system resolves them for the runtime.
    """
    name = hashlib.sha256(str(driver).encode()).hexdigest()[:12]
    paths = [caches.folder(), Path(tempfile.gettempdir())]
    for path in filter(None, paths):
        folder = path / "vtk_mls" / "intel" / name
        if not _has_no_spaces(folder):
            continue
        with contextlib.suppress(OSError):
            if not folder.exists():
                _remove_stale(folder.parent)
                _fill(folder, driver)
            return folder / driver.name
    return None


def _fill(folder, driver):
    temporary = folder.with_name(f"{folder.name}.{os.getpid()}")
    temporary.mkdir(mode=0o700, parents=True)
    for package in _PACKAGES:
        for file in _files(package):
            if file.parent == driver.parent:
                try:
                    os.link(file, temporary / file.name)
                except OSError:  # another file system
                    shutil.copy2(file, temporary / file.name)
    (temporary / "driver").write_text(str(driver))
    try:
        temporary.rename(folder)
    except OSError:  # another process was faster
        shutil.rmtree(temporary, ignore_errors=True)
        folder.stat()


def _remove_stale(folder):
    """Remove links to environments that were removed."""
    for source in folder.glob("*/driver"):
        if not Path(source.read_text()).exists():
            shutil.rmtree(source.parent, ignore_errors=True)
