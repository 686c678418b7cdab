"""Pairs of landmarks: p on the moving data, q on the target, their errors and refinement."""

from __future__ import annotations

import functools
import itertools
from contextlib import suppress
from typing import NamedTuple

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls import landmarks
from vtk_mls.editor import grips
from vtk_mls.landmarks.left_out import PointPairs, Settings, predictions
from vtk_mls.landmarks.pair_report import outliers_among
from vtk_mls.model.kinds import splines
from vtk_mls.rendering.transfer_functions import scalar_image
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

MOVING, TARGET = "moving", "target"  # sides
# Pairs for which errors and outliers are computed at each edit, and those without which there is no
# map.
_MAX_PAIRS, _MAX_OUTLIER_PAIRS, _MIN_PAIRS = 200, 100, 4


class PairTable(NamedTuple):
    """Errors of the n pairs of a `State`.

    Attributes
    ----------
    errors : (n,) float64, world units
        As of `left_out_errors`.
    are_outliers : (n,) bool
        As of `landmarks.report`; False with more pairs than 100.
    median_error : float or None, world units
    choice : str
        The spline that is chosen by these errors; "" for other kinds.
    """

    errors: np.ndarray
    are_outliers: np.ndarray
    median_error: float | None
    choice: str


@functools.lru_cache(maxsize=4)
def table_of(state):
    """The `PairTable` of a state."""
    state = state.with_chosen_settings()
    errors = left_out_errors(state)
    finite = errors[np.isfinite(errors)]
    median = float(np.median(finite)) if len(finite) else None
    choice = ""
    if state.kind == "spline" and state.order != 0:
        choice = splines.in_words(state.order, state.smoothing, state.softening)
    return PairTable(errors, outliers(state, errors), median, choice)


def left_out_errors(state):
    """The error (n,) of each pair when left out, world units; NaN where there is none.

    That is the distance from p to the place to which the map of all other enabled pairs takes q.
    Regions, curves, cuts and the mask are not part of the prediction: with any of them, and with
    fewer pairs than 4 or more than 200, all errors are NaN.
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


def outliers(state, errors):
    """Whether each pair is an outlier: (n,) bool; only pairs with errors (n,) can be."""
    is_outlier, rows = np.zeros(len(state), bool), np.flatnonzero(np.isfinite(errors))
    if 0 < len(rows) <= _MAX_OUTLIER_PAIRS:
        with suppress(ValueError):  # two places coincide
            is_outlier[rows] = outliers_among(*vars(_enabled_pairs(state)).values())
    return is_outlier


def _enabled_pairs(state):
    rows = np.flatnonzero(state.enabled)
    weights = np.ones(len(rows)) if state.weights is None else state.weights[rows]
    return PointPairs(state.rest[rows], state.deformed[rows], weights)


def with_pair(state, rest, deformed):
    """A copy of a `State` with a pair at p and q (3,), the last; a free number is its name."""
    names = grips.names_of(state)
    name = next(str(i) for i in itertools.count(len(state) + 1) if str(i) not in names)
    return state.with_handle(rest, deformed).with_name(len(state), name)


def refined_pairs(state, datasets, rows, progress=None):
    """A `State` with refined landmarks `rows`, and the `landmarks.Refinement`.

    `datasets` are the moving one and the target, ValueError for a mesh; other errors and `progress`
    are as of `landmarks.refine`.
    """
    images = []
    for dataset, side in zip(datasets, ("moving data", "target")):
        if not isinstance(dataset, vtkImageData):
            raise ValueError(
                f"landmarks are refined by two images with gray values, and the {side} is a mesh"
            )
        image = scalar_image(dataset)
        scalars, grid = image.GetPointData().GetScalars(), ImageGeometry.of_image(image).grid
        images.append(landmarks.Image(arrays.to_numpy(scalars).reshape(grid.shape), grid))
    deformation = state.deformation() if state.enabled.any() else None
    pairs = state.rest[rows], state.deformed[rows]
    found = landmarks.refine(*images, *pairs, deformation=deformation, progress=progress)
    return state.moved(rows, found.deformed), found


def key_of(state, row):
    """Identifies a landmark by its places, whatever its row and name."""
    return state.rest[row].tobytes() + state.deformed[row].tobytes()
