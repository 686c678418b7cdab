"""Deforms an OME-Zarr on disk by the command.

Reports the largest memory, and the throughput against copying the files and deforming in memory.
"""

from __future__ import annotations

import concurrent.futures
import contextlib
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import zarr

from vtk_mls import Deformation
from vtk_mls.blocks.image_blocks import DeformedBlocks
from vtk_mls.blocks.unfinished import copy_metadata
from vtk_mls.files.ome_zarr import open_image, read, write

PROJECT = Path(__file__).resolve().parents[2]
CHUNK, LEVELS, THREADS = 128, 4, 2
COMMAND = [sys.executable, "-m", "vtk_mls", "deform"]
SPACING = 0.5  # micrometer


def make(path, size):
    """Write an image of `size` (nx, ny, nz): a slope, waves and noise."""
    rng = np.random.default_rng(0)
    shape, datasets = np.array(size[::-1]), []
    file = zarr.open_group(path, mode="w", zarr_format=3)
    for number in range(LEVELS):
        codec = zarr.codecs.BloscCodec(cname="zstd", clevel=1, shuffle="shuffle")
        array = file.create_array(
            str(number),
            shape=-(-shape // 2**number),
            chunks=tuple(int(n) for n in np.minimum(CHUNK, -(-shape // 2**number))),
            dtype="uint16",
            compressors=codec,
            dimension_names=list("zyx"),
        )
        scale = {"type": "scale", "scale": [SPACING * 2.0**number] * 3}
        shift = {"type": "translation", "translation": [SPACING * (2.0**number - 1) / 2] * 3}
        datasets.append({"path": str(number), "coordinateTransformations": [scale, shift]})
        if number == 0:
            for low in range(0, shape[0], CHUNK):
                z, y, x = np.ogrid[low : min(low + CHUNK, shape[0]), : shape[1], : shape[2]]
                slope = 8 * x + 4000 * np.sin(y / 40) * np.cos(z / 30) + 20000
                noise = rng.integers(0, 64, slope.shape, dtype="uint16")
                array[low : low + CHUNK] = slope.astype("uint16") + noise
    axes = [{"name": name, "type": "space", "unit": "micrometer"} for name in "zyx"]
    multiscale = {"name": "large", "axes": axes, "datasets": datasets}
    file.attrs["ome"] = {"version": "0.5", "multiscales": [multiscale]}


def handles(size):
    """p and q, (20, 6), over the image: moves by some percent of its size."""
    rng, extent = np.random.default_rng(1), SPACING * np.array(size)
    p = rng.uniform(0, extent, (20, 3))
    return np.hstack([p, p + rng.normal(0, 0.02, p.shape) * extent.max()])


def start(source, target, *options):
    command = [*COMMAND, source, "handles.csv", target, *options]
    return subprocess.Popen(command, start_new_session=True, stdout=subprocess.DEVNULL)


def copy(source, target):
    """Read and write all resolutions in the blocks of the command; seconds."""
    begin, image = time.perf_counter(), open_image(source)
    copy_metadata(Path(source), Path(target), [level.path for level in image.levels])
    blocks = DeformedBlocks(Path(source), Path(target), None)

    def one(stage, first):
        old, new = (part.levels[stage].array for part in (blocks._input, blocks._output))
        stops = np.minimum(np.add(first, blocks._shape(stage)), new.shape).tolist()
        place = tuple(map(slice, first, stops))
        write(new, place, read(old, place))

    tasks = [(stage, first) for stage in range(blocks.stages) for first in blocks.starts(stage)]
    with concurrent.futures.ThreadPoolExecutor(THREADS) as threads:
        list(threads.map(one, *zip(*tasks)))
    return time.perf_counter() - begin


def in_memory(source, d):
    """Seconds of `Deformation.resample` of the finest resolution."""
    level = open_image(source).finest
    values = level.array[...]
    begin = time.perf_counter()
    d.resample([values], level.grid)
    return time.perf_counter() - begin


def prepare(size):
    """Make the image and its handles in the current folder; the Deformation."""
    paths = [str(PROJECT), *filter(None, [os.environ.get("PYTHONPATH")])]
    os.environ["PYTHONPATH"] = os.pathsep.join(paths)
    # a process of its own: a command would inherit its peak of memory
    maker = multiprocessing.Process(target=make, args=("in.ome.zarr", size))
    maker.start()
    maker.join()
    points = handles(size)
    np.savetxt("handles.csv", points, delimiter=",", fmt="%.17g")
    start("in.ome.zarr", "small-test.vti", "--help").wait()  # imports are in the disk's cache
    return Deformation(*np.hsplit(points, 2), kind="rigid")


def table(size):
    """Rows for a table of `make bench`.

    Throughput: the time to copy the files and to deform in memory, over that of the command.
    """
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        d = prepare(size)
        begin = time.perf_counter()
        _, status, usage = os.wait4(start("in.ome.zarr", "out.ome.zarr").pid, 0)
        assert status == 0
        seconds = time.perf_counter() - begin
        copying, resampling = copy("in.ome.zarr", "copy.ome.zarr"), in_memory("in.ome.zarr", d)
    row = {
        "by the command, s": seconds,
        "read and written, s": copying,
        "deformed in memory, s": resampling,
        "throughput": (copying + resampling) / seconds,
        "memory, GiB": usage.ru_maxrss / 2**20,
    }
    return {" x ".join(map(str, size)): row}
