"""Pairs of landmarks: p on the moving data, q on the target, and the table of them."""

from __future__ import annotations

import functools
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from vtk_mls.editor import grips
from vtk_mls.landmarks.left_out import PointPairs, predictions
from vtk_mls.landmarks.pair_report import outliers_among
from vtk_mls.landmarks.settings import Settings

MOVING, TARGET = "moving", "target"  # sides
# Pairs for which errors and outliers are computed at each edit, and those without which there is no
# map.
_MAX_PAIRS, _MAX_OUTLIER_PAIRS, _MIN_PAIRS = 200, 100, 4


@dataclass(frozen=True)
class PairRow:
    """A row of the `PairTable`, of numbers of Python.

    Attributes
    ----------
    row : int
        Of the state.
    name : str
        The label, or the number from 1 on.
    rest, deformed : (x, y, z), world coordinates
        p and q.
    distance : float, world units
        From p to q.
    error : float or None, world units
        When left out: distance from p to the place to which the map of all other enabled pairs
        takes q. None for pairs that are off, and if `PairTable.has_errors` is false.
    is_enabled : bool
        Whether the pair belongs to the map.
    is_outlier : bool
        As of `landmarks.report`; False with more pairs than 100.
    """

    row: int
    name: str
    rest: tuple
    deformed: tuple
    distance: float
    error: float | None
    is_enabled: bool
    is_outlier: bool


@dataclass(frozen=True)
class PairTable:
    """The pairs of a `State`.

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
        are_outliers = outliers(state, errors)
        rows = [
            PairRow(
                row,
                names[row],
                tuple(state.rest[row].tolist()),
                tuple(state.deformed[row].tolist()),
                float(distances[row]),
                None if np.isnan(errors[row]) else float(errors[row]),
                bool(state.enabled[row]),
                bool(are_outliers[row]),
            )
            for row in range(len(state))
        ]
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
    settings = Settings(state.kind, state.degree, state.alpha, state.smoothing, state.order)
    predicted = predictions(pairs, np.arange(len(rows)), settings)
    errors[rows] = np.linalg.norm(predicted - pairs.rest, axis=1)
    return errors


def outliers(state, errors):
    """Whether each pair is an outlier: (n,) bool; only pairs with errors (n,) can be."""
    is_outlier, rows = np.zeros(len(state), bool), np.flatnonzero(np.isfinite(errors))
    if 0 < len(rows) <= _MAX_OUTLIER_PAIRS:
        with suppress(ValueError):  # two places coincide
            is_outlier[rows] = outliers_among(*vars(_enabled_pairs(state)).values())
    return is_outlier


def _choice(state):
    if state.kind != "spline" or state.order == 0:
        return ""
    smoothing = f", smoothing {state.smoothing:.3g}" if state.smoothing > 0 else ""
    return f"spline of order {state.order}{smoothing}"


def _enabled_pairs(state):
    rows = np.flatnonzero(state.enabled)
    weights = np.ones(len(rows)) if state.weights is None else state.weights[rows]
    return PointPairs(state.rest[rows], state.deformed[rows], weights)


def _median(errors):
    finite = errors[np.isfinite(errors)]
    return float(np.median(finite)) if len(finite) else None


def with_pair(state, rest, deformed):
    """A copy of a `State` with a pair at p and q, (3,) each, the last; a number is its name."""
    return state.with_handle(rest, deformed).with_name(len(state), _free_name(state))


def _free_name(state):
    """The first number that names no other pair."""
    names, number = set(grips.names_of(state)), len(state) + 1
    while str(number) in names:
        number += 1
    return str(number)
