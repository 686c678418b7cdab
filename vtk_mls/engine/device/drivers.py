"""OpenCL drivers that pip installed: shown to the OpenCL loader, which looks for the system's."""

from __future__ import annotations

import contextlib
import os
import platform
import sys
import tempfile
from pathlib import Path

from vtk_mls.engine.device import intel_runtime


@contextlib.contextmanager
def shown():
    """While this lasts, an OpenCL loader that is asked for the first time finds pip's drivers, too.

    Whoever has set `OCL_ICD_VENDORS` gets just that.
    """
    library = intel_runtime.library()
    if library is None or "OCL_ICD_VENDORS" in os.environ:
        yield
    elif sys.platform == "win32":
        # the Khronos loader adds these to the registry's; Windows looks for the driver's own
        # libraries on PATH
        others = os.environ.get("OCL_ICD_FILENAMES")
        os.environ["PATH"] = os.pathsep.join([str(library.parent), os.environ.get("PATH", "")])
        with _variable("OCL_ICD_FILENAMES", os.pathsep.join(filter(None, [others, str(library)]))):
            yield
    else:
        with tempfile.TemporaryDirectory(prefix="vtk_mls-") as folder:
            _fill(Path(folder), library)
            with _variable("OCL_ICD_VENDORS", folder):
                yield


@contextlib.contextmanager
def own_loader():
    """Extension modules that are imported meanwhile use the OpenCL loader that they bring.

    Some programs have another in the process before: Debian's ParaView has, by MPI's hwloc, which
    has asked it for drivers already, and it looks for them once.
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


def advice() -> str:
    """What to install for OpenCL on this machine's CPU."""
    if sys.platform == "darwin":
        return "macOS brings its own OpenCL, and pip install pyopencl what uses it"
    if _is_x86():
        packages = "pyopencl intel-opencl-rt intel-cmplr-lib-rt"
        return f"pip install {packages} (Intel's runtime, for processors of AMD, too)"
    return "pip install pyopencl and your system's PoCL (apt-get install pocl-opencl-icd)"


def is_fastest(name: str) -> bool:
    """Whether no driver for CPUs is known to be faster on this machine than those of a platform."""
    return not _is_x86() or name.startswith("Intel(R) OpenCL")


def _is_x86():
    return platform.machine().lower() in ("x86_64", "amd64") and sys.platform != "darwin"


def _fill(folder, library):
    """Put .icd files in `folder`: the system's, and one for `library` unless they have it.

    The one in Intel's wheel holds a path of the machine that built it.
    """
    usual = os.environ.get("OPENCL_VENDOR_PATH") or "/etc/OpenCL/vendors"
    found = {}
    for path in (Path(usual), Path(sys.prefix, "etc/OpenCL/vendors")):
        for icd in sorted(path.glob("*.icd")):
            with contextlib.suppress(OSError, UnicodeDecodeError):
                found.setdefault(icd.name, icd.read_text().strip())
    names = {name: path for name, path in found.items() if _could_be_loaded(path)}
    if not any(Path(path).name.startswith("libintelocl.so") for path in names.values()):
        names["intel_cpu_of_pip.icd"] = str(library)
    for name, path in names.items():
        (folder / name).write_text(path + "\n")


def _could_be_loaded(path):
    """Whether a driver is there; those named without a folder are looked for by the system."""
    return "/" not in path or os.path.exists(path)


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
