"""Landmarks moved to the best match of the images around them, by cross-correlation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base import interpolation, validation
from vtk_mls.base.grid import Grid, checked_grid
from vtk_mls.base.interpolation import linear_with_slopes
from vtk_mls.base.progress import ProgressLike, whole
from vtk_mls.base.validation import short_repr
from vtk_mls.queries.transform import Transform

RADIUS, SEARCH = 8.0, 6.0  # of the window and the search, in spacings of the target
MAX_STEPS = 40  # of the target's points, from the center of the window or the search to its rim
MIN_SCORE = 0.7
_MIN_CONTRAST = 0.02  # standard deviation in a window, in those of the whole image
_MIN_SHARE = 0.5  # of a window that must be inside of the image, and not in a void
# A match is not unique if places this far away, in points, come as near to 1 within this factor.
_FAR, _MAX_RATIO = 2.5, 1.1


@dataclass(frozen=True, eq=False, init=False)
class Image:
    """A gray image.

    Parameters
    ----------
    values : (nz, ny, nx) array_like
        Real numbers; those that are not finite count as outside of the image.
    grid : Grid
    """

    values: NDArray[Any]
    grid: Grid

    def __init__(self, values: ArrayLike, grid: Grid) -> None:
        array = np.asarray(values)
        if array.dtype.kind not in "biuf" or array.shape != checked_grid("grid", grid).shape:
            raise ValueError(
                f"`values` must be real numbers with the shape of `grid`, {grid.shape}, got "
                f"{short_repr(array)}"
            )
        # not `freeze`: the array stays writable, for it may be that of a dataset
        vars(self).update(values=array, grid=grid)


@dataclass(frozen=True, eq=False)
class Refinement:
    """The result of `refine` for n landmarks.

    Attributes
    ----------
    deformed : (n, 3) float64, world coordinates
        q: refined, or as before if the match is not trustworthy.
    match : (n, 3) float64, world coordinates
        The place of the best match, trustworthy or not; NaN without any.
    moved : (n,) float64, world units
        Distance from q before to q: 0 if refused.
    score_before, score : (n,) float64
        Normalized cross-correlation at q before, and at the match, from -1 to 1; NaN without any.
    refused : tuple of n str
        Why a match is not trustworthy; empty if it is.
    """

    deformed: NDArray[np.float64]
    match: NDArray[np.float64]
    moved: NDArray[np.float64]
    score_before: NDArray[np.float64]
    score: NDArray[np.float64]
    refused: tuple[str, ...]


def refine(
    moving: Image,
    target: Image,
    rest: ArrayLike,
    deformed: ArrayLike,
    *,
    deformation: Transform | None = None,
    radius: float | None = None,
    search: float | None = None,
    progress: ProgressLike = None,
) -> Refinement:
    """Move landmarks on the target to the best match of the moving image around them.

    A ball of the moving image around p, as it is and deformed by the map, is compared with the
    target around q by normalized cross-correlation; the better of the two counts. A landmark stays
    where it is if its match is not trustworthy: at the border of the search, with a low score, with
    other places that match as well, or where an image has no contrast.

    Parameters
    ----------
    moving, target : Image
        Of the same modality: bright is bright in both.
    rest, deformed : (n, 3) array_like, world coordinates
        p on the moving image, q on the target.
    deformation : Deformation or other transform, optional
        The current map. It gives the window its shape, and not its place, which is p.
    radius : float, > 0, world units, optional
        Of the window; 8 times the spacing of the target by default.
    search : float, > 0, world units, optional
        Largest distance to move along each axis of the target; 6 spacings by default.
    progress : callable, optional
        Called with the fraction done; a true return value stops with `Aborted`.

    Returns
    -------
    Refinement

    Raises
    ------
    ValueError, TypeError
        For an invalid image, place or length; the sentence names it.
    """
    p, q = validation.points("rest", rest), validation.points("deformed", deformed)
    validation.same_count(p, q)
    for name, image in (("moving", moving), ("target", target)):
        if not isinstance(image, Image):
            raise TypeError(f"`{name}` must be a landmarks.Image, got {short_repr(image)}")
    reach = _steps("radius", radius, RADIUS, target.grid)
    margin = _steps("search", search, SEARCH, target.grid)
    matcher = _Matcher(moving, target, deformation, reach, margin)
    with whole(progress) as part:
        matches = [matcher.match(p[i], q[i]) for i in part.over(range(len(q)))]
    refused = tuple(reason for *_, reason in matches)
    match = np.array([place for place, *_ in matches]).reshape(-1, 3)
    scores = np.array([scores for _, scores, _ in matches]).reshape(-1, 2)
    is_moved = np.array([not reason for reason in refused], bool)
    places = np.where(is_moved[:, None], match, q)
    moved = np.linalg.norm(places - q, axis=1)
    return Refinement(places, match, moved, scores[:, 0], scores[:, 1], refused)


def _steps(name, length, default, grid):
    """A length in points along each axis of a grid, (3,) ints; 0 along an axis of one point."""
    spacing = np.linalg.norm(grid.index_to_world, axis=0)
    is_flat = np.array(grid.dimensions) == 1
    if length is None:
        length = default * spacing[~is_flat].min() if (~is_flat).any() else default
    else:
        length = validation.positive(name, length)
    steps = np.where(is_flat, 0, np.maximum(np.rint(length / spacing), 2)).astype(int)
    if steps.max() > MAX_STEPS:
        raise ValueError(
            f"`{name}` must be at most {MAX_STEPS} spacings of the target, "
            f"{MAX_STEPS * spacing[~is_flat].min():.4g}, got {length:.4g}"
        )
    return steps


class _Matcher:
    """Finds the best match of windows of `reach` points within `margin` points of the target."""

    def __init__(self, moving, target, deformation, reach, margin):
        self._moving, self._target, self._deformation = moving, target, deformation
        self._reach, self._margin = reach, margin
        offsets = Grid(2 * reach + 1, origin=-reach).points()
        self._ball = ((offsets / np.maximum(reach, 1)) ** 2).sum(axis=1) <= 1 + 1e-9
        self._offsets = offsets @ target.grid.index_to_world.T
        self._contrast = [_MIN_CONTRAST * _deviation(image.values) for image in (moving, target)]

    def match(self, p, q):
        """The place (3,), the scores before and after, and why it is refused."""
        matches = [self._match_of(q, *self._window(places)) for places in self._origins(p, q)]
        return max(matches, key=lambda match: np.nan_to_num(match[1][1], nan=-2))

    def _match_of(self, q, window, weights):
        """As `match`, for one window."""
        no_match = np.full(3, np.nan), (np.nan, np.nan)
        if weights.sum() < _MIN_SHARE * self._ball.sum():
            return *no_match, "its window is outside of the moving image"
        mean = (weights * window).sum() / weights.sum()
        deviation = np.sqrt((weights * (window - mean) ** 2).sum() / weights.sum())
        if deviation <= self._contrast[0]:
            return *no_match, "the moving image has no contrast there"
        grid = self._target.grid
        center = np.rint(grid.index_of(q[None])[0]).astype(int)
        region, is_inside = self._region(center)
        score = _scores(window, weights, region, is_inside, self._contrast[1])
        if np.isnan(score).all():
            return *no_match, "the target ends or has no contrast there"
        at = np.array(np.unravel_index(np.nanargmax(score), score.shape))
        step, best = _peak(score, at)
        place = grid.at((center + (at + step)[::-1] - self._margin)[None])[0]
        before = grid.index_of(q[None]) - center + self._margin
        score_before = linear_with_slopes(np.where(np.isnan(score), -1.0, score), before)[0][0]
        return place, (float(score_before), best), _refusal(score, at, best)

    def _window(self, places):
        """Values of the moving image at places (NaN: none), and weights, in the window's shape."""
        values, grid = self._moving.values, self._moving.grid
        is_solid = self._ball & np.isfinite(places).all(axis=1)
        index = grid.index_of(np.where(is_solid[:, None], places, grid.origin))
        is_solid &= grid.covers(index)
        values = values.view(np.uint8) if values.dtype == bool else values
        window = interpolation.sample(values, index, "linear", 0, grid).astype(np.float64)
        is_solid &= np.isfinite(window)
        shape = tuple(2 * self._reach[::-1] + 1)
        window = np.where(is_solid, window, 0)
        return window.reshape(shape), is_solid.astype(np.float64).reshape(shape)

    def _origins(self, p, q):
        """Places (m, 3) of the window in the moving image: undeformed, and deformed by the map."""
        yield p + self._offsets
        if self._deformation is None:
            return
        places = q + self._offsets
        origins = self._deformation.backward(np.vstack([q, places]))
        origins += p - origins[0]
        if self._deformation.cuts:
            origins[1:][self._deformation.void(places)] = np.nan
        yield origins[1:]

    def _region(self, center):
        """Values of the target within reach of the window around a point, and a mask of inside."""
        steps, values = (self._reach + self._margin)[::-1], self._target.values
        index = [np.arange(c - n, c + n + 1) for c, n in zip(center[::-1], steps)]
        rows = [np.clip(i, 0, size - 1) for i, size in zip(index, values.shape)]
        region = values[np.ix_(*rows)].astype(np.float64)
        z, y, x = (i == row for i, row in zip(index, rows))
        is_inside = z[:, None, None] & y[:, None] & x & np.isfinite(region)
        return np.where(is_inside, region, 0), is_inside


def _refusal(score, at, best):
    """Why a match is not trustworthy; empty if it is."""
    last = np.array(score.shape) - 1
    is_wide = last > 0
    if ((at == 0) | (at == last))[is_wide].any():
        return "the best match is at the border of the search"
    around = score[tuple(slice(max(i - 1, 0), i + 2) for i in at)]
    if np.isnan(around).any():
        return "the best match is at the border of the target"
    if best < MIN_SCORE:
        return f"the best score, {best:.2f}, is below {MIN_SCORE}"
    distance = np.linalg.norm(np.moveaxis(np.indices(score.shape), 0, -1) - at, axis=-1)
    other = np.nanmax(np.where(distance >= _FAR, score, np.nan), initial=-1)
    if 1 - other < _MAX_RATIO * (1 - score[tuple(at)]):
        return "other places match as well"
    return ""


def _deviation(values):
    finite = values[np.isfinite(values)] if values.dtype.kind == "f" else values
    return float(finite.std(dtype=np.float64)) if finite.size else 0.0


def _scores(window, weights, region, is_inside, min_contrast):
    """Normalized cross-correlation of a window at all its places in a region: (d - a + 1, e - b +
    1, f - c + 1) for a window and weights (a, b, c) in a region (d, e, f).

    It is NaN where the window is not inside, or the region has less contrast than `min_contrast`.
    """
    count = weights.sum()
    values = window - (weights * window).sum() / count
    # sums of squares are of small numbers, which cancel less
    level = region[is_inside].mean() if is_inside.any() else 0.0
    centered = np.where(is_inside, region - level, 0)
    images = [centered, centered**2, ~is_inside]
    mean, square, outside = (_correlated(weights, image) for image in images)
    variance = square - mean**2 / count
    squares = (weights * values**2).sum()
    with np.errstate(invalid="ignore", divide="ignore"):
        score = _correlated(weights * values, centered) / np.sqrt(squares * variance)
    is_flat = variance <= count * max(min_contrast, 1e-9 * np.abs(centered).max()) ** 2
    return np.where(is_flat | (outside > 0.5), np.nan, np.clip(score, -1, 1))


def _correlated(window, region):
    """Sums of a window times a region, at all places of the window in the region."""
    shape, axes = region.shape, (0, 1, 2)
    spectrum = np.conj(np.fft.rfftn(window, shape, axes)) * np.fft.rfftn(region, shape, axes)
    valid = tuple(slice(n - m + 1) for n, m in zip(shape, window.shape))
    return np.fft.irfftn(spectrum, shape, axes)[valid]


def _peak(score, at):
    """The step (3,) from an index to the maximum of a quadratic function, and its value there.

    Its derivatives are differences of the points around the index; a step is at most 1.
    """
    step, best = np.zeros(3), float(score[tuple(at)])
    axes = np.flatnonzero(np.array(score.shape) > 1)
    around = np.pad(score, 1, constant_values=np.nan)[tuple(slice(i, i + 3) for i in at)]
    unit = np.eye(3, dtype=int)[axes]

    def value(offset):
        return around[tuple(1 + offset)]

    def mixed(a, b):
        if (a == b).all():
            return value(a) - 2 * best + value(-a)
        return (value(a + b) - value(a - b) - value(b - a) + value(-a - b)) / 4

    slope = np.array([value(a) - value(-a) for a in unit]) / 2
    curvature = np.array([[mixed(a, b) for b in unit] for a in unit])
    if not np.isfinite(curvature).all() or np.linalg.eigvalsh(curvature).max() >= 0:
        return step, best
    step[axes] = np.clip(-np.linalg.solve(curvature, slope), -1, 1)
    move = step[axes]
    top = best + slope @ move + move @ curvature @ move / 2
    return step, float(np.clip(top, best, 1))
