"""Compares the kernels, built for one point per work item as on GPUs, with the specification.

    check_kernels.py PLATFORM [STEP ...]    on the first device of a platform

By default all steps but the `SLOW` ones, which take a simulator long and run the code of others for
another kind; with `all` as the step these, too.

Prints the error and time of each step; the status is 1 if an error exceeds its bound, or if the
simulator has written errors to its log (`OCLGRIND_LOG`). The simulator's compiler also compiles the
kernels of these steps with generic address spaces, as the compilers of OpenCL 3.0 do; it cannot run
them so.
"""

from __future__ import annotations

import dataclasses
import os
import sys
import time
from functools import partial
from itertools import product
from pathlib import Path

import handle_scenes
import numpy as np

from vtk_mls import Deformation, Grid, HalfPlane, Plane, Sampling, Surface
from vtk_mls.engine.device import devices as device
from vtk_mls.engine.device import quirks
from vtk_mls.engine.opencl_engine import Engine
from vtk_mls.reference import reference_engine as reference

EXTENT = 40.0
BOUND = 1e-4
SIMULATOR = "Oclgrind"
CPU_LANES = 16
INVERTED = 6  # points of an inverse: a simulator takes seconds for each
GRID = Grid((7, 6, 4), spacing=(6.5, 7.0, 12.0))
FINE_GRID = Grid((20, 20, 20), spacing=(2.0, 2.0, 2.0))
STEPS_GRID = Grid((16, 16, 16), spacing=(2.5, 2.5, 2.5))
CUTS = {
    "no cut": [],
    "plane": [Plane((20, 20, 20), (0.2, 1, 0.1))],
    "half-plane": [HalfPlane((20, 20, 20), (0.1, 0.2, 1), (1, 0.1, 0))],
    "surface": [Surface.polygon([(8, 9, 20), (33, 10, 21), (31, 32, 20), (9, 30, 19)])],
}
KINDS = {"affine": 1.0, "rigid": 1.0, "similarity": 1.3, "polynomial": 1.0}  # and their alpha
SLOW = [
    *(f"{kind}, half-plane: grid" for kind in KINDS if kind != "rigid"),
    *(f"{kind}, half-plane: inverse" for kind in KINDS if kind != "rigid"),
    "similarity, no cut: inverse",
    "similarity, plane that stays: inverse",
    "polynomial, no cut: inverse",
    "affine, surface that stays: inverse",
]
RNG = np.random.default_rng(1)
DEFORMED = RNG.uniform(0, EXTENT, (12, 3))
REST = DEFORMED + RNG.normal(0, 1.5, (12, 3))
POINTS = np.concatenate([RNG.uniform(0, EXTENT, (30, 3)), DEFORMED[:3]])


def steps(engine):
    """Names of steps, and functions that return errors relative to the extent or to 1."""
    compare = partial(partial, difference, engine)

    def ask(name, d, *questions):
        """Steps for a deformation, or for some of these questions."""
        smooth = POINTS[:30] if d.kind == "spline" else POINTS  # r has no slope at a cone
        answers = {
            "points": compare(EXTENT, "backward", d, POINTS),
            "slopes": compare(1, "jacobian", d, smooth),
            "grid": compare(EXTENT, "displacement_field", d, GRID),
            "inverse": partial(inverse, engine, d),
        }
        return [(f"{name}: {question}", answers[question]) for question in questions or answers]

    yield from map_steps(ask)
    listed = np.arange(1, GRID.size, 3)
    arguments = deformation("rigid", "half-plane"), GRID, listed
    yield "rigid, half-plane: listed points", compare(EXTENT, "void_distance_listed", *arguments)
    yield from node_steps(compare)
    yield from image_steps(engine, compare)


def map_steps(ask):
    """Every kind with every cut, in both frames; splines in float and in double; other handles."""
    for kind in KINDS:
        for cut in CUTS:
            only = () if cut in ("no cut", "half-plane") else ["points"]
            yield from ask(f"{kind}, {cut}", deformation(kind, cut), *only)
    for kind, cut in zip(KINDS, ("surface", "half-plane", "plane", "surface")):
        d = deformation(kind, cut, "deformed")
        yield from ask(f"{kind}, {cut} that stays", d, "points", "slopes", "inverse")
    for order, noise in ((1, 0), (2, 0), (3, 0), (3, 9.0)):
        rest = REST + noise * RNG.normal(size=REST.shape)
        d = Deformation(rest, DEFORMED, "spline", order=order, device="reference")
        only = () if order == 3 and noise == 0 else ("points", "slopes")
        yield from ask(f"spline of order {order}{', in double' * (noise > 0)}", d, *only)
    for name, d in handle_scenes.scenes(REST, DEFORMED).items():
        only = ("points", "slopes") if d.degree < 3 else ["points"]  # less exact
        yield from ask(name, d, *(() if name == "rigid, shapes and other limits" else only))


def node_steps(compare):
    """Maps within a tolerance."""
    gentle = DEFORMED + 0.01 * (REST - DEFORMED)
    settings = {"kind": "affine", "map_tolerance": 0.005, "device": "reference"}
    d = Deformation(gentle[:2], DEFORMED[:2], **settings)
    yield "affine, between nodes", compare(EXTENT, "displacement_field", d, FINE_GRID)
    # cells at control points get nodes that are closer
    corners, moved = np.array([(0.0, 0, 0), (EXTENT,) * 3]), np.array([(0.6, 0, 0.3), (0, 0.4, 0)])
    d = Deformation(corners + moved, corners, steps=4, **settings)
    yield "affine, 4 steps, between nodes", compare(EXTENT, "displacement_field", d, STEPS_GRID)


def image_steps(engine, compare):
    """Images, vectors, and what is computed from images."""
    image = np.sin(GRID.points() @ [0.1, 0.07, 0.05]).reshape(GRID.shape)
    types = (np.float32, np.float64, np.uint8) if engine.device.has_float64 else (np.float32,)
    images = [(image * (100 if type_ is np.uint8 else 1)).astype(type_) for type_ in types]
    d = deformation("affine", "plane")
    for method in ("nearest", "linear", "cubic"):
        sampling = Sampling(GRID, interpolation=method, background=-1.0)
        yield f"images, {method}", compare(100, "resample", d, images, sampling)
    d = deformation("rigid", "half-plane")
    vectors = np.random.default_rng(2).normal(size=(*GRID.shape, 3)).astype(np.float32)
    arguments = d, [vectors], Sampling(GRID)
    yield "vectors that turn", compare(5, "resample", *arguments, covariant={0: False})
    yield "gradient of an image", compare(1, "gradient", images[0], GRID)
    heights = (FINE_GRID.points() @ [0.5, 0.3, 0.8] - 30).reshape(FINE_GRID.shape)
    yield "void of cells", compare(1, "void_by_corners", heights.astype(np.float32), 2.0)
    field = reference.displacement_field(d, FINE_GRID)[0]
    yield "voxels that may fold", compare(1, "doubtful_voxels", field, FINE_GRID.index_to_world)
    yield "slopes on a grid", compare(1, "jacobian_field", d, GRID)


def deformation(kind, cut, cut_frame="rest"):
    """A deformation by 12 points with one of the `CUTS`."""
    options = {"alpha": KINDS[kind], "cuts": CUTS[cut], "cut_frame": cut_frame}
    return Deformation(REST, DEFORMED, kind, device="reference", **options)


def difference(engine, unit, method, *arguments, **options):
    """Differences between results of the kernels and of the specification, in a unit."""
    results = [getattr(module, method)(*arguments, **options) for module in (engine, reference)]
    if isinstance(results[0], np.ndarray):
        results = [[result] for result in results]
    pairs = [(np.asarray(a, float), b) for a, b in zip(*results) if a is not None]
    return np.concatenate([np.abs(a - b).ravel() for a, b in pairs]) / unit


def inverse(engine, d):
    """The largest error of points mapped there and back, and the share without an image."""
    origins = d.backward(POINTS[~d.void(POINTS)][:INVERTED])
    displacement, found = engine.forward(d, origins)
    back = d.backward((origins + displacement)[found])
    return [np.abs(back - origins[found]).max() / EXTENT, 1 - found.mean()]


def worst(name, errors):
    """The largest error except for a few: at cuts and midway between voxels rounding decides."""
    return np.percentile(errors, 90 if "nearest" in name else 97)


def record_sources(recorded):
    """Add the arguments of each kernel's source to the set `recorded`, when it is built."""
    source = device.source

    def recorded_source(file, constants=()):
        recorded.add((file, constants))
        return source(file, constants)

    device.source = recorded_source


def compile_generic(chosen, recorded):
    """Compile kernels with generic address spaces, as for GPUs and for CPUs; how many do not."""
    import pyopencl as cl

    wrong, start = 0, time.monotonic()
    for (file, constants), lanes in product(sorted(recorded, key=str), (1, CPU_LANES)):
        macros = tuple((dict(constants) | {"LANES": lanes}).items())
        program = cl.Program(device.context(chosen), device.source(file, macros))
        try:
            options = ["-w", "-cl-std=CL2.0", *quirks.options(chosen)]
            program.build(options, cache_dir=False)
        except cl.Error as error:
            wrong += 1
            print(f"WRONG {file}, {macros}: {error}"[:1000])
    seconds = time.monotonic() - start
    print(f"{2 * len(recorded)} kernels compiled with generic address spaces {seconds:6.1f} s")
    return wrong


def main(platform, *selected):
    found = [d for d in device.list_devices() if d.platform == platform]
    if not found:
        print(f"no device of the platform {platform}: {device.list_devices()}")
        return 1
    engine = Engine(dataclasses.replace(found[0], width=1))
    print(f"{found[0]}, {found[0].driver}")
    wrong, recorded = 0, set()
    record_sources(recorded)
    for name, errors in steps(engine):
        is_left_out = name not in selected if selected else name in SLOW
        if is_left_out and selected != ("all",):
            continue
        start = time.monotonic()
        error = worst(name, errors())
        is_right = error <= BOUND
        wrong += not is_right
        seconds = time.monotonic() - start
        result = "ok   " if is_right else "WRONG"
        print(f"{result} {name:40s} {error:8.1e} {seconds:6.1f} s", flush=True)
    if platform == SIMULATOR:
        wrong += compile_generic(found[0], recorded.copy())
    log = os.environ.get("OCLGRIND_LOG")
    if log and Path(log).exists() and (errors := Path(log).read_text().strip()):
        print(errors[:3000])
        wrong += 1
    return wrong > 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
