"""Compares the kernels on a device with the numpy reference; runs in a child process.

The child writes JSON lines that begin with `MARK` for its parent (`device_check`): the "step" that
begins, and at the end "uncheckable" or "failure" with a sentence, or the "speed".
"""

from __future__ import annotations

import dataclasses
import json
import time

import numpy as np

from vtk_mls import KINDS, Deformation, Grid, HalfPlane, Sampling
from vtk_mls.engine.device import devices as device
from vtk_mls.engine.device.device_check import MARK, description
from vtk_mls.engine.engine import Engine
from vtk_mls.reference import engine as reference

EXTENT = 40.0
_CUT = HalfPlane((20, 20, 20), (0.1, 0.2, 1), (1, 0.1, 0))
_GRID = Grid((19, 7, 5), spacing=(2.1, 5.7, 8.0))
_FINE_GRID = Grid((45, 42, 40), spacing=(1.0, 0.9, 1.1))
_SPEED_GRID = Grid((64, 64, 64), spacing=(0.6, 0.6, 0.6))


def main(folder, request):
    """Check a device.

    Parameters
    ----------
    folder : path
        Of the child; not used.
    request : dict
        "device", the `description` of a Device, and "lanes", points per work item.
    """
    try:
        found = _find(request["device"])
    except Exception as error:
        return _report(uncheckable=f"{type(error).__name__}: {error}")
    try:
        engine = Engine(dataclasses.replace(found, width=request["lanes"]))
        for step, errors in checks(engine):
            _report(step=step)
            error, bound = errors()
            if not error <= bound:  # NaN, too
                return _report(failure=f"it computes wrong numbers ({step}: off by {error:.2g})")
        _report(speed=speed(engine))
    except Exception as error:
        _report(failure=str(error))


def checks(engine):
    """Every kind, without cuts and with cuts in both frames, at points and on grids, images, slopes
    and the inverse.

    Yields
    ------
    step : str
    errors : callable
        Gives the distance from the specification, next to the extent or to 1, and a bound for it:
        far above what float32 rounds, and far below what a miscompiled kernel gives.
    """
    rng = np.random.default_rng(1)
    deformed = rng.uniform(0, EXTENT, (12, 3))
    rest = deformed + rng.normal(0, 1.5, (12, 3))
    points = np.concatenate([rng.uniform(0, EXTENT, (45, 3)), deformed[:4]])
    affine = Deformation(rest, deformed, "affine", device="reference")
    coarse = Deformation(*(rest[:6], deformed[:6], "affine"), map_tolerance=0.1, device="reference")
    polynomial, rigid = (
        Deformation(
            rest, deformed, kind, alpha=alpha, cuts=[_CUT], cut_frame="rest", device="reference"
        )
        for kind, alpha in (("polynomial", 2.0), ("rigid", 1.0))
    )
    similarity, staying = (
        Deformation(rest, deformed, kind, cuts=[_CUT], cut_frame="deformed", device="reference")
        for kind in ("similarity", "rigid")
    )

    others = [
        Deformation(rest, deformed, kind, device="reference")
        for kind in KINDS
        if kind not in {d.kind for d in (affine, similarity, polynomial, rigid)}
    ]

    def at_points(d):
        return np.abs(engine.backward(d, points) - d.backward(points)).max() / EXTENT

    def on_grid(d, grid=_GRID):
        pairs = zip(engine.displacement_field(d, grid), reference.displacement_field(d, grid))
        return max(_most(np.abs(a - b)) for a, b in pairs if a is not None) / EXTENT

    def of_slopes():
        return _most(np.abs(engine.jacobian(rigid, points) - rigid.jacobian(points)))

    def of_images():
        image = np.sin(_GRID.points() @ [0.1, 0.07, 0.05]).reshape(_GRID.shape)
        images = [image.astype(np.float32), *([image] if engine.device.has_float64 else [])]
        question = rigid, images, Sampling(_GRID, background=-1.0)
        pairs = [*zip(engine.resample(*question), reference.resample(*question))]
        pairs += [[each.gradient(images[0], _GRID) for each in (engine, reference)]]
        heights = (_FINE_GRID.points() @ [0.5, 0.3, 0.8] - 30).reshape(_FINE_GRID.shape)
        told = [each.void_by_corners(np.float32(heights), 2.0) for each in (engine, reference)]
        pairs.append(np.float32(told))
        return max(_most(np.abs(a - b)) for a, b in pairs)

    def of_the_inverse(d):
        origins = d.backward(points[~d.void(points)])
        displacement, found = engine.forward(d, origins)
        back = d.backward((origins + displacement)[found])
        return _most(np.abs(back - origins[found])) / EXTENT if found.mean() > 0.9 else np.nan

    yield "affine map at points", lambda: (at_points(affine), 1e-5)
    yield "polynomial map on a grid, cut", lambda: (on_grid(polynomial), 1e-4)
    yield "affine map between nodes", lambda: (on_grid(coarse, _FINE_GRID), 0.1 / EXTENT)
    yield "rigid Jacobian, cut", lambda: (of_slopes(), 1e-3)
    yield "images, rigid, cut", lambda: (of_images(), 1e-3)
    yield "rigid inverse, cut", lambda: (of_the_inverse(rigid), 1e-4)
    yield "similarity map on a grid, cut that stays", lambda: (on_grid(similarity), 1e-5)
    yield "rigid inverse, cut that stays", lambda: (of_the_inverse(staying), 1e-4)
    for other in others:
        yield f"{other.kind} map at points", lambda d=other: (at_points(d), 1e-5)


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


def _most(errors):
    """The largest of 95 % of `errors`, or NaN if one of all is.

    Next to a cut rounding decides on which side a point lies.
    """
    return np.nan if np.isnan(errors).any() else np.percentile(errors, 95)


def _find(requested):
    devices = [d for d in device.list_devices() if description(d) == requested]
    if not devices:
        raise LookupError("the device is not there in a process of its own")
    return devices[0]


def _report(**message):
    print(MARK + json.dumps(message), flush=True)
