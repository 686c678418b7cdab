"""The error of the kernels against the float64 specification, as tables for docs/accuracy.md.

python tests/benchmarks/accuracy.py            # of the fastest device
python tests/benchmarks/accuracy.py 0:1        # of another one
"""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from control_point_sets import (
    EXTENT,
    HARD_SETS,
    TOLERANCE,
    deformation,
    places,
    random_handles,
)

from vtk_mls import Deformation
from vtk_mls.engine import dispatch
from vtk_mls.engine.device.devices import Device
from vtk_mls.engine.opencl_engine import Engine
from vtk_mls.model.kinds.splines import ORDERS
from vtk_mls.model.options import ALPHA
from vtk_mls.reference import reference_engine as reference

COLUMNS = [pair for pair in TOLERANCE if pair != ("polynomial", 1)]
SPLINES = {**{f"order {order}": (order, 0) for order in ORDERS}, "softened": (1, 0.5)}
ALPHAS = (0.5, 1.0, 1.5, 2.0, 3.0)
SETS = {"15 at random": lambda rng: random_handles(rng, 15), **HARD_SETS}
HEAD = """# Accuracy

Kernels compute in float32, in coordinates scaled to the control points. Sums lose digits where a
few control points outweigh all others. With alpha above 1, displacements whose estimated loss is
too large take one step of iterative refinement, and sum in float64 where that does not suffice, or
where there are curves or rigid regions. Maps of degree 3 always sum in float64. The default alpha
is 2. Smoothing does not change the errors. Splines sum in float64 where their coefficients are so
large that rounding could be seen; numpy computes those that a device without float64 cannot.

As a fraction of the extent of the control points, the largest error is 1e-6 with 15 random
control points, and 1.1e-5 in the hardest set at alpha 2. Some devices lack float64. There,
degree 3 has 4e-4 at alpha 2. At alpha 3, the errors are 7e-5 for affine maps, 3e-3 for degree 2,
and a quarter for degree 3. These last two are visible.

The tables list the largest error of a displacement, compared with the specification in float64.
The unit is **a thousandth of a voxel of a volume of 256^3** that the control points fill. The
error is taken at 500 points in the volume, and at and next to control points. `make accuracy`
made the tables on {device}. `tests/control_point_sets.py` defines the sets.
"""


def main(arguments):
    engine = dispatch.engine_for(*arguments[:1])
    if engine is reference:
        sys.exit("there is no OpenCL device whose error could be measured")
    print(HEAD.format(device=engine.device.name))
    print(f"## Each set, alpha {ALPHA.default:g}\n")
    _print_table("set", SETS, lambda name, kind: error(engine, name, kind, ALPHA.default))
    names = [name for name in SETS if name != "ten thousand"]  # more than a spline can have
    for title, one in (("With float64", engine), ("Without float64", _without_double(engine))):
        print(f"\n## {title}: splines\n")
        _print_table(
            "set", names, lambda name, k, one=one: spline_error(one, name, *SPLINES[k]), SPLINES
        )
    for title, one in (("With float64", engine), ("Without float64", _without_double(engine))):
        print(f"\n## {title}: each alpha, 15 control points at random\n")
        _print_table("alpha", ALPHAS, lambda a, kind, one=one: error(one, "15 at random", kind, a))


def error(engine, name, kind_and_degree, alpha):
    """The largest error for a set, in voxels of 256."""
    return _error(engine, name, partial(deformation, kind_and_degree=kind_and_degree, alpha=alpha))


def spline_error(engine, name, order, softening):
    """The same of a spline, with a softening in extents of the set."""

    def make(rest, deformed):
        length = softening * np.ptp(deformed, axis=0).max()
        return Deformation(rest, deformed, "spline", order=order, softening=length)

    return _error(engine, name, make)


def _error(engine, name, make):
    rng = np.random.default_rng(20240229)
    rest, deformed = SETS[name](rng)
    x = places(rng, deformed)
    d = make(rest, deformed)
    points = d.regions[0].control_points
    if not engine.device.has_float64 and points.kind.is_wrong_in_float32(points):
        return np.nan
    size = max(np.ptp(deformed, axis=0).max(), 1e-3 * np.abs(deformed).max())
    apart = np.abs(engine.backward(d, x) - reference.backward(d, x)).max()
    return apart / size * EXTENT


class _NoDouble(Device):
    has_float64 = False


def _without_double(engine):
    """The engine of a device that cannot compute in double."""
    fields = {name: getattr(engine.device, name) for name in engine.device.__dataclass_fields__}
    return Engine(replace(_NoDouble(**fields)))


def _print_table(corner, rows, value, columns=COLUMNS):
    names = [*columns]
    if columns is COLUMNS:
        names = [f"{kind} {degree}" if kind == "polynomial" else kind for kind, degree in COLUMNS]
    print(f"| {corner} | " + " | ".join(names) + " |")
    print("|---" * (len(names) + 1) + "|")
    for row in rows:
        values = [value(row, kind) for kind in columns]
        print(f"| {row} | " + " | ".join(_text(value) for value in values) + " |", flush=True)


def _text(voxels):
    return "numpy" if np.isnan(voxels) else f"{float(f'{1000 * voxels:.2g}'):g}"


if __name__ == "__main__":
    main(sys.argv[1:])
