"""OpenCL drivers installed by pip, and the OpenCL loader that finds them."""

import contextlib
import hashlib
import importlib.metadata
import os
import platform
import shutil
import sys
import tempfile
from pathlib import Path

from vtk_mls.engine.device import caches, quirks

# The wheel, its dependencies, and the driver in it.
_PACKAGES = ("intel-opencl-rt", "intel-cmplr-lib-rt", "tbb", "tcmlib")
_LIBRARIES = ("libintelocl.so", "intelocl64.dll")


@contextlib.contextmanager
def registered():
    """A context in which an OpenCL loader also finds the drivers of pip at its first use.

    If the user has set `OCL_ICD_VENDORS`, it stays as it is.
    """
    library = intel_library()
    if library is None or "OCL_ICD_VENDORS" in os.environ:
        yield
    elif sys.platform == "win32":
        # the Khronos loader adds these to the registry's drivers; Windows finds the driver's
        # own libraries on PATH
        others = os.environ.get("OCL_ICD_FILENAMES")
        os.environ["PATH"] = os.pathsep.join([str(library.parent), os.environ.get("PATH", "")])
        with _variable("OCL_ICD_FILENAMES", os.pathsep.join(filter(None, [others, str(library)]))):
            yield
    else:
        with tempfile.TemporaryDirectory(prefix="vtk_mls-") as folder:
            _write_icds(Path(folder), library)
            with _variable("OCL_ICD_VENDORS", folder):
                yield


@contextlib.contextmanager
def own_loader():
    """A context in which imported extension modules use their own OpenCL loader.

    Some programs have already loaded another one: Debian's ParaView loads one through MPI's hwloc,
    and it searches for drivers only once.
    """
    flags = getattr(os, "RTLD_DEEPBIND", 0)
    before = sys.getdlopenflags() if flags else 0
    if flags:
        sys.setdlopenflags(before | flags)
    try:
        yield
    finally:
        if flags:
            sys.setdlopenflags(before)


def advice():
    """What to install for OpenCL on this machine's CPU."""
    if sys.platform == "darwin":
        return "macOS has its own OpenCL: pip install 'vtk-mls[cpu]'"
    if _is_x86():
        return "pip install 'vtk-mls[cpu]' (Intel's runtime, also for AMD processors)"
    return "pip install 'vtk-mls[cpu]' and your system's PoCL (apt-get install pocl-opencl-icd)"


def is_fastest(name):
    """Whether no faster driver for the CPU of this machine is known than that of a platform."""
    return not _is_x86() or name.startswith(quirks.INTEL)


def rank(name):
    """The place of a platform among those for CPUs, the fastest first."""
    known = [name.startswith(platform) for platform in quirks.NATIVE_WIDTH]
    return [*known, True].index(True)


def _is_x86():
    return platform.machine().lower() in ("x86_64", "amd64") and sys.platform != "darwin"


def _write_icds(folder, library):
    """Write .icd files to `folder`: the system's, and one for `library` unless it is among them.

    The .icd file in Intel's wheel has a path of the machine that built it.
    """
    usual = os.environ.get("OPENCL_VENDOR_PATH") or "/etc/OpenCL/vendors"
    found = {}
    for path in (Path(usual), Path(sys.prefix, "etc/OpenCL/vendors")):
        for icd in sorted(path.glob("*.icd")):
            with contextlib.suppress(OSError, UnicodeDecodeError):
                found.setdefault(icd.name, icd.read_text().strip())
    # without a folder the system searches for a driver
    drivers = {n: path for n, path in found.items() if "/" not in path or os.path.exists(path)}
    if not any(Path(path).name.startswith("libintelocl.so") for path in drivers.values()):
        drivers["intel_cpu_of_pip.icd"] = str(library)
    for name, path in drivers.items():
        (folder / name).write_text(path + "\n")


@contextlib.contextmanager
def _variable(name, value):
    before = os.environ.get(name)
    os.environ[name] = value
    try:
        yield
    finally:
        if before is None:
            del os.environ[name]
        else:
            os.environ[name] = before


def intel_library():
    """Path of Intel's driver for CPUs; None if pip has not installed it."""
    for file in _files_of(_PACKAGES[0]):
        if file.name in _LIBRARIES and file.exists():
            return file if sys.platform == "win32" or _has_no_spaces(file) else _linked(file)
    return None


def _files_of(package):
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
    for path in filter(None, (caches.folder(), Path(tempfile.gettempdir()))):
        folder = path / "vtk_mls" / "intel" / name
        if not _has_no_spaces(folder):
            continue
        with contextlib.suppress(OSError):
            if not folder.exists():
                _remove_stale(folder.parent)
                _link_files(folder, driver)
            return folder / driver.name
    return None


def _link_files(folder, driver):
    temporary = folder.with_name(f"{folder.name}.{os.getpid()}")
    temporary.mkdir(mode=0o700, parents=True)
    for package in _PACKAGES:
        for file in _files_of(package):
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
