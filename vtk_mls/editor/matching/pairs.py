"""Pairs of landmarks: p on the moving data, q on the target, and the table of them."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from vtk_mls.editor import grips
from vtk_mls.landmarks.left_out import PointPairs, predictions
from vtk_mls.landmarks.settings import Settings
from vtk_mls.model.kinds import splines

MOVING, TARGET = SIDES = "moving", "target"
# Pairs for which the errors are computed at each edit, and those without which there is no map.
_MAX_PAIRS, _MIN_PAIRS = 200, 4


@dataclass(frozen=True, eq=False)
class Pending:
    """A landmark on one side, until its partner is placed on the other.

    Attributes
    ----------
    side : str
        MOVING or TARGET.
    position : (3,) float64, world coordinates
        p on the moving data, as they are at rest; or q on the target.
    label : str
    """

    side: str
    position: np.ndarray
    label: str = ""

    def __post_init__(self):
        if self.side not in SIDES:
            raise ValueError(f"`side` must be {MOVING!r} or {TARGET!r}, got {self.side!r}")
        object.__setattr__(self, "position", np.array(self.position, float).reshape(3))


@dataclass(frozen=True)
class PairRow:
    """A row of the `PairTable`, of numbers of Python.

    Attributes
    ----------
    row : int or None
        Of the state; None for the pending landmark.
    name : str
        The label, or the number from 1 on.
    rest, deformed : (x, y, z) or None, world coordinates
        p and q; None for the place that the pending landmark lacks.
    distance : float or None, world units
        From p to q.
    error : float or None, world units
        When left out: distance from p to the place to which the map of all other enabled pairs
        takes q. None for pairs that are off, and if `PairTable.has_errors` is false.
    is_enabled : bool
        Whether the pair belongs to the map.
    """

    row: int | None
    name: str
    rest: tuple | None
    deformed: tuple | None
    distance: float | None = None
    error: float | None = None
    is_enabled: bool = True


@dataclass(frozen=True)
class PairTable:
    """The pairs of a `State`, and its pending landmark as the last row.

    Attributes
    ----------
    rows : tuple of PairRow
    median_error : float or None, world units
        Of the errors when left out.
    choice : str
        The spline that is chosen by these errors; "" for other kinds.
    """

    rows: tuple
    median_error: float | None
    choice: str = ""

    @staticmethod
    @functools.lru_cache(maxsize=4)
    def of(state) -> PairTable:
        """The table of a state."""
        state = state.with_chosen_settings()
        names, errors = grips.names_of(state), left_out_errors(state)
        distances = np.linalg.norm(state.deformed - state.rest, axis=1)
        rows = [
            PairRow(
                row,
                names[row],
                tuple(state.rest[row].tolist()),
                tuple(state.deformed[row].tolist()),
                float(distances[row]),
                None if np.isnan(errors[row]) else float(errors[row]),
                bool(state.enabled[row]),
            )
            for row in range(len(state))
        ]
        pending = state.pending
        if pending is not None:
            position = tuple(pending.position.tolist())
            places = (position, None) if pending.side == MOVING else (None, position)
            rows.append(PairRow(None, pending.label, *places))
        return PairTable(tuple(rows), _median(errors), _choice(state))

    @property
    def has_errors(self):
        """Whether pairs have errors: with 4 to 200 pairs in the map, without cuts and shapes."""
        return self.median_error is not None


def left_out_errors(state):
    """The error (n,) of each pair when left out, world units; NaN where there is none.

    See `PairRow.error`. Regions, curves, cuts and the mask are not part of the prediction: with any
    of them, all errors are NaN.
    """
    errors = np.full(len(state), np.nan)
    rows = np.flatnonzero(state.enabled)
    has_shapes = state.handles or state.cuts or state.mask is not None
    if has_shapes or not _MIN_PAIRS <= len(rows) <= _MAX_PAIRS:
        return errors
    pairs = _enabled_pairs(state)
    if len(np.unique(pairs.deformed, axis=0)) < len(rows):
        return errors
    lengths = {"smoothing": state.smoothing, "softening": state.softening}
    settings = Settings(state.kind, state.degree, state.alpha, order=state.order, **lengths)
    predicted = predictions(pairs, np.arange(len(rows)), settings)
    errors[rows] = np.linalg.norm(predicted - pairs.rest, axis=1)
    return errors


def _choice(state):
    if state.kind != "spline" or state.order == 0:
        return ""
    return splines.in_words(state.order, state.smoothing, state.softening)


def _enabled_pairs(state):
    rows = np.flatnonzero(state.enabled)
    weights = np.ones(len(rows)) if state.weights is None else state.weights[rows]
    return PointPairs(state.rest[rows], state.deformed[rows], weights)


def _median(errors):
    finite = errors[np.isfinite(errors)]
    return float(np.median(finite)) if len(finite) else None


def with_landmark(state, side, position):
    """A copy of a `State` with a landmark at a position (3,) on a side.

    The landmark is pending until its partner is placed; another one on the same side moves it.
    """
    pending = state.pending
    if pending is None or pending.side == side:
        label = _free_name(state) if pending is None else pending.label
        return state.changed(pending=Pending(side, position, label))
    places = {side: position, pending.side: pending.position}
    pair = state.with_handle(places[MOVING], places[TARGET])
    return pair.with_name(len(state), pending.label).changed(pending=None)


def _free_name(state):
    """The first number that names no other pair."""
    names, number = set(grips.names_of(state)), len(state) + 1
    while str(number) in names:
        number += 1
    return str(number)
