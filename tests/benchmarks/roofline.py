"""How near kernels are to what a device can do: its multiply-adds, and its memory's bandwidth.

Both peaks are measured through OpenCL. Kernels are timed alone, from launch to end.
"""

from __future__ import annotations

import time
import warnings
from collections import defaultdict
from contextlib import contextmanager

import numpy as np
import operations
import pyopencl as cl

from vtk_mls import Grid
from vtk_mls.engine.device import devices
from vtk_mls.engine.launch.launcher import Launcher

_CHAINS = 10  # that do not wait for each other: enough for any latency, few enough for registers
_STEPS = 4000
_RUNS = 7
_SECONDS = 0.02
_COPIED = 1 << 28  # bytes: in no cache
_SOURCE = """
typedef REAL real;
__kernel void multiply_add(__global float *out, const float a, const float b) {
  real x[CHAINS], sum = 0;
#pragma unroll
  for (int c = 0; c < CHAINS; ++c) x[c] = (real)(get_global_id(0) + c);
  for (int step = 0; step < STEPS; ++step)
#pragma unroll
    for (int c = 0; c < CHAINS; ++c) x[c] = fma(x[c], (real)(a), (real)(b));
  for (int c = 0; c < CHAINS; ++c) sum += x[c];
  out[get_global_id(0)] = FIRST(sum);
}
__kernel void copy(__global const WIDE *restrict from, __global WIDE *restrict to) {
  to[get_global_id(0)] = from[get_global_id(0)];
}
"""


def peaks(device):
    """10^9 operations a second (a fused multiply-add is two), and 10^9 bytes a second."""
    context, queue, lanes = devices.context(device), devices.queue(device), device.lanes
    program, wide, flags = _program(device), _wide(device), cl.mem_flags.READ_WRITE
    items = 1024 * device.handle.max_compute_units
    out = cl.Buffer(context, flags, 4 * items)
    pair = [cl.Buffer(context, flags, _COPIED) for _ in range(2)]
    for buffer in pair:
        cl.enqueue_fill_buffer(queue, buffer, np.float32(1), 0, _COPIED)
    steps = cl.Kernel(program, "multiply_add"), cl.Kernel(program, "copy")
    launches = (
        lambda: steps[0](queue, (items,), (64,), out, np.float32(0.999), np.float32(0.001)),
        lambda: steps[1](queue, (_COPIED // (4 * wide),), (64,), *pair),
    )
    seconds = [_smallest(queue, launch) for launch in launches]
    amounts = 2 * items * lanes * _CHAINS * _STEPS, 2 * _COPIED
    return [amount / each / 1e9 for amount, each in zip(amounts, seconds)]


def _wide(device):
    """Floats that an item copies."""
    return max(4, device.lanes)


def _program(device):
    lanes = device.lanes
    kind, first = (f"float{lanes}", "(x).s0") if lanes > 1 else ("float", "(x)")
    options = [f"-DREAL={kind}", f"-DFIRST(x)={first}", f"-DWIDE=float{_wide(device)}"]
    options += [f"-DCHAINS={_CHAINS}", f"-DSTEPS={_STEPS}"]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a compiler's praise of itself
        return cl.Program(devices.context(device), _SOURCE).build(options=options)


def transfers(device):
    """10^9 bytes a second between a host's array and the memory of a device, both ways."""
    queue, host = devices.queue(device), np.ones(_COPIED, np.uint8)
    buffer = cl.Buffer(devices.context(device), cl.mem_flags.READ_WRITE, _COPIED)
    ways = {"copy to the device": (buffer, host), "copy from the device": (host, buffer)}
    return {
        name: _COPIED / _smallest(queue, lambda pair=pair: cl.enqueue_copy(queue, *pair)) / 1e9
        for name, pair in ways.items()
    }


def _smallest(queue, launch):
    """Seconds of a launch, of so many one behind the other that what begins and ends is little."""
    count, best = 1, np.inf
    for _ in range(_RUNS):
        queue.finish()
        start = time.perf_counter()
        for _ in range(count):
            launch()
        queue.finish()
        best = min(best, (time.perf_counter() - start) / count)
        count = int(np.ceil(_SECONDS / best))
    return best


@contextmanager
def timed():
    """Seconds of each kernel that is launched meanwhile, by its name."""
    launch, seconds = Launcher.launch, defaultdict(float)

    def measured(self, name, *arguments):
        self.memory.queue.finish()
        start = time.perf_counter()
        launch(self, name, *arguments)
        self.memory.queue.finish()
        seconds[name] += time.perf_counter() - start

    Launcher.launch = measured
    try:
        yield seconds
    finally:
        Launcher.launch = launch


def table(engine, n):
    """Kernels with their shares of the peaks, as rows of a table of the benchmark."""
    operations_of, peak = operations.counted(), peaks(engine.device)
    grid, rows = Grid((n, n, n)), {}
    for question in operations.questions(n):
        best = np.inf
        for _ in range(1 + _RUNS):  # the first builds
            with timed() as seconds:
                question.ask(engine, grid)
            best = min(best, seconds[question.kernel])
        row = rows[question.name] = {"ms": 1000 * best}
        moved = question.bytes * grid.size / best / 1e9
        if operations_of:
            needed = operations_of[question.name]
            done = needed["point"] * grid.size / best / 1e9
            row["operations"] = needed["point"]
            row["for each control point"] = round(needed["pair"], 1)
            row |= {"G/s": done, "% of the peak": 100 * done / peak[0]}
        row |= {"bytes": question.bytes, "GB/s": moved, "% of the memory's": 100 * moved / peak[1]}
    rows["peak"] = {"G/s": peak[0], "GB/s": peak[1]}
    if engine.device.kind != "cpu":  # that one works on the host's arrays
        rows |= {name: {"GB/s": speed} for name, speed in transfers(engine.device).items()}
    return rows
