"""Where and how values on a grid are sampled through a deformation."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Union

import numpy as np
from numpy.typing import NDArray

from vtk_mls.base import interpolation, validation
from vtk_mls.base.grid import Grid, checked_grid
from vtk_mls.base.interpolation import INTERPOLATIONS
from vtk_mls.base.messages import warn
from vtk_mls.base.validation import freeze, short_repr

# Values in the void of a cut: the background, or those of the material continued behind its face.
VOID_VALUES = ("background", "continued")
AUTOMATIC = "auto"  # background
Background = Union[float, str, tuple[float, ...]]
_MAX_LISTED = 4  # arrays in a warning


@dataclass(frozen=True, init=False)
class Sampling:
    """How values on a grid are sampled: source, target, interpolation and background.

    Parameters
    ----------
    source : Grid
        Where the values are. For a part of a grid, values outside the part are assumed not to be
        needed: see `Deformation.source_bounds`.
    target : Grid, optional
        Where values are sampled; `source` by default.
    interpolation : {"nearest", "linear", "cubic"} or a sequence with one for each array
        "cubic" is Catmull-Rom (Keys, a = -1/2).
    background : float, "auto", or a sequence with one of these for each array
        Value of points whose material came from outside of `source` (by more than half a spacing),
        and of the void. Directions are 0 there. An array whose type cannot hold it gets the
        nearest value of its type (integers 0 for NaN), with a warning. "auto" is the
        `corner_median` of each array, as air around a CT; give labels 0. A value can also be a
        tuple of numbers, one for each component.
    void_values : {"background", "continued"}
        Values in the void: the `background`, or the values that the map of each side gives there,
        as if its material continued behind the face of the cut. Contours of continued values end
        sharply where they are clipped by the void distance.
    versions : sequence of hashable or None, one for each array, optional
        Identify the contents of an array, such as its modification time. Devices with their own
        memory keep an array there for the next question with an equal version; arrays with
        version None are not kept. After writing to an array in place, change its version.

    Raises
    ------
    ValueError, TypeError
        For a bad parameter, naming it.
    """

    source: Grid
    target: Grid
    interpolation: str | tuple[str, ...] = "linear"
    background: Background | tuple[Background, ...] = 0.0
    void_values: str = VOID_VALUES[0]
    versions: tuple[Hashable, ...] = ()

    def __init__(
        self,
        source: Grid,
        target: Grid | None = None,
        interpolation: str | Iterable[str] = interpolation,
        background: Background | Iterable[Background] = background,
        void_values: str = void_values,
        versions: Iterable[Hashable] = (),
    ) -> None:
        checked_grid("source", source)
        freeze(
            self,
            source=source,
            target=source if target is None else checked_grid("target", target),
            interpolation=_checked_interpolation(interpolation),
            background=_checked_background(background),
            void_values=validation.choice("void_values", void_values, VOID_VALUES),
            versions=tuple(versions),
        )

    @classmethod
    def of(cls, value: Sampling | Grid) -> Sampling:
        """`value`, or for a Grid the sampling from that grid to itself."""
        if isinstance(value, Sampling):
            return value
        if isinstance(value, Grid):
            return cls(value)
        raise TypeError(f"`sampling` must be a Sampling or a Grid, got {short_repr(value)}")

    @property
    def continues(self) -> bool:
        """Whether values are continued in the void."""
        return self.void_values == "continued"

    def methods(self, count: int) -> tuple[str, ...]:
        """The interpolation of each of `count` arrays."""
        return _for_each(self.interpolation, count, _bad_interpolation)

    def backgrounds(self, count: int) -> tuple[Background, ...]:
        """The background of each of `count` arrays."""
        return _for_each(self.background, count, _bad_background)

    def with_backgrounds(self, arrays: Sequence[NDArray[Any]]) -> Sampling:
        """This sampling with numbers instead of the automatic backgrounds of `arrays`."""
        backgrounds = self.backgrounds(len(arrays))
        if AUTOMATIC not in backgrounds:
            return self
        if self.source.whole is not self.source:
            raise ValueError("`background` must be numbers for a part of a grid, got auto")
        corners = corners_of(self.source.shape)
        numbers = [
            corner_median([array[index] for index in corners]) if value == AUTOMATIC else value
            for array, value in zip(arrays, backgrounds)
        ]
        return replace(self, background=tuple(numbers))

    def version(self, index: int) -> Hashable:
        """The version of the array with an index; None if unknown."""
        return self.versions[index] if index < len(self.versions) else None

    def warn_of_background(self, dtypes: dict[str, np.dtype[Any]]) -> None:
        """Warn of arrays, dtypes by name, whose types cannot hold the background."""
        given = self.background  # also of a gradient, which comes last
        backgrounds = given if isinstance(given, tuple) else self.backgrounds(len(dtypes))
        found = [
            f"{name} ({dtype}) gets {interpolation.cast(value, dtype)} instead"
            for (name, dtype), value in zip(dtypes.items(), backgrounds)
            if not interpolation.is_in_range(value, dtype)
        ]
        if found:
            listed = ", ".join([*found[:_MAX_LISTED], *["..."] * (len(found) > _MAX_LISTED)])
            warn(
                "`background` must be in the range of each array's type, "
                f"got {short_repr(self.background)}: {listed}; "
                "choose another value or convert the array"
            )


def _for_each(value: Any, count: int, error: Callable[[Any], ValueError]) -> tuple[Any, ...]:
    """A value for each of `count` arrays, from one of all or a tuple with one for each."""
    values = value if isinstance(value, tuple) else (value,) * count
    if len(values) != count:
        raise error(values)
    return values


def _checked_interpolation(value):
    """One of `INTERPOLATIONS`, or a tuple of them."""
    is_single = isinstance(value, str) or not isinstance(value, Iterable)
    methods = (value,) if is_single else tuple(value)
    if not all(isinstance(method, str) and method in INTERPOLATIONS for method in methods):
        raise _bad_interpolation(value if is_single else methods)
    return value if is_single else methods


def _bad_interpolation(value):
    return ValueError(
        f"`interpolation` must be one of {', '.join(INTERPOLATIONS)}, or one for each array, "
        f"got {short_repr(value)}"
    )


def corners_of(shape: Sequence[int]) -> list[tuple[int, ...]]:
    """Indices (z, y, x) of the eight corners of an array (nz, ny, nx), of the four of a slice."""
    return list(itertools.product(*(sorted({0, n - 1}) for n in shape)))


def corner_median(values: Sequence[Any]) -> float | tuple[float, ...]:
    """The automatic background of an array, as 3D Slicer's: the median of values at its corners.

    `values` are numbers or arrays (components,) at `corners_of` the array; NaN is ignored. A
    number, or a tuple with one for each component: of two middle values the lower, which is a value
    of the array. NaN if all are.
    """
    ordered = np.sort(np.stack(values), axis=0)  # NaN is last
    middle = np.maximum(np.sum(ordered == ordered, axis=0) - 1, 0) // 2
    median = np.take_along_axis(ordered, middle[None], axis=0)[0].tolist()
    return tuple(median) if isinstance(median, list) else median


def _checked_background(value):
    """A number or `AUTOMATIC`, or a tuple of these, in which a tuple of numbers is one, too."""
    if isinstance(value, (list, tuple)):
        return tuple(map(_checked_background, value))
    if isinstance(value, str):
        if value != AUTOMATIC:
            raise _bad_background(value)
        return value
    number = validation.number("background", value)
    # float64 cannot hold all values of integer arrays
    return int(value) if isinstance(value, (int, np.integer)) else number


def _bad_background(value):
    return ValueError(
        f"`background` must be a number or auto, or one for each array, got {short_repr(value)}"
    )
