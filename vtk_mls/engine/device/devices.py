"""OpenCL devices: discovery, contexts, and kernels built for them."""

from __future__ import annotations

import functools
import os
import re
import warnings
from dataclasses import dataclass, field

from vtk_mls.base import lazy
from vtk_mls.base.messages import inform
from vtk_mls.base.resources import resource
from vtk_mls.engine.device import caches, drivers, quirks

_OUT_OF_MEMORY = (-4, -5, -6)  # of the device for an object, of its resources, of the host

# Environment variables of MPI launchers: the rank of a process on its node, and the number of
# processes there.
_PROCESS_VARIABLES = (
    ("OMPI_COMM_WORLD_LOCAL_RANK", "OMPI_COMM_WORLD_LOCAL_SIZE"),  # Open MPI
    ("MPI_LOCALRANKID", "MPI_LOCALNRANKS"),  # MPICH, Intel MPI
    ("MV2_COMM_WORLD_LOCAL_RANK", "MV2_COMM_WORLD_LOCAL_SIZE"),  # MVAPICH
    ("PALS_LOCAL_RANKID", "PALS_LOCAL_SIZE"),  # Cray
    ("SLURM_LOCALID", "SLURM_NTASKS_PER_NODE"),
)

# The process that loaded the drivers, whose threads do not exist in a fork.
_loaded_in = None


class DeviceError(RuntimeError):
    """The device does not exist or its driver failed; lists what was found and what to install."""


class NoDevice(DeviceError):
    """There is no device, none that works, or none of a name."""


class OutOfDeviceMemory(DeviceError):
    """The memory of the device does not suffice for one launch."""


@dataclass(frozen=True)
class Device:
    """An OpenCL device."""

    key: str  # "platform:device", as `device` of `Deformation` takes it
    name: str
    platform: str
    kind: str  # "gpu", "cpu" or "accelerator"
    version: str  # of OpenCL, with the driver's additions
    handle: object = field(repr=False, compare=False)
    driver: str = ""  # versions of the driver and of its platform
    width: int | None = None  # points per work item, instead of those that `quirks` chooses

    @functools.cached_property
    def lanes(self):
        """Points per work item: the width of the vector units on a CPU, one on a GPU."""
        return self.width or quirks.lanes(self)

    @functools.cached_property
    def double_lanes(self):
        """The same for kernels that call built-ins for double."""
        return min([self.lanes, *(fault.max_double_lanes for fault in quirks.faults(self))])

    @functools.cached_property
    def has_float64(self):
        """Whether kernels may use double."""
        return bool(self.handle.double_fp_config)

    def __str__(self):
        return f"{self.key} {self.name} ({self.kind}, {self.platform})"


def list_devices():
    """All OpenCL devices; empty without pyopencl or a driver."""
    return find()[0]


def sharers(device):
    """How many MPI processes may be using `device`."""
    alike = sum(other.kind == device.kind for other in list_devices())
    return -(-_process_on_node()[1] // max(alike, 1)) if device.kind == "gpu" else 1


def shared_out(gpus):
    """GPUs in the order of preference of this process: MPI processes start at different ones."""
    first = _process_on_node()[0] % len(gpus) if gpus else 0
    return gpus[first:] + gpus[:first]


def _process_on_node():
    """The rank of this process among the MPI processes of its node, and their number."""
    for rank, count in _PROCESS_VARIABLES:
        if os.environ.get(rank, "").isdigit():
            local_rank, size = int(os.environ[rank]), os.environ.get(count, "")
            return local_rank, max(int(size) if size.isdigit() else 1, local_rank + 1)
    return 0, 1


def find():
    """All OpenCL devices, and the reason if the list is empty.

    DeviceError in a fork of a process that has used OpenCL.
    """
    if _loaded_in not in (None, os.getpid()):
        raise DeviceError(
            "this process was forked from one that had used OpenCL, whose threads do not exist "
            "here: start processes with multiprocessing.set_start_method('spawn'), or use "
            'device="reference" in them'
        )
    try:
        return _listed(), "OpenCL has no device"
    except ImportError as error:
        return [], f"pyopencl cannot be imported ({error})"
    except LookupError as error:
        return [], str(error)


@lazy.cached
def _listed():
    global _loaded_in
    cl = _pyopencl()
    try:
        with drivers.registered():
            platforms = cl.get_platforms()
    except cl.Error as error:
        raise LookupError(f"OpenCL has no platform ({error})") from error
    _loaded_in = os.getpid()
    devices = []
    for p, platform in enumerate(platforms):
        try:
            handles = platform.get_devices()
        except cl.Error:  # a platform without devices
            continue
        devices += [_device(f"{p}:{d}", platform, handle) for d, handle in enumerate(handles)]
    return devices


def _pyopencl():
    """The module pyopencl, with writable caches, or ImportError."""
    caches.folder()
    # otherwise pyopencl raises after a failure of its cache
    os.environ.setdefault("PYOPENCL_CACHE_FAILURE_FATAL", "")
    import numpy  # noqa: F401  first, because it has no loader

    with warnings.catch_warnings(), drivers.own_loader():
        # Debian lacks that package, which is not needed
        warnings.filterwarnings("ignore", "Unable to import recommended hash")
        import pyopencl as cl
    if not hasattr(cl, "get_platforms"):  # a folder left by an uninstalled one
        raise ImportError(f"{next(iter(cl.__path__))} has no pyopencl: install it again")
    return cl


def _device(key, platform, handle):
    import pyopencl as cl

    # Oclgrind reports all types
    if handle.type & cl.device_type.CPU:
        kind = "cpu"
    else:
        kind = "gpu" if handle.type & cl.device_type.GPU else "accelerator"
    return Device(
        key,
        handle.name.strip(),
        platform.name.strip(),
        kind,
        handle.version.strip(),
        handle,
        f"{handle.driver_version.strip()}, {platform.version.strip()}",
    )


@lazy.cached
def context(device):
    """The context of `device` alone. It is cached: a queue of Intel's runtime does not own it.

    DeviceError if another driver has a context, and a process can use only one of both.
    """
    import pyopencl as cl

    if not is_free(device):
        raise DeviceError(
            f"{device} cannot be used in a process that uses another {device.platform} already; "
            "use another `device` or another process"
        )
    try:
        made = cl.Context([device.handle])
    except cl.Error as error:
        raise failure(device, error) from error
    _in_use.append(device)
    return made


_in_use: list[Device] = []


def is_free(device):
    """Whether the process uses no other driver that excludes that of `device`."""
    if not any(fault.is_alone for fault in quirks.faults(device)):
        return True
    alike = [other for other in (device, *_in_use) if other.platform == device.platform]
    return len({other.key.partition(":")[0] for other in alike}) == 1


@lazy.cached
def queue(device):
    """The command queue of `device`."""
    import pyopencl as cl

    try:
        return cl.CommandQueue(context(device))
    except cl.Error as error:
        raise failure(device, error) from error


def failure(device, error):
    """The DeviceError or OutOfDeviceMemory of an error of the driver, a pyopencl.Error."""
    # some errors of pyopencl have only a text
    code = getattr(error.args[0], "code", int)() if error.args else 0
    if code in _OUT_OF_MEMORY:
        return OutOfDeviceMemory(f"{device} does not have enough memory: {error}")
    return DeviceError(f"the driver of {device} failed: {error}; try another `device`")


@lazy.cached
def kernel(device, name, constants):
    """The kernel `name` of the file `name`.cl, built once for `device`.

    `constants` are its macros, pairs of a name and a value. A DeviceError has the errors of the
    compiler.
    """
    inform("Building OpenCL kernels", logged=False)
    text = source(f"{name}.cl", constants)
    try:
        return _built(device, name, text)
    except DeviceError:
        raise
    except Exception:
        # The cache of the driver or of pyopencl may be broken by a process that ended during a
        # build: another text has another cache entry.
        try:
            return _built(device, name, f"{text}\n// built anew\n")
        except Exception as error:
            lines = [line.strip() for line in str(error).splitlines()]
            errors = [line for line in lines if "error:" in line.lower()] or lines[:1]
            raise DeviceError(
                f"the kernel {name} does not build on {device} with "
                f"{', '.join(f'{constant} = {value}' for constant, value in constants)}: "
                f"{'; '.join(errors)}"
            ) from error


def _built(device, name, text):
    import pyopencl as cl

    with warnings.catch_warnings():
        # output of the compiler, and failures of pyopencl's cache
        warnings.simplefilter("ignore")
        # warnings are about the driver's choice of instructions
        program = cl.Program(context(device), text)
        if any(fault.has_cache for fault in quirks.faults(device)):
            program.get_info(cl.program_info.CONTEXT)  # before the build: pyopencl keeps no kernel
        options = ["-w", *quirks.options(device)]
        return cl.Kernel(program.build(options=options, cache_dir=caches.kernel_folder()), name)


def source(file, constants=()):
    """The text of a kernel file after macros, with its includes expanded.

    So driver caches see the whole text. File names are unique in the folders of opencl/;
    `#include NAME` includes the files that the constant NAME lists.
    """
    macros = [f"#define {name} {value}" for name, value in constants]
    return "\n".join([*macros, _included(file, dict(constants))])


@lazy.cached
def _kernel_files():
    return {path.name: path for path in resource("opencl").rglob("*.[ch]*")}


def _included(file, constants):
    lines = []
    for line in _kernel_files()[file].read_text().splitlines():
        include = re.match(r'\s*#include (?:"(.+)"|(\w+))', line)
        files = (include[1] or constants.get(include[2], "")).split() if include else ()
        lines += [_included(name, constants) for name in files] if include else [line]
    return "\n".join(lines)
