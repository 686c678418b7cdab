"""Devices, tolerances and sets of control points for all tests."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vtk_mls import KINDS, Deformation
from vtk_mls.engine.device import device_check, drivers
from vtk_mls.engine.device.devices import list_devices
from vtk_mls.engine.device.quirks import POCL

EXTENT = 256.0  # all errors are in voxels of a grid of this size

# Largest and 99th-percentile error of an engine against the specification, in voxels of 256.
TOLERANCE = {
    ("affine", 1): (2e-4, 1e-4),
    ("rigid", 1): (2e-4, 1e-4),
    ("similarity", 1): (2e-4, 1e-4),
    ("polynomial", 1): (2e-4, 1e-4),
    ("polynomial", 2): (2e-3, 1e-3),
    ("polynomial", 3): (2e-2, 5e-3),
}
for _kind in KINDS:
    TOLERANCE.setdefault((_kind, 1), (2e-4, 1e-4))
# the polynomial kind of degree 1 runs what the affine kind does: one test says so
KINDS_AND_DEGREES = sorted(
    (pair for pair in TOLERANCE if pair != ("polynomial", 1)), key=lambda pair: pair[0] != "rigid"
)

# Build constants of a kernel of no map.
LOCAL_POINTS = (("LANES", 1), ("VALUE", "float"))


def _sound_devices():
    """Devices that compute right, the fastest drivers first; a process can use one PoCL only."""
    found = list_devices()
    results = dict(zip(found, device_check.results(found)))
    sound = [d for d in found if not results[d].failure]
    sound.sort(key=lambda d: drivers.rank(d.platform))
    pocl = next((d.key.partition(":")[0] for d in sound if d.platform == POCL), None)
    return [d for d in sound if d.platform != POCL or d.key.partition(":")[0] == pocl]


# Keys of the devices that are tested thoroughly, the default of each kind, and of the others. What
# tests of filters and programs build is then built once.
DEVICES = list({d.kind: d.key for d in reversed(_sound_devices())}.values())
OTHER_DEVICES = [d.key for d in _sound_devices() if d.key not in DEVICES]
EVERYWHERE = ["reference", *DEVICES]


def random_rotation(rng):
    """A rotation matrix (3, 3)."""
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def random_handles(rng, count, shift=8.0):
    """Rest and deformed positions (count, 3) in a cube of `EXTENT`."""
    deformed = rng.uniform(0, EXTENT, (count, 3))
    return deformed + rng.normal(0, shift, (count, 3)), deformed


def _collinear(rng):
    t = rng.uniform(-100, 100, 6)
    deformed = 128 + np.outer(t, random_rotation(rng)[0])
    return deformed + rng.normal(0, 8, (6, 3)), deformed


def _near_a_line(rng):
    _, deformed = _collinear(rng)
    deformed = deformed + rng.normal(0, 2, deformed.shape)
    return deformed + 8 * np.sin(deformed / 50)[:, [1, 2, 0]], deformed


def _collinear_rest(rng):
    rest, deformed = _collinear(rng)
    return deformed, rest


def _reversed_line(rng):
    t = np.outer(np.linspace(-100, 100, 5), random_rotation(rng)[0])
    return 128 - t, 128 + t


def _coplanar(rng):
    rest, deformed = random_handles(rng, 12)
    flat = random_rotation(rng) * [[1], [1], [0]]
    return 128 + (rest - 128) @ flat, 128 + (deformed - 128) @ flat


def _coincident(rng):
    rest, deformed = random_handles(rng, 10)
    return rest, deformed[[0, 0, 1, 1, 1, 2, 3, 4, 5, 6]]


def _half_turn(rng):
    rest, deformed = random_handles(rng, 12, 2)
    axis = random_rotation(rng)[0]
    return 128 + (rest - 128) @ (2 * np.outer(axis, axis) - np.eye(3)), deformed


def _reflection(rng):
    rest, deformed = random_handles(rng, 12, 2)
    return [256, 0, 0] + rest * [-1, 1, 1], deformed


def _on_grid(rng):
    rest, deformed = random_handles(rng, 12)
    return rest, np.unique(np.round(deformed), axis=0)


def _surveyed(rng):
    rest, deformed = random_handles(rng, 12)
    return rest + 5e5, deformed + 5e5


def _molecular(rng):
    rest, deformed = random_handles(rng, 12)
    return rest * 1e-11, deformed * 1e-11


# Sets that break careless implementations.
HARD_SETS = {
    "one": lambda rng: random_handles(rng, 1),
    "two": lambda rng: random_handles(rng, 2),
    "three": lambda rng: random_handles(rng, 3),
    "four": lambda rng: random_handles(rng, 4),
    "collinear": _collinear,
    "near a line": _near_a_line,
    "collinear rest": _collinear_rest,
    "reversed line": _reversed_line,
    "coplanar": _coplanar,
    "coincident": _coincident,
    "half turn": _half_turn,
    "reflection": _reflection,
    "on grid points": _on_grid,
    "at 5e5": _surveyed,
    "at 1e-9": _molecular,
    "rest in one place": lambda rng: (np.full((5, 3), 100.0), random_handles(rng, 5)[1]),
    "two hundred": lambda rng: random_handles(rng, 200, 4),
    "ten thousand": lambda rng: random_handles(rng, 10_000, 2),
}


def places(rng, deformed, count=500):
    """Points (m, 3) all over the extent of `deformed`, and near and at control points."""
    low, high = deformed.min(axis=0), deformed.max(axis=0)
    size = max((high - low).max(), 1e-3 * np.abs(high).max())
    middle = (low + high) / 2
    everywhere = middle + size * rng.uniform(-0.6, 0.6, (count, 3))
    some = deformed[:: max(1, len(deformed) // 100)]
    near = [some + size * step * rng.normal(size=some.shape) for step in (1e-2, 1e-4, 1e-7)]
    return np.concatenate([everywhere, *near, some])


def deformation(rest, deformed, kind_and_degree, device="reference", **options):
    kind, degree = kind_and_degree
    return Deformation(rest, deformed, kind, degree=degree, device=device, **options)


def on_both(device, rest, deformed, kind_and_degree=("rigid", 1), **options):
    """The same deformation by the specification and by a device."""
    specification = deformation(rest, deformed, kind_and_degree, **options)
    return specification, replace(specification, device=device)


def block(first, dimensions):
    """Where a part of a grid lies in the arrays of the whole."""
    return tuple(slice(a, a + n) for a, n in zip(first[::-1], dimensions[::-1]))


def slopes(d, v, step=1e-6):
    """The Jacobian (m, 3, 3) of the backward map at `v` (m, 3), by differences."""
    pairs = ((d.backward(v + step * axis), d.backward(v - step * axis)) for axis in np.eye(3))
    return np.stack([(after - before) / (2 * step) for after, before in pairs], axis=2)
