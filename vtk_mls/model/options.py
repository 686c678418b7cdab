"""The options of a deformation: name, default, range and help of each, in one table.

`Deformation`, the filters and ParaView's panels, the command line, the editor and its page, saved
scripts, PyVista and the reference pages take them from `OPTIONS`. Control points and cuts are data,
not options.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vtk_mls.base import validation
from vtk_mls.base.errors import InputError
from vtk_mls.base.validation import short_repr
from vtk_mls.model import kinds

CUT_FRAMES = ("rest", "deformed")
MAX_STEPS = 256


@dataclass(frozen=True)
class Option:
    """One option."""

    name: str  # in snake_case: the argument of `Deformation`
    default: Any  # in Python, in the filters and on the command line: a number, a text, or None
    label: str  # of a control in a panel
    help: str  # for all users
    more: str = ""  # help for programmers
    spellings: Mapping[str, int] = field(default_factory=dict, hash=False)  # of values, by text
    choices: tuple = ()  # possible values; empty for a number in a range, or a text
    choice_labels: tuple = ()  # in a panel, if the names of the choices are not clear
    is_valid: Callable[[float], bool] | None = None  # whether a finite number is a valid value
    expected: str = ""  # valid values, for errors; by default the list of the choices
    slider: tuple | None = None  # usual range (low, high, step), for sliders and keys
    interactive_default: Any = None  # in ParaView and in the editor; `default` if not given
    section: str = "map"  # of panels: "map", "cut" or "computing"
    is_advanced: bool = False  # whether ParaView shows it only among advanced properties
    needs: tuple | None = None  # another option and its values with which it has an effect

    def __post_init__(self):
        if self.interactive_default is None:
            vars(self).update(interactive_default=self.default)

    @property
    def property_name(self) -> str:
        """In CamelCase, as of filters and proxies."""
        return "".join(part.capitalize() for part in self.name.split("_"))

    @property
    def flag(self) -> str:
        """On the command line."""
        return "--" + self.name.replace("_", "-")

    def checked(self, value: Any, name: str = "") -> Any:
        """The value with the type of the default.

        Raises
        ------
        TypeError, ValueError
            Naming the option, or `name`.
        """
        name = name or self.name
        if self.choices:
            if not np.isscalar(value) or value not in self.choices:
                expected = self.expected or f"one of {', '.join(map(str, self.choices))}"
                raise InputError(f"must be {expected}, got {short_repr(value)}", argument=name)
            return int(value) if isinstance(self.default, int) else value
        if self.is_valid is None:
            return value
        if isinstance(value, str):
            value = self.spellings.get(value, value)
        number = validation.number(name, value)
        if not (np.isfinite(number) and self.is_valid(number)):
            raise InputError(f"must be {self.expected}, got {short_repr(value)}", argument=name)
        return type(self.default)(number)

    def limited(self, value: float, present: float) -> float:
        """`value`, limited to the range of the slider, which includes the `present` value."""
        low, high, _ = self.slider
        return round(float(np.clip(value, min(low, present), max(high, present))), 3)


# In the order of panels.
OPTIONS = (
    Option(
        "kind",
        "rigid",
        "Kind",
        """How the space between the control points deforms. rigid keeps sizes and angles as well as
        it can, similarity allows a change of size, affine allows shear, and polynomial bends most
        freely. spline is the smoothest map through the control points, and best for landmarks:
        it has neither cuts nor rigid regions. auto is the spline whose settings predict control
        points left out best; up to four points, and with cuts or rigid regions, it is rigid. tps is
        the thin-plate spline of ITK and 3D Slicer.""",
        choices=(*kinds.ALL_KINDS, "auto", "tps"),  # splines with some settings: `with_kind`
    ),
    Option(
        "degree",
        2,
        "Degree",
        "Degree of the polynomials. 1 is the affine kind; 2 and 3 need more control points.",
        choices=(1, 2, 3),
        expected="1, 2 or 3",
        needs=("kind", "polynomial"),
    ),
    Option(
        "order",
        0,
        "Order (0: automatic)",
        """Order of the spline: 1 for r, 2 for r^2 log r, 3 for r^3, the smoothest. auto, or 0,
        takes the one that predicts control points left out best, and with it the softening.""",
        spellings={"auto": 0},
        is_valid=lambda order: order in range(4),
        expected='1, 2, 3 or "auto"',
        is_advanced=True,
        needs=("kind", "spline", "auto"),
    ),
    Option(
        "alpha",
        2.0,
        "Locality (alpha)",
        """How local the influence of a control point is. Its weight at distance r is 1 / r^(2
        alpha). Use 1.5 to 2 to drag a few handles, and 3 for many landmarks with the affine kind or
        polynomials of degree 2. Up to 1.5, the influence of far control points does not fade in
        space. The paper uses 1. Must be greater than 0.""",
        is_valid=lambda alpha: alpha > 0,
        expected="a positive number",
        slider=(0.5, 6.0, 0.1),
        needs=("kind", *kinds.KINDS, "auto"),
    ),
    Option(
        "smoothing",
        0.0,
        "Smoothing",
        """Length in world units. 0 meets the control points exactly. Above 0, the deformation
        passes close to them, for noisy landmarks. Weights are 1 / (r^2 + smoothing^2)^alpha; a
        spline has smoothing^order / weight on the diagonal of its equations. auto, or -1, is for
        splines: it predicts control points left out best.""",
        spellings={"auto": -1},
        is_valid=lambda length: length >= 0 or length == -1,
        expected="a number from 0 on",
    ),
    Option(
        "softening",
        -1.0,
        "Softening (-1: automatic)",
        """Length in world units that rounds a spline at the control points: r becomes sqrt(r^2 +
        softening^2), so that order 1 is smooth there, and still straight far away. auto, or -1, is
        0 for a given order; with an automatic order it predicts control points left out best.""",
        spellings={"auto": -1},
        is_valid=lambda length: length >= 0 or length == -1,
        expected='a number from 0 on, or "auto"',
        needs=("kind", "spline"),
        is_advanced=True,
    ),
    Option(
        "steps",
        1,
        "Steps (0 prevents folds)",
        """Number of steps in which the control points go from p to q, each with its own map. Many
        small steps rarely fold. 1 is the single map of the paper. auto, or 0, doubles the number,
        up to 256, until no determinant at sampled points near the control points is below 0.1, and
        the map folds at no voxel or inverted cell of the output. Polynomials of degree 2 and 3 may
        fold with any number of steps.""",
        more="`Deformation.steps_used`, `path_used` and `smallest_determinant` report the result.",
        spellings={"auto": 0},
        is_valid=lambda steps: steps in range(MAX_STEPS + 1),
        expected="an integer from 1 to 256, or 0 for automatic steps",
    ),
    Option(
        "blend",
        1.0,
        "Share of the deformation",
        """Fraction of the displacement from p to q that is applied. 0 leaves everything exactly as
        it was.""",
        is_valid=lambda blend: True,
        expected="a finite number",
        slider=(0.0, 1.0, 0.05),
    ),
    Option(
        "cut_frame",
        "rest",
        "The cut stays",
        """Space of the cuts. rest: cuts lie in the undeformed volume and move with the material.
        deformed: cuts stay in place in the deformed space, and material that moves through them is
        lost.""",
        more="The paper uses deformed.",
        choices=CUT_FRAMES,
        choice_labels=("with the material", "where it was laid"),
        section="cut",
    ),
    Option(
        "nu",
        2.0,
        "Parting of cuts (nu)",
        """How fast the influence of control points behind a cut falls with the length of the detour
        around it. Must be greater than 1.""",
        more="The damping exponent of Eq. 28.",
        is_valid=lambda nu: nu > 1,
        expected="a number above 1",
        slider=(1.1, 8.0, 0.1),
        section="cut",
    ),
    Option(
        "map_tolerance",
        0.0,
        "Map tolerance",
        """Largest error of displacements on grids, in spacings of the grid. Above 0, they are
        interpolated from fewer points, which is faster. With 0, the default of Python and the
        shell, each point is computed. ParaView and the editor use 0.02, which is too small to see.
        Next to cuts, all points are computed.""",
        is_valid=lambda tolerance: tolerance >= 0,
        expected="a number from 0 on",
        interactive_default=0.02,
        section="computing",
    ),
    Option(
        "device",
        None,
        "Device",
        """Where to compute. Empty: the first GPU, or else the CPU with its fastest driver.
        Otherwise cpu, gpu, platform:device such as 0:1, or reference for the slow float64
        specification in numpy.""",
        section="computing",
    ),
)


def named(name: str) -> Option:
    """The option with a name."""
    return next(option for option in OPTIONS if option.name == name)


KIND, DEGREE, ALPHA, NU, BLEND, CUT_FRAME, MAP_TOLERANCE = map(
    named, ("kind", "degree", "alpha", "nu", "blend", "cut_frame", "map_tolerance")
)
# Arguments of `Deformation`; a blend moves the control points instead.
DEFORMATION_OPTIONS = tuple(option for option in OPTIONS if option is not BLEND)


def with_kind(values: dict[str, Any], may_be_spline: bool) -> dict[str, Any]:
    """Values of a deformation with the kinds "auto" and "tps" as "spline", or as "rigid"."""
    kind, smoothing = values["kind"], values["smoothing"]
    if kind == "tps":
        return {**values, "kind": "spline", "order": 1}
    if kind != "auto":
        return values
    if not may_be_spline:
        return {**values, "kind": "rigid", "smoothing": max(smoothing, 0.0)}
    return {**values, "kind": "spline", "smoothing": smoothing or -1.0}


def values_of(source: Any, options: tuple[Option, ...] = OPTIONS) -> dict[str, Any]:
    """Values by name, from attributes of `source`."""
    return {option.name: getattr(source, option.name) for option in options}
