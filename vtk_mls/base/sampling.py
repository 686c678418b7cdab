"""Where and how values on a grid are sampled through a deformation."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vtk_mls.base import interpolation, validation
from vtk_mls.base.grid import Grid, checked_grid
from vtk_mls.base.interpolation import INTERPOLATIONS
from vtk_mls.base.messages import warn
from vtk_mls.base.validation import short_repr

# What the void that a cut opens can hold: nothing, or material as if each side went on.
VOID_VALUES = ("background", "continued")
_MAX_LISTED = 4  # arrays in a warning


@dataclass(frozen=True)
class Sampling:
    """How the values of a deformed grid are found: from which points, for which, and by what rule.

    Parameters
    ----------
    source : Grid
        Where the values are. Of a part of a grid it is taken that values which it lacks are not
        needed: see `Deformation.source_bounds`.
    target : Grid, optional
        Where values are wanted; `source` if not given.
    interpolation : {"nearest", "linear", "cubic"} or a sequence with one for each array
        "cubic" is Catmull-Rom (Keys, a = -1/2).
    background : float
        Value of points whose material came from outside of `source` (by more than half a spacing),
        and of the void. Directions are 0 there. An array whose type does not have it gets the
        nearest value that the type has (integers 0 for NaN), with a warning.
    void_values : {"background", "continued"}
        What is in the void: `background`; or the values that the map of each side brings there, as
        if its material went on behind the face of the cut. Contours of these end sharp where they
        are clipped by the void distance.
    versions : sequence of hashable or None, one for each array, optional
        What tells an array's contents from all others, such as its modification time: devices with
        a memory of their own keep it there for the next question with an equal one. They keep no
        array whose version is None. numpy notes no changes: who writes into an array in place must
        give it another version.

    Raises
    ------
    ValueError, TypeError
        For a bad parameter, naming it.
    """

    source: Grid
    target: Grid = None
    interpolation: str | tuple[str, ...] = "linear"
    background: float = 0.0
    void_values: str = "background"
    versions: tuple[Hashable, ...] = ()

    if TYPE_CHECKING:

        def __init__(
            self,
            source: Grid,
            target: Grid | None = ...,
            interpolation: str | Iterable[str] = ...,
            background: float = ...,
            void_values: str = ...,
            versions: Iterable[Hashable] = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        checked_grid("source", self.source)
        target = self.source if self.target is None else checked_grid("target", self.target)
        one = isinstance(self.interpolation, str) or not isinstance(self.interpolation, Iterable)
        methods = self.interpolation if one else tuple(self.interpolation)
        if not all(
            isinstance(method, str) and method in INTERPOLATIONS
            for method in ([methods] if one else methods)
        ):
            raise self._bad_interpolation()
        for name, value in {
            "target": target,
            "interpolation": methods,
            "background": _exact_number("background", self.background),
            "void_values": validation.choice("void_values", self.void_values, VOID_VALUES),
            "versions": tuple(self.versions),
        }.items():
            object.__setattr__(self, name, value)

    @classmethod
    def of(cls, value: Sampling | Grid) -> Sampling:
        """`value`, or for a Grid what is sampled on it and wanted there again."""
        if isinstance(value, Sampling):
            return value
        if isinstance(value, Grid):
            return cls(value)
        raise TypeError(f"`sampling` must be a Sampling or a Grid, got {short_repr(value)}")

    @property
    def continues(self) -> bool:
        """Whether values go on in the void."""
        return self.void_values == "continued"

    def methods(self, count: int) -> tuple[str, ...]:
        """The interpolation of each of `count` arrays."""
        if isinstance(self.interpolation, str):
            return (self.interpolation,) * count
        if len(self.interpolation) != count:
            raise self._bad_interpolation()
        return self.interpolation

    def version(self, number: int) -> Hashable:
        """What tells the contents of the array with a number from all others; None if unknown."""
        return self.versions[number] if number < len(self.versions) else None

    def warn_of_background(self, dtypes: dict[str, np.dtype[Any]]) -> None:
        """Warn of arrays, dtypes by their names, whose types do not have the background."""
        found = [
            f"{name} ({dtype}) gets {interpolation.cast(self.background, dtype)} instead"
            for name, dtype in dtypes.items()
            if not interpolation.is_in_range(self.background, dtype)
        ]
        if found:
            listed = ", ".join([*found[:_MAX_LISTED], *["..."] * (len(found) > _MAX_LISTED)])
            warn(
                "`background` must be in the range of each array's type, "
                f"got {short_repr(self.background)}: {listed}; "
                "choose another value or convert the array"
            )

    def _bad_interpolation(self):
        return ValueError(
            f"`interpolation` must be one of {', '.join(INTERPOLATIONS)}, or one for each array, "
            f"got {short_repr(self.interpolation)}"
        )


def _exact_number(name, value):
    """A float; an integer as an int, for float64 does not hold all that arrays may."""
    number = validation.number(name, value)
    return int(value) if isinstance(value, (int, np.integer)) else number
