"""Points with labels from files, and the pairs of two files."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from vtk_mls.base.errors import InputError
from vtk_mls.base.messages import warn
from vtk_mls.files.frames import signs
from vtk_mls.model.handles.handle_cells import HandleCells

_MAX_TEXT, _MAX_LABELS = 60, 5  # in an error
_NUMBERED = re.compile(r"(?:(?P<list>.*)-)?(?P<number>\d{1,9})", re.DOTALL)
_NOWHERE = np.zeros((0, 0, 3))


@dataclass(frozen=True, eq=False)
class Landmarks:
    """Points of a file.

    `partners` are where the points go, if the file has pairs; NaN for a pair that does not count.
    `are_marked` says whether these were marked in two images; if not, they are dragged handles.
    """

    path: object  # of the file, for errors
    positions: np.ndarray  # (n, 3) float64, NaN for a point that is not placed
    frame: str = ""  # as in `frames.signs`; "" if the file does not say it
    labels: list = ()  # n str, "" without
    descriptions: list = ()
    partners: np.ndarray | None = None  # (n, 3) float64
    weights: np.ndarray | None = None  # (n,) float64
    cells: HandleCells | None = None  # curves and surfaces of the points, if there are any
    # (k, n, 3), on the way to `partners`
    places: np.ndarray = field(default_factory=lambda: _NOWHERE)
    are_marked: bool = False

    def __post_init__(self):
        for name in ("labels", "descriptions"):
            object.__setattr__(self, name, list(getattr(self, name)) or [""] * len(self.positions))

    def in_lps(self, space: str) -> Landmarks:
        """These points in LPS; `space` is the frame of a file that does not say its own."""
        factors = signs(self.frame or space)
        return replace(
            self,
            positions=self.positions * factors,
            partners=None if self.partners is None else self.partners * factors,
            places=self.places * factors,
            frame="LPS",
        )

    @property
    def is_placed(self):
        """(n,) bool"""
        return np.isfinite(self.positions).all(axis=1)

    @property
    def placed_rows(self):
        """Index, position (a list), label and description of each point that is placed."""
        rows = zip(self.positions.tolist(), self.labels, self.descriptions, self.is_placed)
        return [(i, *row) for i, (*row, is_placed) in enumerate(rows) if is_placed]


class Pairs(NamedTuple):
    """Control points, p and q."""

    rest: np.ndarray  # (n, 3) float64, world coordinates
    deformed: np.ndarray
    weights: np.ndarray | None  # (n,) float64
    labels: list  # n str
    cells: HandleCells | None = None  # curves and surfaces of the points, if there are any
    places: np.ndarray = _NOWHERE  # (k, n, 3), between p and q


# How the points of two files make pairs.
PAIR_BY = ("order", "labels", "common")


def paired(rest, deformed=None, between=(), pair_by=""):
    """The `Pairs` of the `Landmarks` of one file, of two, or of a series.

    Positions in `rest` are p, their partners q; without partners q = p. Curves and surfaces are
    theirs. Positions in `deformed` are q instead. If the labels are unique in both files, q belongs
    to p of the same label; if labels are numbers after the name of a list (`rest-1`, `moved-1`, as
    in 3D Slicer), to p of the same number. Otherwise q belongs to p of the same index; a warning
    says so if some labels are equal.

    `pair_by` says otherwise. "order": by index, whatever the labels are; "labels": by labels, or by
    their numbers, which must be equal in both files; "common": by labels, without the points whose
    label only one file has, which a warning lists.

    Landmarks `between` are intermediate places, paired in the same way. If the first are p, they do
    not count. Pairs that lack a position are left out; a warning lists those that only one file
    places. ValueError if labels or numbers of points differ, or no pair is left.
    """
    p, q, places = rest.positions, rest.partners, rest.places
    is_pair = rest.is_placed if q is None else rest.is_placed & np.isfinite(q).all(axis=1)
    if deformed is not None:
        *places, q = [_moved(rest, moved, pair_by) for moved in (*between, deformed)]
        places = np.reshape(places, (len(between), *p.shape))
        is_pair &= np.isfinite([*places, q]).all(axis=(0, 2))
    if not is_pair.any():
        other = "" if deformed is None else f", nor pairs with those of `{deformed.path}`"
        raise InputError(f"holds no control points{other}: none is placed", path=rest.path)
    weights = None if rest.weights is None else rest.weights[is_pair]
    labels = [label for label, is_used in zip(rest.labels, is_pair) if is_used]
    p, cells = p[is_pair], rest.cells and rest.cells.of_rows(is_pair)
    places = places[:, is_pair] if len(places) else places
    if len(between) and (places[0] == p).all():
        places = places[1:]
    return Pairs(p, p if q is None else q[is_pair], weights, labels, cells, places)


def numbers(cells):
    """The numbers in cells; an empty list if one is not a number."""
    try:
        return [] if any("_" in cell for cell in cells) else [float(cell) for cell in cells]
    except ValueError:
        return []


def finite(where, position):
    """A position, if its coordinates are finite."""
    if not np.isfinite(position).all():
        raise InputError(f"has a coordinate that is not a finite number in {where}")
    return position


def shortened(text):
    """A text in backticks on one line; of a long one the beginning and the length."""
    line = "".join(letter if letter.isprintable() else " " for letter in text[:_MAX_TEXT])
    return f"`{line}`" if len(text) <= _MAX_TEXT else f"`{line}...` of {len(text)} characters"


def listed(labels):
    """The first labels, for a sentence."""
    more = f" and {len(labels) - _MAX_LABELS} more" * (len(labels) > _MAX_LABELS)
    return ", ".join(shortened(label or "?") for label in labels[:_MAX_LABELS]) + more


def _moved(rest, deformed, pair_by):
    """Positions (n, 3) of the partners in `deformed` of the points of `rest`; NaN without one."""
    if deformed.partners is not None and (deformed.partners != deformed.positions).any():
        raise InputError(
            "has two positions for a point; a file of deformed positions must have one",
            path=deformed.path,
        )
    order = _order(rest, deformed, pair_by)
    lost = (order >= 0) & (rest.is_placed != deformed.is_placed[order])
    if lost.any():
        labels = listed([label for label, is_lost in zip(rest.labels, lost) if is_lost])
        warn(
            f"pairs that are placed in only one of `{rest.path}` and `{deformed.path}` are left "
            f"out: {labels}"
        )
    return np.where(order[:, None] < 0, np.nan, deformed.positions[order])


def _order(rest, deformed, pair_by):
    """For each point of `rest` the index of its partner in `deformed`, -1 without one."""
    own, other = rest.labels, deformed.labels
    are_unique = _are_unique(own) and _are_unique(other)
    if pair_by in ("labels", "common") and not are_unique:
        raise ValueError(
            "points are paired by labels, so each point must have its own label; "
            f"{_repeated(rest, deformed)}"
        )
    if pair_by == "common":
        return _common_order(rest, deformed)
    if are_unique and pair_by != "order":
        for to_keys in (list, _numbers):
            keys, indices = to_keys(own), {key: i for i, key in enumerate(to_keys(other))}
            is_complete = len(set(keys)) == len(own) and len(indices) == len(other)
            if is_complete and set(keys) == set(indices):
                return np.array([indices[key] for key in keys])
        parts = "; ".join(_unmatched(rest, deformed))
        raise ValueError(f"the labels of `{rest.path}` and `{deformed.path}` do not fit: {parts}")
    if len(own) != len(other):
        raise InputError(
            f"must hold one position for each of the {len(own)} control points of `{rest.path}`, "
            f"got {len(other)}",
            path=deformed.path,
        )
    if pair_by != "order" and own != other and set(filter(None, own)).intersection(other):
        warn(f"points are paired by their order, not by labels, for {_repeated(rest, deformed)}")
    return np.arange(len(own))


def _common_order(rest, deformed):
    """As `_order`, by the labels that both have; a warning lists the others."""
    own, other = rest.labels, deformed.labels
    indices = {label: i for i, label in enumerate(other)}
    order = np.array([indices.get(label, -1) for label in own])
    if (order < 0).all():
        raise ValueError(
            f"`{rest.path}` and `{deformed.path}` have no label in common: the first has "
            f"{listed(own)}, the second {listed(other)}"
        )
    parts = _unmatched(rest, deformed)
    if parts:
        warn(f"points without a partner are left out: {'; '.join(parts)}")
    return order


def _repeated(rest, deformed):
    """Why labels make no pairs: a clause."""
    points = deformed if _are_unique(rest.labels) else rest
    label, count = Counter(points.labels).most_common(1)[0]
    if all(points.labels):
        return f"`{points.path}` has {shortened(label)} {count} times"
    return f"`{points.path}` has {sum(not label for label in points.labels)} points without a label"


def _are_unique(labels):
    return all(labels) and len(set(labels)) == len(labels)


def _numbers(labels):
    """The numbers of labels `LIST-NUMBER`; an empty list if they are not all of one list."""
    matches = [_NUMBERED.fullmatch(label) for label in labels]
    if None in matches or len({match["list"] for match in matches}) > 1:
        return []
    return [int(match["number"]) for match in matches]


def _unmatched(rest, deformed):
    """For each of two files with labels that the other one lacks, a clause."""
    parts = []
    for points, others in ((rest, deformed), (deformed, rest)):
        other_labels = set(others.labels)
        unmatched = [label for label in points.labels if label not in other_labels]
        if unmatched:
            parts.append(f"only `{points.path}` has {listed(unmatched)}")
    return parts
