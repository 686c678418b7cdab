"""The settings of a map that a report compares, and how well each predicts pairs left out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vtk_mls.model.kinds.polynomials import MONOMIAL_COUNT

# Tried without smoothing, then the best kinds with smoothing, in the typical spacing of pairs.
_KINDS = (
    ("rigid", None),
    ("similarity", None),
    ("affine", None),
    ("polynomial", 2),
    ("polynomial", 3),
)
_ALPHAS = 1.0, 2.0, 3.0, 4.0
# For the highest degree: with 2,000 exact pairs, alpha 6 has 0.35 times the error of alpha 4. With
# alpha 8 it is a little smaller, but weights in float32 no longer suffice everywhere.
_LOCAL_ALPHAS = (6.0,)
_SMOOTHINGS = 1.0, 2.0
_BEST_KINDS = 2
_WHOLE_SMOOTHING = 100.0  # extents of the pairs, with which all weigh alike to 1e-4
# Pairs for each function of a polynomial map; with fewer, the map is not tried.
_PAIRS_PER_FUNCTION = 2
_MIN_AFFINE_PAIRS = 5


@dataclass(frozen=True)
class Settings:
    """Settings of a `Deformation`.

    Attributes
    ----------
    kind : str
    degree : int or None
        None for kinds without one.
    alpha, smoothing : float
        With alpha 0 all pairs weigh alike: one map for all.
    """

    kind: str
    degree: int | None
    alpha: float
    smoothing: float = 0.0

    @property
    def options(self) -> dict[str, Any]:
        """Keyword arguments of `Deformation`."""
        return {name: getattr(self, name) for name in self._names}

    @property
    def flags(self) -> str:
        """Options of `vtk-mls deform`."""
        values = ((name, getattr(self, name)) for name in self._names)
        texts = ((name, v if isinstance(v, str) else f"{v:.4g}") for name, v in values)
        return " ".join(f"--{name} {text}" for name, text in texts)

    @property
    def _names(self):
        names = ["kind", "degree", "alpha", "smoothing"]
        return [name for name in names if getattr(self, name) not in (None, 0)]


BASELINE = {kind: Settings(kind, None, 0.0) for kind in ("rigid", "affine")}


def without_smoothing(count: int) -> list[Settings]:
    """Settings to try for `count` pairs, the simplest first."""
    return [
        Settings(kind, degree, alpha)
        for kind, degree in _KINDS
        if count >= _min_pairs(kind, degree)
        for alpha in _ALPHAS + (_LOCAL_ALPHAS if degree == 3 else ())
    ]


def with_smoothing(medians: dict[Settings, float], spacing: float) -> list[Settings]:
    """The best kinds of those tried, with smoothing.

    `medians` are those of the settings tried without smoothing, `spacing` is the typical distance
    of a pair to the nearest, world units.
    """
    kinds = dict.fromkeys((s.kind, s.degree) for s in sorted(medians, key=medians.__getitem__))
    # three digits are easy to type, and more have no effect
    lengths = [float(f"{factor * spacing:.3g}") for factor in _SMOOTHINGS]
    return [
        Settings(kind, degree, alpha, length)
        for kind, degree in list(kinds)[:_BEST_KINDS]
        for alpha in _ALPHAS
        for length in lengths
    ]


def whole_motions(extent: float) -> list[Settings]:
    """Settings for nearly one motion of all pairs, whose largest `extent` is in world units."""
    smoothing = float(f"{_WHOLE_SMOOTHING * extent:.3g}")
    return [Settings(kind, None, 1.0, smoothing) for kind in ("rigid", "similarity")]


def spacing_of(points: NDArray[np.float64]) -> float:
    """Median distance of points (n, 3) to the nearest other point, from up to 500 of them."""
    nearest = []
    for point in points[:: -(-len(points) // 500)]:
        distance = np.linalg.norm(points - point, axis=1)
        nearest.append(distance[distance > 0].min())
    return float(np.median(nearest))


def _min_pairs(kind, degree):
    if degree is None:
        return _MIN_AFFINE_PAIRS if kind == "affine" else 0
    return _PAIRS_PER_FUNCTION * (MONOMIAL_COUNT[degree] + 1)
