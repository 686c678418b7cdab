"""Faults of OpenCL drivers, one row for each, and the width of their vectors.

A fault that costs nothing to avoid is avoided for all drivers in the kernels, with a comment there.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass

INTEL = "Intel(R) OpenCL"
POCL = "Portable Computing Language"
# CPU drivers, the fastest first, that compile vectors of the native width right; others get vectors
# of 128 bits.
NATIVE_WIDTH = (INTEL, POCL)
# LLVM's names of processors with AVX-512; the version of a PoCL device has one.
_WITH_AVX512 = re.compile(
    r"skylake-avx512|cascadelake|cooperlake|cannonlake|icelake|tigerlake|rocketlake"
    r"|sapphirerapids|emeraldrapids|graniterapids|diamondrapids|kn[lm]|znver[4-9]"
)


@dataclass(frozen=True)
class Quirk:
    """A fault of a driver, and what avoids it."""

    platform: str  # start of the name of the OpenCL platform
    fault: str  # in one sentence
    # of a Device: whether the version of the driver or the processor has the fault
    is_affected: Callable[..., bool] = lambda device: True
    max_lanes: int = 16  # points per work item
    max_double_lanes: int = 16  # the same in kernels that call built-ins for double
    options: tuple[str, ...] = ()  # of the compiler; `-DNAME` defines a macro in all kernels
    is_alone: bool = False  # whether a process can use only one driver with the fault
    has_cache: bool = False  # whether pyopencl must keep no kernels, because the driver does


def _calls_wide_builtins(device):
    version = re.search(r"PoCL (\d+)\.", device.driver)
    return version and int(version[1]) < 5 and not _WITH_AVX512.search(device.version)


QUIRKS = (
    Quirk(
        POCL,
        "Before version 5, PoCL compiles for some CPUs with AVX-512 as for CPUs without, but calls "
        "built-ins with AVX-512, which expect vectors of 512 bits in other registers.",
        _calls_wide_builtins,
        max_lanes=8,
        max_double_lanes=4,
    ),
    Quirk(
        POCL,
        "Two versions in one process use the same files, and the second may crash.",
        is_alone=True,
    ),
    Quirk(
        POCL,
        "Binaries, which old versions of pyopencl keep, are compiled for work groups of any "
        "size, for twice the time. PoCL itself keeps kernels for the sizes that are used.",
        has_cache=True,
    ),
    Quirk(
        "Oclgrind",
        "With inlining, LLVM adds calls that the simulator does not support.",
        options=("-O0", "-Dalways_inline="),
    ),
)


def faults(device):
    """The faults of the driver of a Device."""
    alike = [quirk for quirk in QUIRKS if device.platform.startswith(quirk.platform)]
    return [quirk for quirk in alike if quirk.is_affected(device)]


def lanes(device):
    """Points per work item: the width of the vector units on a CPU, one on other devices."""
    if device.kind != "cpu":
        return 1
    native = device.handle.native_vector_width_float if device.platform in NATIVE_WIDTH else 4
    widest = native if native in (4, 8, 16) else 4
    return min([widest, *(fault.max_lanes for fault in faults(device))])


def options(device):
    """Options of the compiler."""
    return [option for fault in faults(device) for option in fault.options]
