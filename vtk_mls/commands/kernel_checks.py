"""Compares the kernels on a device with the numpy reference; runs in a child process."""

import os
import threading
import time
from functools import partial
from pathlib import Path

import numpy as np

from vtk_mls import Deformation, Grid, HalfPlane, Sampling
from vtk_mls.engine.device import device_check, devices
from vtk_mls.engine.opencl_engine import Engine
from vtk_mls.model.kinds import ALL_KINDS
from vtk_mls.reference import reference_engine as reference

EXTENT = 40.0
_CUT = HalfPlane((20, 20, 20), (0.1, 0.2, 1), (1, 0.1, 0))
_GRID = Grid((19, 7, 5), spacing=(2.1, 5.7, 8.0))
_FINE_GRID = Grid((33, 30, 30), spacing=(1.25, 1.3, 1.4))


def main(folder, requested, subject, part):
    """Do a part of the check of a subject on the device with the `description` requested.

    Writes the step that begins and the processor time to `folder`. An exception before the first
    step is not the fault of the device.
    """
    found = [
        device for device in devices.list_devices() if device_check.description(device) == requested
    ]
    if not found:
        raise LookupError("the child process does not find the device")
    threading.Thread(target=_count_seconds, args=(folder,), daemon=True).start()
    Path(folder, device_check.STEP).write_text("first use")
    engine = Engine(found[0])
    for step, results, bound in checks(engine)[subject][part :: device_check.PARTS]:
        Path(folder, device_check.STEP).write_text(step)
        off = error(engine, results)
        if not off <= bound:  # NaN, too
            raise ArithmeticError(f"wrong numbers, off by {off:.2g}")
    os._exit(0)  # drivers may crash or hang at the end


def _count_seconds(folder):
    with open(Path(folder, device_check.SECONDS), "w", buffering=1) as file:
        while True:
            file.write(f"{time.process_time()}\n")
            time.sleep(1)


def checks(engine):
    """The checks of each subject: the inverse, images, Jacobians; kinds; fields; cuts.

    The compiler takes almost all of the time, so each build checks several things, and no check is
    of a larger kernel than it needs. The first image and the search for folds of a filter find most
    of their kernels built. Two children take every other check, which take about the same time.

    A check is (step, results, bound): `results(module)` are the arrays that an engine or the
    reference computes, relative to the extent or to 1. `bound` is that of `error`: far above
    rounding in float32, and far below the error of a miscompiled kernel.
    """
    rng = np.random.default_rng(1)
    deformed = rng.uniform(0, EXTENT, (12, 3))
    rest = deformed + rng.normal(0, 1.5, (12, 3))
    points = np.concatenate([rng.uniform(0, EXTENT, (45, 3)), deformed[:4]])
    value = partial(Deformation, rest, deformed, device="reference")
    coarse = Deformation(rest[:6], deformed[:6], map_tolerance=0.1, device="reference")
    rigid = value()
    with_cut, fixed_cut = (value(cuts=_CUT, cut_frame=frame) for frame in ("rest", "deformed"))
    image = np.sin(_GRID.points() @ [0.1, 0.07, 0.05]).reshape(_GRID.shape)
    heights = (_FINE_GRID.points() @ [0.5, 0.3, 0.8] - 30).reshape(_FINE_GRID.shape)

    def inverse(module):
        origins = rigid.backward(points)
        displacement, has_image = module.forward(rigid, origins)
        back = rigid.backward(origins + displacement)
        return np.where(has_image[:, None], back, origins) / EXTENT, has_image

    def images(module):
        void = np.empty(_GRID.size, np.float32)
        arrays = [np.float32(image), *([image] if engine.device.has_float64 else [])]
        sampling = Sampling(_GRID, background=-1.0)
        return *module.resample(with_cut, arrays, sampling, void_distance=void), void / EXTENT

    def field(d, grid):
        return lambda module: [module.displacement_field(d, grid)[0] / EXTENT]

    def image_between_nodes(module):
        sampling = Sampling(_FINE_GRID, background=-1.0)
        return module.resample(coarse, [np.float32(heights / EXTENT)], sampling)

    def at_points(d):
        return lambda module: [module.backward(d, points) / EXTENT]

    def jacobian(d):
        return lambda module: [module.jacobian(d, points)]

    basic = [
        ("image between nodes", image_between_nodes, 0.1 / EXTENT),
        ("rigid inverse", inverse, 1e-4),
        ("rigid Jacobian", jacobian(rigid), 1e-3),
    ]
    fields = [
        ("gradient", lambda module: [module.gradient(np.float32(image), _GRID)], 1e-3),
        ("map between nodes", field(coarse, _FINE_GRID), 0.1 / EXTENT),
        ("map on a grid", field(rigid, _GRID), 1e-5),
    ]
    cuts = [
        ("images", images, 1e-3),
        ("Jacobian, fixed cut", jacobian(fixed_cut), 1e-3),
        ("void of cells", lambda module: [module.void_by_corners(np.float32(heights), 2.0)], 1e-3),
    ]
    bounds = {**dict.fromkeys(ALL_KINDS, 1e-5), "polynomial": 1e-4}
    kinds = {kind: [("map at points", at_points(value(kind)), bounds[kind])] for kind in ALL_KINDS}
    return kinds | {device_check.BASIC: basic, device_check.FIELDS: fields, device_check.CUTS: cuts}


def error(engine, results):
    """The largest error of arrays, up to 5 % of each, or NaN if any is NaN.

    Near a cut rounding decides on which side a point lies.
    """
    pairs = zip(results(engine), results(reference))
    errors = [np.abs(np.subtract(a, b, dtype=np.float64)) for a, b in pairs]
    return np.max([np.percentile(e, 95) for e in errors])
