"""Points with names, as files hold them, and how two files make pairs."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from vtk_mls.files.frames import signs

_LONG, _MANY = 60, 5
_NUMBERED = re.compile(r"(?:(?P<list>.*)-)?(?P<number>\d{1,9})", re.DOTALL)


@dataclass(frozen=True, eq=False)
class Landmarks:
    """Points of a file.

    Attributes
    ----------
    path : path
        Of the file, for errors.
    positions : (n, 3) float64
        NaN for a point that is not placed.
    frame : str
        What x, y and z are in a patient, as of `frames.signs`, if the file says it; else "".
    labels, descriptions : lists of n str
        Empty texts for none.
    partners : (n, 3) float64 or None
        Where the points go, if the file says that too; NaN for a pair that does not count.
    weights : (n,) float64 or None
    """

    path: object
    positions: np.ndarray
    frame: str = ""
    labels: list = ()
    descriptions: list = ()
    partners: np.ndarray | None = None
    weights: np.ndarray | None = None

    def __post_init__(self):
        for name in ("labels", "descriptions"):
            object.__setattr__(self, name, list(getattr(self, name)) or [""] * len(self.positions))

    def in_lps(self, space: str) -> Landmarks:
        """The same in the frame LPS; `space` is the frame of a file that does not say its own."""
        factors = signs(self.frame or space)
        partners = None if self.partners is None else self.partners * factors
        return replace(self, positions=self.positions * factors, partners=partners, frame="LPS")

    @property
    def is_placed(self):
        """(n,) bool"""
        return np.isfinite(self.positions).all(axis=1)


@dataclass(frozen=True, eq=False)
class Pairs:
    """Control points, p and q.

    Attributes
    ----------
    rest, deformed : (n, 3) float64, world coordinates
        p and q.
    weights : (n,) float64 or None
    labels : list of n str
    """

    rest: np.ndarray
    deformed: np.ndarray
    weights: np.ndarray | None
    labels: list


def paired(rest, deformed=None):
    """The control points of one file, or of two.

    Parameters
    ----------
    rest : Landmarks
        Their positions are p, their partners q; without partners q = p.
    deformed : Landmarks, optional
        Their positions are q instead. They belong to those p that have the same label, if in both
        files each point has a label of its own, or, if the labels are just numbers after the name
        of a list (`rest-1`, `moved-1`, as 3D Slicer makes them), the same number. Else they belong
        to the p at the same position in the file.

    Returns
    -------
    Pairs
        Pairs of which a position is missing are left out.

    Raises
    ------
    ValueError
        If the files do not fit, saying which labels or how many points; or if no pair is left.
    """
    p, q = rest.positions, rest.partners
    is_pair = rest.is_placed if q is None else rest.is_placed & np.isfinite(q).all(axis=1)
    if deformed is not None:
        if deformed.partners is not None and (deformed.partners != deformed.positions).any():
            raise ValueError(
                f"`{deformed.path}` says two positions for a point; the file of positions that "
                "control points were moved to must say one"
            )
        q = deformed.positions[_order(rest, deformed)]
        is_pair &= np.isfinite(q).all(axis=1)
    if not is_pair.any():
        of_both = "" if deformed is None else f", nor pairs with those of `{deformed.path}`"
        raise ValueError(f"`{rest.path}` holds no control points{of_both}: none is placed")
    kept = np.flatnonzero(is_pair)
    weights = None if rest.weights is None else rest.weights[kept]
    p = p[kept]
    return Pairs(p, p if q is None else q[kept], weights, [rest.labels[i] for i in kept.tolist()])


def shortened(text):
    """A text in backticks on one line, or its beginning and how long it is."""
    line = "".join(each if each.isprintable() else " " for each in text[:_LONG])
    return f"`{line}`" if len(text) <= _LONG else f"`{line}...` of {len(text)} characters"


def listed(labels):
    """Labels in a sentence, the first of many."""
    more = f" and {len(labels) - _MANY} more" * (len(labels) > _MANY)
    return ", ".join(shortened(label or "?") for label in labels[:_MANY]) + more


def _order(rest, deformed):
    """For each point of `rest` the number of its partner in `deformed`."""
    own, other = rest.labels, deformed.labels
    if _are_names(own) and _are_names(other):
        for name in (lambda labels: labels, _numbers):
            keys, numbers = name(own), {key: i for i, key in enumerate(name(other))}
            are_unique = len(set(keys)) == len(own) and len(numbers) == len(other)
            if are_unique and set(keys) == set(numbers):
                return np.array([numbers[key] for key in keys])
        _complain(rest, deformed)
    if len(own) != len(other):
        repeated = [
            f"; `{each.path}` has the label {listed([label])} {count} times"
            for each in (rest, deformed)
            for label, count in Counter(each.labels).most_common(1)
            if label and count > 1
        ]
        raise ValueError(
            f"`{deformed.path}` must hold one position for each of the {len(own)} control points "
            f"of `{rest.path}`, got {len(other)}{''.join(repeated[:1])}"
        )
    return np.arange(len(own))


def _are_names(labels):
    return all(labels) and len(set(labels)) == len(labels)


def _numbers(labels):
    """The numbers at the end of labels `LIST-NUMBER`; nothing if they are not all of one list."""
    found = [_NUMBERED.fullmatch(label) for label in labels]
    if None in found or len({match["list"] for match in found}) > 1:
        return []
    return [int(match["number"]) for match in found]


def _complain(rest, deformed):
    parts = []
    for one, other in ((rest, deformed), (deformed, rest)):
        known = set(other.labels)
        lonely = [label for label in one.labels if label not in known]
        if lonely:
            parts.append(f"only `{one.path}` has {listed(lonely)}")
    raise ValueError(
        f"the labels of `{rest.path}` and `{deformed.path}` do not fit: {'; '.join(parts)}"
    )
