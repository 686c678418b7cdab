"""Points, rigid regions and curves together, as the fits sum them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vtk_mls.model.handles.curve import INTEGRATED_ALPHAS, CurveHandle, Segments
from vtk_mls.model.handles.region import RegionHandle


@dataclass(frozen=True, eq=False)
class HandleSet:
    """Control points, among them the proxies of regions, and segments of curves.

    The proxies of each region come one after the other, then points.
    """

    rest: np.ndarray  # (n, 3), world coordinates
    deformed: np.ndarray
    weights: np.ndarray  # (n,); those of the proxies of a region add up to 1
    region: np.ndarray  # (n,): row of the region that a proxy is of; -1 for a point
    regions: tuple[RegionHandle, ...]
    segments: Segments
    path: np.ndarray  # (n, k, 3): intermediate places of points; without a meaning for proxies
    rest_anchors: np.ndarray | None = None  # of `anchors` of steps, (n + s, 3)

    @classmethod
    def of(cls, rest, deformed, weights, handles=(), kind=None, alpha=1, path=None) -> HandleSet:
        """Points `rest` and `deformed` (n, 3) with `weights` (n,), and the `handles`.

        `path` (k, n, 3) are intermediate places of the points.

        Proxies determine polynomials of the `proxy_order` of the `kind`. Segments whose weights
        have no integral in closed form for `alpha`, and those of splines, are replaced by points
        along them.
        """
        regions = tuple(handle for handle in handles if isinstance(handle, RegionHandle))
        proxies = [region.proxies(kind.proxy_order) for region in regions]
        segments = Segments.of([handle for handle in handles if isinstance(handle, CurveHandle)])
        path = np.zeros((0, len(rest), 3)) if path is None else path
        is_local = kind is None or kind.is_local
        if alpha not in INTEGRATED_ALPHAS or not is_local:
            more = p, q, _ = segments.quadrature() if is_local else segments.evenly()
            rest, deformed, weights = map(np.concatenate, zip((rest, deformed, weights), more))
            shares = np.arange(1, len(path) + 1)[:, None, None] / (len(path) + 1)
            path = np.concatenate([path, p + shares * (q - p)], axis=1)
            segments = Segments.of([])
        return cls(
            np.concatenate([*(p for p, _ in proxies), rest]),
            np.concatenate([*(q for _, q in proxies), deformed]),
            np.concatenate([*(np.full(len(p), 1 / len(p)) for p, _ in proxies), weights]),
            np.repeat([*range(len(regions)), -1], [*(len(p) for p, _ in proxies), len(rest)]),
            regions,
            segments,
            np.concatenate([*(np.tile(p, (len(path), 1, 1)) for p, _ in proxies), path], axis=1)
            .swapaxes(0, 1)
            .copy(),
        )

    def __len__(self) -> int:
        return len(self.rest)

    @property
    def positions(self) -> tuple[np.ndarray, np.ndarray]:
        """All points and proxies, then samples of segments (k, 3), at rest and deformed."""
        rest, deformed = self.segments.samples
        return np.concatenate([self.rest, rest]), np.concatenate([self.deformed, deformed])

    @property
    def anchors(self) -> tuple[np.ndarray, np.ndarray]:
        """Where cuts see control points, then segments (n + s, 3), at rest and deformed.

        They see regions at their center, and segments in their middle: so the proxies of a region
        share the damping of Eq. 28, as do the points of a segment.
        """
        anchors = self.rest.copy(), self.deformed.copy()
        for row, region in enumerate(self.regions):
            for places, center in zip(anchors, region.center):
                places[self.region == row] = center
        rest, deformed = (np.concatenate(pair) for pair in zip(anchors, self.segments.middles))
        return rest if self.rest_anchors is None else self.rest_anchors, deformed

    @property
    def term_count(self) -> int:
        """Number of regions and points."""
        return len(self.regions) + int((self.region < 0).sum())

    @property
    def proxy_count(self) -> int:
        """The largest number of proxies of a region; 0 without regions."""
        return int(np.bincount(self.region[self.region >= 0], minlength=1).max())

    @property
    def term_anchors(self) -> tuple[np.ndarray, np.ndarray]:
        """The `anchors`, with one row for each region."""
        rows = np.ones(len(self) + len(self.segments), bool)
        rows[1 : len(self)] = (self.region[1:] < 0) | (np.diff(self.region) != 0)
        rest, deformed = self.anchors
        return rest[rows], deformed[rows]

    def means(self, values: np.ndarray) -> np.ndarray:
        """Weighted means (terms, k) of `values` (n, k) of regions, then the values of points."""
        points = values[self.region < 0]
        if not self.regions:
            return points
        regions = [self._mean(values, self.region == i) for i in range(len(self.regions))]
        return np.concatenate([regions, points])

    def centered(self, values: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Values at some `rows` less their weighted mean."""
        return values[rows] - self._mean(values, rows)

    def _mean(self, values, rows):
        return np.average(values[rows], axis=0, weights=self.weights[rows])

    @property
    def swapped(self) -> HandleSet:
        """The set with rest and deformed swapped."""
        return HandleSet(
            self.deformed,
            self.rest,
            self.weights,
            self.region,
            tuple(region.swapped for region in self.regions),
            self.segments.swapped,
            self.path[:, ::-1],
        )

    def split_by(self, cuts, in_rest_frame) -> HandleSet:
        """The set with its segments split at `cuts`, which have an edge."""
        segments = self.segments
        for cut in cuts:
            segments = segments.split_by(cut, in_rest_frame)
        return replace(self, segments=segments)

    def on_side(self, height, side, in_rest_frame) -> HandleSet:
        """The points, regions and parts of segments on a `side`, 1 or -1, of a plane.

        `height` is a function of points (k, 3) of the rest or the deformed space; a region is where
        its anchor is. The plane itself is of side 1.
        """
        frame = 0 if in_rest_frame else 1
        rows = (height(self.anchors[frame][: len(self)]) < 0) == (side < 0)
        indices = np.unique(self.region[rows & (self.region >= 0)])
        new_index = np.full(len(self.regions) + 1, -1)  # the last, -1, for points
        new_index[indices] = np.arange(len(indices))
        return HandleSet(
            self.rest[rows],
            self.deformed[rows],
            self.weights[rows],
            new_index[self.region[rows]],
            tuple(self.regions[i] for i in indices),
            self.segments.on_side(height, side, in_rest_frame),
            self.path[rows],
        )
