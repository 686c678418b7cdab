"""How well pairs of landmarks agree: each is predicted from the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter, itemgetter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.errors import InputError
from vtk_mls.base.progress import SILENT, ProgressLike, whole
from vtk_mls.base.validation import same_count
from vtk_mls.landmarks import left_out, volume
from vtk_mls.landmarks.left_out import BASELINE, PointPairs, Settings, nearest, predictions
from vtk_mls.landmarks.volume import Shape
from vtk_mls.model import arguments
from vtk_mls.model.kinds.splines import ORDERS, Choice, choices, chosen_from

MIN_PAIRS = 4
# Settings are compared by this many of the pairs, each predicted from all others.
MAX_SAMPLE = 256
_MAX_FIRST = 500  # pairs from which the settings are chosen that find outliers
# Smoothings in extents of the pairs, with which all weigh alike to 1e-4, and to 1e-12.
_WHOLE_SMOOTHING, _EXACTLY_WHOLE = 100.0, 1e6
_NEIGHBORS = 4  # of a landmark, on the way to which determinants are sampled


@dataclass(frozen=True, eq=False)
class Report:
    """The result of `report` for n pairs.

    Attributes
    ----------
    names : tuple of n str
    rest, deformed : (n, 3) float64, world coordinates
        p and q.
    moved : (n,) float64, world units
        Distance from p to q.
    error : (n,) float64, world units
        When left out: distance from p to the place in the rest space where the map of all other
        pairs, with the recommended settings, takes q.
    outlier : (n,) bool
    swapped_with : (n,) int
        Row of the pair with which the label looks swapped, -1 for none.
    tried : dict of Settings and float
        The best first; the median error when left out for each, of those of `sampled` pairs that
        are no outliers.
    recommended : Settings
        Those with the smallest errors whose map is sensible in a cube around the pairs, or else
        those that come nearest to it: for 9 of 10 samples the factor of volume, beside that of all
        pairs, is 0.1 to 10, and around thin sets the displacement, beside its mean, is at most 3
        times that of the pairs. Of a mirror only one motion for all pairs is considered.
    is_sensible : bool
        Whether the recommended map is.
    shape : Shape
        Extents of the pairs, and whether they are thin, a drag or a mirror.
    baseline : dict of str and float
        The same median for one "rigid" and one "affine" map for all pairs.
    sampled : int
        Number of pairs from which the medians are.
    smallest_determinant : float
        Of the recommended map of all pairs, as of `Deformation`: it folds if this is not above 0.
        It is sampled in a box around the landmarks, with a margin of half its size. The map can
        still fold between the samples.
    determinant_between : float
        The smallest of the same map sampled between each landmark and the nearest others. If it is
        above 0 and `smallest_determinant` is not, folds were found only where no landmarks are.
    """

    names: tuple[str, ...]
    rest: NDArray[np.float64]
    deformed: NDArray[np.float64]
    moved: NDArray[np.float64]
    error: NDArray[np.float64]
    outlier: NDArray[np.bool_]
    swapped_with: NDArray[np.int64]
    tried: dict[Settings, float]
    recommended: Settings
    is_sensible: bool
    shape: Shape
    baseline: dict[str, float]
    sampled: int
    smallest_determinant: float
    determinant_between: float

    @property
    def swaps(self) -> list[tuple[int, int]]:
        """Rows of the pairs whose labels look swapped, each two once."""
        return [(i, int(j)) for i, j in enumerate(self.swapped_with) if i < j]

    def as_dict(self) -> dict[str, Any]:
        """Values for JSON: `pairs`, `tried`, `recommended`, `baseline` and more."""
        pairs = [
            {
                "name": name,
                "rest": self.rest[i].tolist(),
                "deformed": self.deformed[i].tolist(),
                "moved": float(self.moved[i]),
                "error": float(self.error[i]),
                "outlier": bool(self.outlier[i]),
                "swapped_with": None if (j := self.swapped_with[i]) < 0 else self.names[j],
            }
            for i, name in enumerate(self.names)
        ]
        return {
            "pairs": pairs,
            "tried": [vars(s) | {"median": median} for s, median in self.tried.items()],
            "recommended": vars(self.recommended) | {"median": self.tried[self.recommended]},
            "is_sensible": self.is_sensible,
            "extents": self.shape.extents.tolist(),
            "is_drag": self.shape.is_drag,
            "mirror": self.shape.mirror,
            "baseline": self.baseline,
            "sampled": self.sampled,
            "smallest_determinant": self.smallest_determinant,
            "determinant_between": self.determinant_between,
        }


def report(
    rest: ArrayLike,
    deformed: ArrayLike,
    names: Sequence[str] | None = None,
    *,
    weights: ArrayLike | None = None,
    device: str | None = None,
    progress: ProgressLike = None,
) -> Report:
    """Predict each pair of landmarks from the others.

    The map of all other pairs, at q of a pair, should lead to its p. The distance is an honest
    error: residuals at the landmarks of a map are 0. The mean of their square roots chooses the
    order, the softening and the smoothing of a spline.

    The recommended map is sensible around the pairs, if settings with such a map were found: the
    pairs alone do not show that a map flattens, folds or explodes the volume beside a line or a
    plane of them. If most pairs rest, the others are handles of a drag, and none is an outlier.

    Outliers are pairs with an error above 3 times what is usual among the neighbors and in all,
    predicted from the pairs that are no outliers, and relative to the standard deviation that a
    Gaussian process would give it, which is larger at the rim and where landmarks are sparse. If
    errors spread more than noise, as those of exact pairs of a smooth map, the limit is 5 times.
    Two outliers look swapped if each is predicted clearly nearer to the other's place than to its
    own.

    Parameters
    ----------
    rest, deformed : (n, 3) array_like, world coordinates
        p and q, at least 4 pairs, all places distinct.
    names : sequence of n str, optional
        1, 2, ... by default.
    weights : (n,) array_like, > 0, optional
        As of `Deformation`.
    device : str, optional
        As of `Deformation`, for the smallest determinant.
    progress : callable, optional
        Called with the fraction done; a true return value stops with `Aborted`.

    Returns
    -------
    Report

    Raises
    ------
    ValueError, TypeError
        For fewer than 4 pairs, unequal counts, coincident places, or numbers that are not finite.

    Notes
    -----
    The time is proportional to n^3 up to 1,500 pairs: settings are compared by at most so many,
    and one map for all by at most 256. The largest number of pairs is 5,000.
    """
    pairs, labels = _checked(rest, deformed, names, weights)
    with whole(progress) as part:
        choosing, finding, folding = part.divided(6, 3, 1)
        rows = chosen_from(len(pairs), MAX_SAMPLE)
        shape = Shape.of(pairs)
        found, is_outlier, predicted = _agreed(pairs, shape, choosing)
        smoothing = _EXACTLY_WHOLE * shape.extents[0]
        one_maps = {kind: Settings(kind, None, 1.0, smoothing) for kind in BASELINE}
        clear = pairs.of_rows(np.flatnonzero(~is_outlier))
        some = chosen_from(len(clear), MAX_SAMPLE)
        baseline = {k: float(np.median(_errors(clear, some, s))) for k, s in one_maps.items()}
        tried = {s: float(np.median(size)) for s, size in found.items()}
        best, deformation, is_sensible = _best(clear, some, tried, shape, device)
        if is_outlier.any():
            deformation = volume.excess(pairs, best, device)[1]
        error = _errors(pairs, np.arange(len(pairs)), best, finding)
        folding.report(0)
        p, q = pairs.rest, pairs.deformed
        moved = np.linalg.norm(q - p, axis=1)
        swapped = left_out.find_swapped(pairs, is_outlier, predicted)
    between = np.linalg.det(deformation.jacobian(_between(pairs, rows))).min()
    return Report(
        *(labels, p, q, moved, error, is_outlier, swapped, tried, best),
        *(is_sensible, shape, baseline, len(chosen_from(len(pairs)))),
        *(deformation.smallest_determinant, float(between)),
    )


def outliers_among(rest, deformed, weights=None):
    """Whether each pair is an outlier of `report`, whose arguments these are: (n,) bool."""
    pairs, _ = _checked(rest, deformed, None, weights)
    with whole(None) as part:
        _, is_outlier, _ = _agreed(pairs, Shape.of(pairs), part)
    return is_outlier


def _best(pairs, rows, tried, shape, device):
    """The settings to recommend, the Deformation, and whether it is sensible."""
    judged = []
    for candidate in _candidates(pairs, rows, tried, shape):
        excess, deformation = volume.excess(pairs, candidate, device)
        judged.append((excess, candidate, deformation))
        if excess <= 1:
            break
    excess, best, deformation = min(judged, key=itemgetter(0))
    return best, deformation, excess <= 1


def _candidates(pairs, rows, tried, shape):
    """The settings tried, the best first; then those of one motion for all, which are tried now."""
    if not shape.mirror:
        yield from [*tried]
    smoothing = float(f"{_WHOLE_SMOOTHING * shape.extents[0]:.3g}")
    motions = [Settings(kind, None, 1.0, smoothing) for kind in ("rigid", "similarity")]
    tried |= {s: float(np.median(_errors(pairs, rows, s))) for s in motions}
    yield from sorted(motions, key=tried.__getitem__)


def _agreed(pairs, shape, progress):
    """The `_choices` without outliers, the outliers (n,), and the predictions (n, 3)."""
    first, second = progress.divided(1, 1)
    some = pairs.of_rows(chosen_from(len(pairs), _MAX_FIRST))
    found = _choices(some, first, _spread)  # smooth enough for outliers to stand out
    if shape.is_drag:
        return _choices(pairs, second), np.zeros(len(pairs), bool), pairs.rest
    is_outlier, predicted = left_out.find_outliers(pairs, next(iter(found)))
    near = next(s.softening for s in found if s.order == 1)
    found = _choices(pairs.of_rows(np.flatnonzero(~is_outlier)), second, near=near)
    if is_outlier.any():
        is_outlier, predicted = left_out.find_outliers(pairs, next(iter(found)), is_outlier)
    return found, is_outlier, predicted


def _spread(choice):
    return np.quantile(choice.sizes, (0.5, 0.9)).sum() if len(choice.sizes) else 0.0


def _choices(pairs, progress, key=attrgetter("score"), near=None):
    """Of each order the best exact spline and the best of all, the best first; see `choices`.

    By settings: the distances (m,) of pairs left out.
    """
    rows = chosen_from(len(pairs))
    q, u, weights = pairs.deformed[rows], (pairs.rest - pairs.deformed)[rows], pairs.weights[rows]
    kept: list[Choice] = []
    for order in progress.over(ORDERS):
        tried = choices(q, u, weights, (order,), key=key, near=near)
        exact = (choice for choice in tried if choice.smoothing == 0)
        kept += min(exact, key=key), min(tried, key=key)
    found = {}
    for choice in sorted(kept, key=key):
        lengths = {"smoothing": choice.smoothing, "softening": choice.softening}
        settings = Settings("spline", None, 0.0, order=choice.order, **lengths)
        size = np.linalg.norm(choice.left_out, axis=1)
        found[settings] = _errors(pairs, rows, settings) if np.isnan(size).any() else size
    return found


def _errors(pairs, rows, tried, progress=SILENT):
    """The error (m,) of each of some pairs when left out."""
    return np.linalg.norm(predictions(pairs, rows, tried, progress) - pairs.rest[rows], axis=1)


def _between(pairs, rows):
    """Points (m, 3) of the deformed space between some landmarks and the nearest others."""
    near = nearest(pairs, np.arange(len(pairs)), _NEIGHBORS)[rows]
    start = pairs.deformed[rows, None]
    way = pairs.deformed[near] - start
    return np.concatenate([(start + share * way).reshape(-1, 3) for share in (0.25, 0.5, 0.75)])


def _checked(rest, deformed, names, weights):
    p = arguments.control_points("rest", rest)
    q = arguments.control_points("deformed", deformed)
    same_count(p, q)
    if len(p) < MIN_PAIRS:
        raise InputError(
            f"must have at least {MIN_PAIRS} pairs to predict each from the others, got {len(p)}",
            argument=("rest", "deformed"),
        )
    labels = tuple(map(str, range(1, len(p) + 1) if names is None else names))
    if len(labels) != len(p):
        raise ValueError(f"`names` must be one for each of the {len(p)} pairs, got {len(labels)}")
    for name, places in (("rest", p), ("deformed", q)):
        _, first, counts = np.unique(places, axis=0, return_index=True, return_counts=True)
        if (counts > 1).any():
            i = first[counts > 1].min()
            same = np.flatnonzero((places == places[i]).all(axis=1))
            raise InputError(
                f"must be distinct places, got {places[i].tolist()} for the pairs "
                f"`{labels[same[0]]}` and `{labels[same[1]]}`; remove one of them",
                argument=name,
            )
    return PointPairs(p, q, arguments.positive_weights(weights, len(p))), labels
