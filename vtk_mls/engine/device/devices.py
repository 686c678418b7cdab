"""OpenCL devices: which there are, their contexts, and kernels built for them."""

from __future__ import annotations

import contextlib
import functools
import os
import re
import warnings
from dataclasses import dataclass, field

from vtk_mls.base.messages import inform
from vtk_mls.base.resources import resource
from vtk_mls.engine.device import caches, drivers

POCL = "Portable Computing Language"
# Processors as LLVM names them that have AVX-512; PoCL says for which one it compiles.
_WITH_AVX512 = re.compile(
    r"skylake-avx512|cascadelake|cooperlake|cannonlake|icelake|tigerlake|rocketlake"
    r"|sapphirerapids|emeraldrapids|graniterapids|diamondrapids|kn[lm]|znver[4-9]"
)
_OUT_OF_MEMORY = (-4, -5, -6)  # of the device for an object, of its resources, of the host

# How programs that start MPI processes tell each its number among those on its node, and how many
# they are.
_PROCESS_VARIABLES = (
    ("OMPI_COMM_WORLD_LOCAL_RANK", "OMPI_COMM_WORLD_LOCAL_SIZE"),  # Open MPI
    ("MPI_LOCALRANKID", "MPI_LOCALNRANKS"),  # MPICH, Intel MPI
    ("MV2_COMM_WORLD_LOCAL_RANK", "MV2_COMM_WORLD_LOCAL_SIZE"),  # MVAPICH
    ("PALS_LOCAL_RANKID", "PALS_LOCAL_SIZE"),  # Cray
    ("SLURM_LOCALID", "SLURM_NTASKS_PER_NODE"),
)

# The process that loaded the drivers: their threads do not live on in a fork of it.
_loaded_in = None


class DeviceError(RuntimeError):
    """No device as asked for, or its driver refused; says what was found and what to install."""


class OutOfDeviceMemory(DeviceError):
    """A device had not memory enough for what was asked of it at once."""


@dataclass(frozen=True)
class Device:
    """An OpenCL device.

    Attributes
    ----------
    key : str
        "platform:device", as `device` of `Deformation` takes it.
    kind : str
        "gpu", "cpu" or "accelerator".
    version : str
        OpenCL that it has, and what its driver adds to that.
    driver : str
        Versions of the driver and of its platform.
    width : int, optional
        Points per work item that it computes right; see `device_check`.
    """

    key: str
    name: str
    platform: str
    kind: str
    version: str
    handle: object = field(repr=False, compare=False)
    driver: str = ""
    width: int | None = None

    @property
    def lanes(self) -> int:
        """Points per work item: the width of the vector units on a CPU, one on a GPU."""
        return self.width or self.widths[0]

    @property
    def widths(self) -> tuple[int, ...]:
        """Points per work item that may be tried, the fastest first."""
        if self.kind != "cpu":
            return (1,)
        native = self.handle.native_vector_width_float
        widest = native if native in (4, 8, 16) else 4
        if self._miscompiles_512_bits:
            widest = min(widest, 8)
        return tuple(width for width in (16, 8, 4, 1) if width <= widest)

    @property
    def double_lanes(self) -> int:
        """The same for kernels that sum in double."""
        return min(self.lanes, 4) if self._miscompiles_512_bits else self.lanes

    @property
    def _miscompiles_512_bits(self):
        """PoCL before 5 takes some CPUs for ones without AVX-512, but has built-ins for ones with:
        vectors of 512 bits are handed over in other registers than they are looked for in."""
        return _pocl_version(self) < (5,) and not _WITH_AVX512.search(self.version)

    @property
    def has_float64(self) -> bool:
        """Whether kernels may use double."""
        return bool(self.handle.double_fp_config)

    def __str__(self):
        return f"{self.key} {self.name} ({self.kind}, {self.platform})"


def _pocl_version(device):
    """Version of PoCL; without it one that is later than all."""
    found = re.search(r"PoCL (\d+)\.(\d+)", device.driver) if device.platform == POCL else None
    return tuple(map(int, found.groups())) if found else (1000,)


def list_devices() -> list[Device]:
    """All OpenCL devices; empty without pyopencl or a driver."""
    return find()[0]


def sharers(device: Device) -> int:
    """How many MPI processes may be using `device`."""
    alike = sum(other.kind == device.kind for other in list_devices())
    return -(-_process_on_node()[1] // max(alike, 1)) if device.kind == "gpu" else 1


def shared_out(gpus: list[Device]) -> list[Device]:
    """GPUs in the order in which this process should take them: its own among MPI's first."""
    first = _process_on_node()[0] % len(gpus) if gpus else 0
    return gpus[first:] + gpus[:first]


def _process_on_node():
    """The number of this process among the MPI processes of its node, and how many they are."""
    for rank, count in _PROCESS_VARIABLES:
        if os.environ.get(rank, "").isdigit():
            number = int(os.environ[rank])
            told = os.environ.get(count, "")
            return number, max(int(told) if told.isdigit() else 1, number + 1)
    return 0, 1


def find() -> tuple[list[Device], str]:
    """All OpenCL devices, and why there are none.

    Raises
    ------
    DeviceError
        In a process forked from one that has asked for them.
    """
    if _loaded_in not in (None, os.getpid()):
        raise DeviceError(
            "this process was forked from one that had used OpenCL, whose threads did not come "
            "along: start processes afresh, with multiprocessing.set_start_method('spawn'), or "
            'use device="reference" in them'
        )
    return _listed()


@functools.cache
def _listed():
    global _loaded_in
    try:
        cl = _pyopencl()
    except ImportError as error:
        return [], f"pyopencl cannot be imported ({error})"
    _loaded_in = os.getpid()
    try:
        with drivers.shown():
            platforms = cl.get_platforms()
    except cl.Error as error:
        return [], f"OpenCL has no platform ({error})"
    devices = []
    for p, platform in enumerate(platforms):
        try:
            handles = platform.get_devices()
        except cl.Error:  # a platform without devices
            continue
        devices += [_described(f"{p}:{d}", platform, handle) for d, handle in enumerate(handles)]
    return devices, "OpenCL has no device"


def _pyopencl():
    """The module, with caches that it can write.

    Raises
    ------
    ImportError
    """
    caches.folder()
    # pyopencl asks for it, unless it is set, after a failure of its cache
    os.environ.setdefault("PYOPENCL_CACHE_FAILURE_FATAL", "")
    import numpy  # noqa: F401  first, for it brings no loader

    with warnings.catch_warnings(), drivers.own_loader():
        # Debian has no such package; what it does is as well done without
        warnings.filterwarnings("ignore", "Unable to import recommended hash")
        import pyopencl as cl
    if not hasattr(cl, "get_platforms"):  # a folder that an uninstalled one has left
        raise ImportError(f"there is no pyopencl in {next(iter(cl.__path__))}: install it again")
    return cl


def _described(key, platform, handle):
    import pyopencl as cl

    # a simulator calls itself all of them
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


@functools.cache
def context(device: Device):
    """The context of `device`, alone in it. It is kept: Intel's runtime does not count a queue's.

    Raises
    ------
    DeviceError
        If another PoCL has one: they read each other's files, and the second may end the process.
    """
    import pyopencl as cl

    if not is_free(device):
        raise DeviceError(
            f"{device} cannot be used in a process that uses another PoCL already, for two of them "
            "disturb each other"
        )
    _in_use.append(device)
    with driver_errors(device):
        return cl.Context([device.handle])


_in_use: list[Device] = []


def is_free(device: Device) -> bool:
    """Whether this process uses no other PoCL, if the device is one of PoCL's."""
    platforms = {d.key.partition(":")[0] for d in (*_in_use, device) if d.platform == POCL}
    return device.platform != POCL or len(platforms) == 1


@functools.cache
def queue(device: Device):
    """The command queue of `device`."""
    import pyopencl as cl

    with driver_errors(device):
        return cl.CommandQueue(context(device))


@contextlib.contextmanager
def driver_errors(device: Device):
    """Turns what a driver complains of into a sentence.

    Raises
    ------
    OutOfDeviceMemory, DeviceError
    """
    import pyopencl as cl

    try:
        yield
    except cl.Error as error:
        # pyopencl raises some with a mere text
        code = getattr(error.args[0], "code", int)() if error.args else 0
        if code in _OUT_OF_MEMORY:
            raise OutOfDeviceMemory(f"{device} has not memory enough: {error}") from error
        raise DeviceError(
            f"the driver of {device} refuses: {error}; try another `device`"
        ) from error


@functools.cache
def kernel(device: Device, name: str, constants: tuple[tuple[str, object], ...]):
    """The kernel `name` of the file `name`.cl, built once for `device` with macros `constants`.

    Raises
    ------
    DeviceError
        With the compiler's own words.
    """
    inform("Building OpenCL kernels", logged=False)
    text = source(f"{name}.cl", constants)
    try:
        return _built(device, name, text)
    except DeviceError:
        raise
    except Exception:
        # What a driver or pyopencl keeps of earlier builds may be broken, by a process that ended
        # half way: a text of its own has a place of its own there.
        try:
            return _built(device, name, f"{text}\n// built anew\n")
        except Exception as error:
            raise DeviceError(
                f"the kernel {name} does not build on {device} with "
                f"{', '.join(f'{constant} = {value}' for constant, value in constants)}: "
                + _complaints(error)
            ) from error


def _built(device, name, text):
    import pyopencl as cl

    with warnings.catch_warnings():
        # a compiler's praise of itself, and caches: of pyopencl's that fail, the next build tells
        warnings.simplefilter("ignore")
        # no warnings: they would be about the driver's choice of instructions, which is not ours
        return cl.Kernel(cl.Program(context(device), text).build(options=["-w"]), name)


def _complaints(error) -> str:
    """What a compiler complains of, without the rest of its log."""
    lines = [line.strip() for line in str(error).splitlines()]
    return "; ".join([line for line in lines if "error:" in line.lower()] or lines[:1])


def source(file: str, constants: tuple[tuple[str, object], ...] = ()) -> str:
    """The text of a kernel file after macros, with its includes expanded.

    So driver caches see the whole text. File names are unique in the folders of opencl/;
    `#include NAME` includes the files that the constant NAME lists.
    """
    macros = [f"#define {name} {value}" for name, value in constants]
    return "\n".join([*macros, _included(file, dict(constants))])


@functools.cache
def _kernel_files():
    """The files of opencl/ by name."""
    return {path.name: path for path in resource("opencl").rglob("*.[ch]*")}


def _included(file, constants):
    lines = []
    for line in _kernel_files()[file].read_text().splitlines():
        include = re.match(r'\s*#include (?:"(.+)"|(\w+))', line)
        files = (include[1] or constants.get(include[2], "")).split() if include else ()
        lines += [_included(each, constants) for each in files] if include else [line]
    return "\n".join(lines)
