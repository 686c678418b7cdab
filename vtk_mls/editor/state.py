"""The edited value: handles, options of the map, and cuts."""

from __future__ import annotations

from dataclasses import dataclass, field, make_dataclass, replace

import numpy as np

from vtk_mls import Deformation, HalfPlane, Plane, kinds
from vtk_mls.model import options

# The options, with the defaults of the editor.
_Options = make_dataclass(
    "_Options",
    [
        (option.name, type(option.default), field(default=option.interactive_default))
        for option in options.OPTIONS
    ],
    frozen=True,
    eq=False,
    kw_only=True,
)


@dataclass(frozen=True, eq=False)
class State(_Options):
    """Everything that an edit changes and undo restores.

    Attributes
    ----------
    rest, deformed : (n, 3) float64, world coordinates
        p and q; n may be 0.
    weights : (n,) float64 or None
    labels : tuple of n str
    anchored : (n,) bool
        Whether the mouse cannot move a handle.
    cuts : tuple of Cut
    kind, alpha, ...
        All of `options.OPTIONS`, with the defaults of the editor.
    """

    rest: np.ndarray
    deformed: np.ndarray
    weights: np.ndarray | None = None
    labels: tuple = ()
    anchored: np.ndarray | None = None
    cuts: tuple = ()

    def __post_init__(self):
        count = len(self.rest)
        anchored = np.zeros(count, bool) if self.anchored is None else self.anchored
        for name, value in {
            "rest": np.array(self.rest, float).reshape(-1, 3),
            "deformed": np.array(self.deformed, float).reshape(-1, 3),
            "labels": tuple(self.labels) or ("",) * count,
            "anchored": np.array(anchored, bool),
            "cuts": tuple(self.cuts),
        }.items():
            object.__setattr__(self, name, value)

    @classmethod
    def of(cls, deformation, labels=()):
        """The state of a Deformation."""
        settings = options.values_of(deformation, options.DEFORMATION_OPTIONS)
        weights = deformation.weights
        if weights is not None and (weights == 1).all():
            weights = None
        cuts = deformation.cuts
        return cls(deformation.rest, deformation.deformed, weights, labels, cuts=cuts, **settings)

    def __len__(self):
        return len(self.rest)

    @property
    def is_resting(self):
        """Whether each handle is at its rest position: (n,) bool."""
        return (self.rest == self.deformed).all(axis=1)

    def deformation(self):
        """The `Deformation`; None for the identity."""
        if self.is_resting.all() or self.blend == 0:
            return None
        settings = options.values_of(self, options.DEFORMATION_OPTIONS)
        deformed = self.rest + self.blend * (self.deformed - self.rest)
        deformed = self.deformed if self.blend == 1 else deformed
        return Deformation(self.rest, deformed, weights=self.weights, cuts=self.cuts, **settings)

    def changed(self, **values):
        """A copy with other values of some attributes."""
        return replace(self, **values)

    def with_next_kind(self):
        """A copy with the next kind of map."""
        names = list(kinds.KINDS)
        return replace(self, kind=names[(names.index(self.kind) + 1) % len(names)])

    def with_alpha_times(self, factor):
        """A copy whose alpha is multiplied, within the range of its slider."""
        return replace(self, alpha=options.ALPHA.limited(self.alpha * factor, self.alpha))

    def with_smoothing_times(self, factor, smallest):
        """A copy whose smoothing is multiplied: from 0 up to `smallest`, from there down to 0."""
        value = self.smoothing * factor
        if value < 0.99 * smallest:
            value = smallest if factor > 1 else 0.0
        return replace(self, smoothing=float(f"{value:.3g}"))

    def with_nu_times(self, factor):
        """A copy whose nu - 1 is multiplied, within the range of its slider."""
        return replace(self, nu=options.NU.limited(1 + (self.nu - 1) * factor, self.nu))

    def moved(self, rows, positions):
        """A copy with handles `rows` at other positions (m, 3); anchored ones stay."""
        deformed, rows = self.deformed.copy(), np.asarray(rows, int)
        free = ~self.anchored[rows]
        deformed[rows[free]] = np.asarray(positions, float)[free]
        return replace(self, deformed=deformed)

    def at_rest(self):
        """A copy with all handles at rest."""
        return replace(self, deformed=self.rest)

    def with_handle(self, rest, deformed):
        """A copy with one more handle, the last."""
        weights = None if self.weights is None else np.append(self.weights, 1.0)
        return replace(
            self,
            rest=np.vstack([self.rest, rest]),
            deformed=np.vstack([self.deformed, deformed]),
            weights=weights,
            labels=(*self.labels, ""),
            anchored=np.append(self.anchored, False),
        )

    def without(self, rows):
        """A copy without handles `rows`."""
        remaining = np.setdiff1d(np.arange(len(self)), rows)
        return replace(
            self,
            rest=self.rest[remaining],
            deformed=self.deformed[remaining],
            weights=None if self.weights is None else self.weights[remaining],
            labels=tuple(self.labels[i] for i in remaining),
            anchored=self.anchored[remaining],
        )

    def with_anchors(self, rows):
        """A copy with handles `rows` anchored; free if all of them were anchored."""
        anchored = self.anchored.copy()
        anchored[rows] = not anchored[rows].all()
        return replace(self, anchored=anchored)

    def with_handles_at(self, rest):
        """A copy with other handles (n, 3), all at rest."""
        return replace(self, rest=rest, deformed=rest, weights=None, labels=(), anchored=None)

    @property
    def flat_cut(self):
        """The last Plane or HalfPlane among the cuts, which the widget moves; None without."""
        flat = [cut for cut in self.cuts if isinstance(cut, (Plane, HalfPlane))]
        return flat[-1] if flat else None

    def with_flat_cut(self, flat_cut):
        """A copy with another such cut, or without it for None."""
        cuts = [cut for cut in self.cuts if cut is not self.flat_cut]
        return replace(self, cuts=cuts if flat_cut is None else [*cuts, flat_cut])
