"""OpenCL devices: which there are, which one is meant, and programs built for it."""

from __future__ import annotations

import functools
import itertools
import os
import re
import warnings
from dataclasses import dataclass, field

from vtk_mls.resources import resource

_POCL = "Portable Computing Language"
_INSTALL = (
    "install an OpenCL driver: `pip install 'pyopencl[pocl]'` or, for newer processors, "
    "`apt-get install pocl-opencl-icd` for the CPU, or the one of your GPU"
)


# How programs that start MPI processes tell each its number among those on its node, and how many
# they are.
_PROCESS_VARIABLES = (
    ("OMPI_COMM_WORLD_LOCAL_RANK", "OMPI_COMM_WORLD_LOCAL_SIZE"),  # Open MPI
    ("MPI_LOCALRANKID", "MPI_LOCALNRANKS"),  # MPICH, Intel MPI
    ("MV2_COMM_WORLD_LOCAL_RANK", "MV2_COMM_WORLD_LOCAL_SIZE"),  # MVAPICH
    ("PALS_LOCAL_RANKID", "PALS_LOCAL_SIZE"),  # Cray
    ("SLURM_LOCALID", "SLURM_NTASKS_PER_NODE"),
)


class DeviceError(RuntimeError):
    """No device as asked for, or its driver refused; says what was found and what to install."""


@dataclass(frozen=True)
class Device:
    """An OpenCL device.

    Attributes
    ----------
    key : str
        "platform:device", as `device` of `Deformation` takes it.
    kind : str
        "gpu", "cpu" or "accelerator".
    """

    key: str
    name: str
    platform: str
    kind: str
    version: str
    handle: object = field(repr=False, compare=False)

    @property
    def lanes(self) -> int:
        """Points per work item: the width of the vector units on a CPU, one on a GPU."""
        if self.kind != "cpu":
            return 1
        width = self.handle.native_vector_width_float
        return width if width in (4, 8, 16) else 4

    @property
    def has_float64(self) -> bool:
        """Whether kernels may use double."""
        return bool(self.handle.double_fp_config)

    def __str__(self):
        return f"{self.key} {self.name} ({self.kind}, {self.platform})"


def list_devices() -> list[Device]:
    """All OpenCL devices; empty without pyopencl or a driver."""
    return _find()[0]


def choose(name: str | None = None) -> Device:
    """The device meant by `name`.

    Parameters
    ----------
    name : {"gpu", "cpu", "platform:device"}, optional
        The first GPU, else the first CPU, if not given. MPI processes share out the GPUs of their
        node: the first takes the first GPU, the second the second, and so on round.

    Raises
    ------
    DeviceError
        If there is none; it lists what there is.
    """
    devices, problem = _find()
    for device in devices:
        if name == device.key and defect(device) is None:
            return device
    for kind in ("gpu", "cpu") if name is None else (name,):
        for device in _shared_out([device for device in devices if device.kind == kind]):
            if defect(device) is None:
                return device
    wanted = "no OpenCL device found" if name is None else f"no OpenCL device `{name}`"
    if devices:
        found = "found " + "; ".join(
            f"{device}" + (f", which does not work: {defect(device)}" if defect(device) else "")
            for device in devices
        )
        if all(defect(device) for device in devices):
            raise DeviceError(f"{wanted} that works; {found}; {_INSTALL}")
        raise DeviceError(f'{wanted}; {found}; use one of these, or "reference"')
    raise DeviceError(f"{wanted}: {problem}; {_INSTALL}")


def sharers(device: Device) -> int:
    """How many MPI processes may be using `device`."""
    alike = sum(other.kind == device.kind for other in list_devices())
    return -(-_process_on_node()[1] // max(alike, 1)) if device.kind == "gpu" else 1


def _shared_out(devices):
    """Devices of one kind, this process's own first. All CPU drivers drive the same CPU."""
    first = _process_on_node()[0] % len(devices) if devices and devices[0].kind == "gpu" else 0
    return devices[first:] + devices[:first]


def _process_on_node():
    """The number of this process among the MPI processes of its node, and how many they are."""
    for rank, count in _PROCESS_VARIABLES:
        if os.environ.get(rank, "").isdigit():
            number = int(os.environ[rank])
            told = os.environ.get(count, "")
            return number, max(int(told) if told.isdigit() else 1, number + 1)
    return 0, 1


def _find():
    """Devices, and why there are none."""
    try:
        with warnings.catch_warnings():
            # Debian has no such package; what it does is as well done without
            warnings.filterwarnings("ignore", "Unable to import recommended hash")
            import pyopencl as cl
    except ImportError as error:
        return [], f"pyopencl cannot be imported ({error})"
    try:
        platforms = cl.get_platforms()
    except cl.Error as error:
        return [], f"OpenCL has no platform ({error})"
    kinds = {cl.device_type.GPU: "gpu", cl.device_type.CPU: "cpu"}
    devices = []
    for p, platform in enumerate(platforms):
        try:
            handles = platform.get_devices()
        except cl.Error:  # a platform without devices
            continue
        for d, handle in enumerate(handles):
            kind = kinds.get(handle.type & (cl.device_type.GPU | cl.device_type.CPU), "accelerator")
            devices.append(
                Device(
                    f"{p}:{d}",
                    handle.name.strip(),
                    platform.name.strip(),
                    kind,
                    handle.version.strip(),
                    handle,
                )
            )
    return devices, "OpenCL has no device"


@functools.cache
def defect(device: Device) -> str | None:
    """Why `device` cannot be used, in its driver's words, or None.

    A driver can be found and still build nothing. Of several PoCL in one process only the first
    that works is used: they read each other's files, and the next may end the process.
    """
    import pyopencl as cl

    if device.platform == _POCL:
        number = device.key.partition(":")[0]
        for other in itertools.takewhile(lambda o: not o.key.startswith(f"{number}:"), _find()[0]):
            if other.platform == _POCL and defect(other) is None:
                return f"{other.key} is another PoCL, and two in one process disturb each other"
    try:
        cl.Program(
            context(device), "__kernel void probe(__global int *x) { *x = 1; }"
        ).build()
    except cl.Error as error:
        return _complaints(error)
    return None


@functools.cache
def context(device: Device):
    """The context of `device`, alone in it. It is kept: Intel's runtime does not count a queue's."""
    import pyopencl as cl

    return cl.Context([device.handle])


@functools.cache
def queue(device: Device):
    """The command queue of `device`."""
    import pyopencl as cl

    return cl.CommandQueue(context(device))


@functools.cache
def program(device: Device, file: str, constants: tuple[tuple[str, object], ...]):
    """The program `opencl/file`, built once for `device` with -D `constants`.

    Raises
    ------
    DeviceError
        With the compiler's own words.
    """
    import pyopencl as cl

    # no warnings: they would be about the driver's choice of instructions, which is not ours
    options = ["-w", *(f"-D{name}={value}" for name, value in constants)]
    try:
        return cl.Program(context(device), source(file)).build(options=options)
    except cl.Error as error:
        raise DeviceError(
            f"the kernels in {file} do not build on {device} with {' '.join(options)}: "
            + _complaints(error)
        ) from error


def _complaints(error) -> str:
    """What a compiler complains of, without the rest of its log."""
    lines = [line.strip() for line in str(error).splitlines()]
    return "; ".join([line for line in lines if "error:" in line.lower()] or lines[:1])


def source(file: str) -> str:
    """The text of `opencl/file` with its includes in place, so that driver caches see them."""
    folder = resource("opencl")
    lines = []
    for line in (folder / file).read_text().splitlines():
        include = re.match(r'\s*#include "(.+)"', line)
        lines.append(source(include[1]) if include else line)
    return "\n".join(lines)
