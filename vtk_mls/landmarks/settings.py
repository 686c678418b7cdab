"""The settings of a map that a report compares, and how well each predicts pairs left out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

# Smoothings in extents of the pairs, with which all weigh alike to 1e-4, and to 1e-12.
_WHOLE_SMOOTHING, _EXACTLY_WHOLE = 100.0, 1e6


@dataclass(frozen=True)
class Settings:
    """Settings of a `Deformation`.

    Attributes
    ----------
    kind : str
    degree : int or None
        None for kinds without one.
    alpha, smoothing : float
        With alpha 0 all pairs weigh alike: one map for all; and of a spline it has no meaning.
    order : int or None
        Of a spline.
    softening : float
        Of a spline.
    """

    kind: str
    degree: int | None
    alpha: float
    smoothing: float = 0.0
    order: int | None = None
    softening: float = 0.0

    @property
    def options(self) -> dict[str, Any]:
        """Keyword arguments of `Deformation`."""
        names = ["kind", "degree", "order", "alpha", "smoothing", "softening"]
        values = {name: getattr(self, name) for name in names}
        return {name: value for name, value in values.items() if value not in (None, 0)}

    @property
    def flags(self) -> str:
        """Options of `vtk-mls deform`."""
        values = self.options.items()
        texts = ((name, v if isinstance(v, str) else f"{v:.4g}") for name, v in values)
        return " ".join(f"--{name} {text}" for name, text in texts)


BASELINE = {kind: Settings(kind, None, 0.0) for kind in ("rigid", "affine")}


def one_map(kind: str, extent: float) -> Settings:
    """Settings with which a map of `BASELINE` is computed."""
    return Settings(kind, None, 1.0, _EXACTLY_WHOLE * extent)


def whole_motions(extent: float) -> list[Settings]:
    """Settings for nearly one motion of all pairs, whose largest `extent` is in world units."""
    smoothing = float(f"{_WHOLE_SMOOTHING * extent:.3g}")
    return [Settings(kind, None, 1.0, smoothing) for kind in ("rigid", "similarity")]
