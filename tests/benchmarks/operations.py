"""How many operations kernels need for a point, counted instruction by instruction.

Oclgrind, a simulator, runs the compiled kernels and says how often it has executed what. What
counts are operations on floats: an addition, a multiplication, a division and a root are one each,
a fused multiply-add is two. Comparisons, selections, conversions and integers count nothing.

python operations.py      # in an environment with Oclgrind: one JSON object to standard output
"""

from __future__ import annotations

import ctypes
import dataclasses
import os
import re
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

PROJECT = Path(__file__).resolve().parents[2]
ENVIRONMENT = PROJECT / ".venv-oclgrind"
HANDLES = 15
_SHAPE = (8, 8, 4)  # of a grid: enough for the mean of a point
_TWO = re.compile(r"call (_Z\d+(fma|mad)|llvm\.(fma|fmuladd))")
_ONE = re.compile(r"fadd|fsub|fmul|fdiv|frem|call _Z\d+(native_|half_)?(r?sqrt|exp|log|pow|recip)")
_LINE = re.compile(r"\s*(\d+) - (.*)")
_KERNEL = re.compile(r"Instructions executed for kernel '(\w+)'")


def handles(n, count=HANDLES):
    """Random control points in a cube of n voxels, moved by some percent of its size."""
    random = np.random.default_rng(1)
    rest = random.uniform(0.1 * n, 0.9 * n, (count, 3))
    return rest, rest + random.normal(0, 0.05 * n, rest.shape)


class Question(NamedTuple):
    """What a kernel answers.

    `bytes` of a point are those of each array that the kernel reads or writes, once. `ask` takes an
    engine and a grid, in the simulator one of `shape`.
    """

    name: str
    kernel: str
    bytes: int
    ask: Callable
    shape: tuple[int, int, int] = _SHAPE


def questions(n, count=HANDLES):
    """Questions of kernels in a cube of n voxels."""
    from vtk_mls import Deformation, HalfPlane, Sampling

    def deformation(kind="rigid", **options):
        return Deformation(*handles(n, count), kind, device="reference", **options)

    cuts = [HalfPlane((n / 2, n / 2, n / 2), (0, 0, 1), (1, 0, 0))]
    maps = {
        "affine": deformation("affine"),
        "rigid": deformation(),
        "similarity": deformation("similarity"),
        "polynomial, degree 2": deformation("polynomial", degree=2),
        "polynomial, degree 3": deformation("polynomial", degree=3),
        "half-plane": deformation(cuts=cuts),
        "half-plane, paper's frame": deformation(cuts=cuts, cut_frame="deformed"),
    }
    for name, value in maps.items():
        size = 16 if value.cuts else 12  # with the void distance
        yield Question(f"map, {name}", "grid_displacement", size, _field(value))
    rest = np.full((2, 3), 0.3 * n)
    rest[1] = 0.6 * n
    gentle = Deformation(
        rest, rest + [[0, 0, 0], [0.01 * n, 0, 0]], map_tolerance=0.02, device="reference"
    )
    between = Question("map between nodes", "coarse_displacement", 12, _field(gentle), (32, 32, 32))
    yield between
    yield Question(
        *("Jacobian, rigid", "grid_jacobian", 36),
        lambda engine, grid: engine.jacobian_field(maps["rigid"], grid),
    )

    def sampled(method):
        return lambda engine, grid: engine.resample(
            maps["rigid"],
            [np.zeros(grid.shape, np.float32)],
            Sampling(grid, interpolation=method),
        )

    yield Question("origins of voxels, rigid", "grid_source_index", 12, sampled("nearest"))
    for method in ("nearest", "linear", "cubic"):
        yield Question(f"sampling of floats, {method}", "resample", 20, sampled(method))

    def covariant(engine, grid):
        vectors = np.zeros((*grid.shape, 3), np.float32)
        engine.resample(maps["rigid"], [vectors], Sampling(grid), covariant={0: False})

    yield Question("gradients at voxels, rigid, linear", "grid_source_index", 36, covariant)
    yield Question(
        *("differences of floats", "gradient", 16),
        lambda engine, grid: engine.gradient(np.zeros(grid.shape, np.float32), grid),
    )
    yield Question(
        *("void of cells by their corners", "void_by_corners", 5),
        lambda engine, grid: engine.void_by_corners(np.ones(grid.shape, np.float32), 1.0),
    )


def _field(value):
    return lambda engine, grid: engine.displacement_field(value, grid)


def counted():
    """Operations by name of the question: {"point", "pair"}; None without Oclgrind.

    Those for each point with `HANDLES` control points, and how many more another one costs.
    """
    if not (ENVIRONMENT / "made.stamp").exists():
        return None
    none = PROJECT / ".cache/operations"
    none.mkdir(parents=True, exist_ok=True)
    settings = {
        "OCL_ICD_VENDORS": str(none),  # no driver but the simulator
        "OCLGRIND_INST_COUNTS": "1",
        "XDG_CACHE_HOME": str(none),
        "PYTHONPATH": str(PROJECT),
    }
    ended = subprocess.run(
        [ENVIRONMENT / "bin/python", __file__],
        env={**os.environ, **settings},
        capture_output=True,
        text=True,
    )
    if ended.returncode != 0:
        raise RuntimeError(f"Oclgrind has counted nothing: {ended.stderr}")
    by_count = {HANDLES: {}, 2 * HANDLES: {}}
    for section in ended.stdout.split("=====")[1:]:
        heading, _, text = section.partition("\n")
        count, points, kernel, name = heading.strip().split(" ", 3)
        by_count[int(count)][name] = _operations(text, kernel) / int(points)
    few, many = by_count.values()
    return {name: {"point": few[name], "pair": (many[name] - few[name]) / HANDLES} for name in few}


def _operations(text, kernel):
    """Operations in what Oclgrind has told of a kernel's launches."""
    total, counts = 0, False
    for line in text.splitlines():
        if launched := _KERNEL.match(line):
            counts = launched[1] == kernel
        elif counts and (told := _LINE.match(line)):
            each = 2 if _TWO.match(told[2]) else 1 if _ONE.match(told[2]) else 0
            total += each * int(told[1])
    return total


def _run_all():
    """Ask all questions; Oclgrind tells of each launch between the names."""
    from vtk_mls import Grid
    from vtk_mls.engine.device import devices as device
    from vtk_mls.engine.opencl_engine import Engine

    (found,) = device.list_devices()
    engine, flush = Engine(dataclasses.replace(found, width=1)), ctypes.CDLL(None).fflush
    n = 64
    for count in (HANDLES, 2 * HANDLES):
        for question in questions(n, count):
            grid = Grid(question.shape, spacing=[(n - 1) / (a - 1) for a in question.shape])
            print(f"===== {count} {grid.size} {question.kernel} {question.name}", flush=True)
            question.ask(engine, grid)
            flush(None)


if __name__ == "__main__":
    _run_all()
