"""Compares the kernels on a device with the numpy reference; runs in a child process.

The child writes JSON lines that begin with `MARK` for its parent (`device_check`): the "step" that
begins, and at the end "failure" with a sentence, or the "speed". An exception before the first step
is not the fault of the device.
"""

from __future__ import annotations

import dataclasses
import json
import time

import numpy as np

from vtk_mls import KINDS, Deformation, Grid, HalfPlane, Sampling
from vtk_mls.engine.device import devices
from vtk_mls.engine.device.device_check import MARK, description
from vtk_mls.engine.opencl_engine import Engine
from vtk_mls.reference import reference_engine as reference

EXTENT = 40.0
_CUT = HalfPlane((20, 20, 20), (0.1, 0.2, 1), (1, 0.1, 0))
_GRID = Grid((19, 7, 5), spacing=(2.1, 5.7, 8.0))
_FINE_GRID = Grid((33, 30, 30), spacing=(1.25, 1.3, 1.4))
_SPEED_GRID = Grid((64, 64, 64), spacing=(0.6, 0.6, 0.6))


def main(folder, request):
    """Check a device, or a part of it.

    Parameters
    ----------
    folder : path
        Of the child; not used.
    request : dict
        "device", the `description` of a Device; "lanes", points per work item; and "part" (2,):
        the first check of this child, and the number of children that share them.
    """
    device = _find(request["device"])
    _report(step="first use")
    engine = Engine(dataclasses.replace(device, width=request["lanes"]))
    first, children = request["part"]
    steps = checks(engine)
    own = steps[first::children]
    for step, errors in own:
        _report(step=step)
        error, bound = errors()
        if not error <= bound:  # NaN, too
            return _report(failure=f"it computes wrong numbers ({step}: off by {error:.2g})")
    has_kernel = steps[-1] in own  # the last check builds it, in one child
    _report(speed=speed(engine) if has_kernel else 0.0)


def checks(engine):
    """Every kind, cuts in both frames, points, grids, images, Jacobians and the inverse.

    The compiler takes almost all of the time, so each build checks several things, and no check is
    of a larger kernel than it needs. The order lets two children that share them end together.

    Returns
    -------
    list of (step, errors)
        `errors` returns the error relative to the extent or to 1, and its bound: far above rounding
        in float32, and far below the error of a miscompiled kernel.
    """
    rng = np.random.default_rng(1)
    deformed = rng.uniform(0, EXTENT, (12, 3))
    rest = deformed + rng.normal(0, 1.5, (12, 3))
    points = np.concatenate([rng.uniform(0, EXTENT, (45, 3)), deformed[:4]])
    coarse, polynomial, rigid, with_cut, fixed_cut, similarity, *others = _deformations(
        rest, deformed
    )

    def point_error(d):
        return np.abs(engine.backward(d, points) - d.backward(points)).max() / EXTENT

    def grid_error(d, grid=_GRID):
        pairs = zip(engine.displacement_field(d, grid), reference.displacement_field(d, grid))
        return max(_largest(np.abs(a - b)) for a, b in pairs if a is not None) / EXTENT

    def jacobian_error():
        return _largest(np.abs(engine.jacobian(fixed_cut, points) - fixed_cut.jacobian(points)))

    def image_error():
        image = np.sin(_GRID.points() @ [0.1, 0.07, 0.05]).reshape(_GRID.shape)
        images = [image.astype(np.float32), *([image] if engine.device.has_float64 else [])]
        voids = np.empty((2, _GRID.size), np.float32)
        arguments = with_cut, images, Sampling(_GRID, background=-1.0)
        samples = [
            module.resample(*arguments, void_distance=void)
            for module, void in zip((engine, reference), voids)
        ]
        return max(_largest(np.abs(a - b)) for a, b in [*zip(*samples), voids / EXTENT])

    def inverse_error():
        origins = similarity.backward(points)
        displacement, has_image = engine.forward(similarity, origins)
        back = similarity.backward((origins + displacement)[has_image])
        if has_image.mean() <= 0.9:
            return np.nan
        return _largest(np.abs(back - origins[has_image])) / EXTENT

    return [
        ("similarity inverse", lambda: (inverse_error(), 1e-4)),
        ("images, rigid, cut", lambda: (image_error(), 1e-3)),
        ("rigid Jacobian, fixed cut", lambda: (jacobian_error(), 1e-3)),
        ("affine map between nodes", lambda: (grid_error(coarse, _FINE_GRID), 0.1 / EXTENT)),
        ("polynomial map at points", lambda: (point_error(polynomial), 1e-4)),
        ("gradient, void of cells", lambda: (_array_error(engine), 1e-3)),
        *((f"{d.kind} map at points", lambda d=d: (point_error(d), 1e-5)) for d in others),
        ("rigid map on a grid", lambda: (grid_error(rigid), 1e-5)),
    ]


def _array_error(engine):
    """Error of the gradient of an image, and of void cells."""
    values = np.float32(np.sin(_GRID.points() @ [0.1, 0.07, 0.05]).reshape(_GRID.shape))
    slopes = [module.gradient(values, _GRID) for module in (engine, reference)]
    heights = (_FINE_GRID.points() @ [0.5, 0.3, 0.8] - 30).reshape(_FINE_GRID.shape)
    flags = [module.void_by_corners(np.float32(heights), 2.0) for module in (engine, reference)]
    return max(_largest(np.abs(a - b)) for a, b in (slopes, np.float32(flags)))


def _deformations(rest, deformed):
    """An affine map within a tolerance, exact ones, two of them with a cut; and the kinds left.

    The affine one is summed in float, the polynomial one where needed in double.
    """
    few, cut = (rest[:6], deformed[:6]), {"cuts": [_CUT], "device": "reference"}
    maps = (
        Deformation(*few, "affine", alpha=1.0, map_tolerance=0.1, device="reference"),
        Deformation(rest, deformed, "polynomial", alpha=2.0, device="reference"),
        Deformation(rest, deformed, "rigid", device="reference"),
        Deformation(rest, deformed, "rigid", cut_frame="rest", **cut),
        Deformation(rest, deformed, "rigid", cut_frame="deformed", **cut),
        Deformation(rest, deformed, "similarity", device="reference"),
    )
    kinds_left = [kind for kind in KINDS if all(kind != d.kind for d in maps)]
    return *maps, *(Deformation(rest, deformed, kind, device="reference") for kind in kinds_left)


def speed(engine):
    """Points per second of a rigid map, 15 control points: the best of some launches."""
    rng = np.random.default_rng(2)
    deformed = rng.uniform(0, EXTENT, (15, 3))
    d = Deformation(deformed + rng.normal(0, 1, (15, 3)), deformed, device="reference")
    times = []
    for _ in range(6):
        start = time.perf_counter()
        engine.displacement_field(d, _SPEED_GRID)
        times.append(time.perf_counter() - start)
    return _SPEED_GRID.size / min(times)


def _largest(errors):
    """The 95th percentile of `errors`, or NaN if any is NaN.

    Near a cut rounding decides on which side a point lies.
    """
    return np.nan if np.isnan(errors).any() else np.percentile(errors, 95)


def _find(requested):
    matches = [device for device in devices.list_devices() if description(device) == requested]
    if not matches:
        raise LookupError("the child process does not find the device")
    return matches[0]


def _report(**message):
    print(MARK + json.dumps(message), flush=True)
