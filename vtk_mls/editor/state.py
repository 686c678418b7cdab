"""What is edited: handles, the map they make and its cuts, as a value."""

from __future__ import annotations

from dataclasses import dataclass, field, make_dataclass, replace

import numpy as np

from vtk_mls import Deformation, kinds
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
    """All that an edit changes and an undo brings back.

    Attributes
    ----------
    rest, deformed : (n, 3) float64, world coordinates
        p and q; there may be none.
    weights : (n,) float64 or None
    labels : tuple of n str
    anchored : (n,) bool
        Handles that the mouse does not move.
    cuts : tuple of Cut
    kind, alpha, ...
        Each of `options.OPTIONS`, with the default of the editor.
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
        """The state whose map is a Deformation."""
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
        """Which handles have not been moved: (n,) bool."""
        return (self.rest == self.deformed).all(axis=1)

    def deformation(self):
        """The `Deformation`; None if nothing moves."""
        if self.is_resting.all() or self.blend == 0:
            return None
        settings = options.values_of(self, options.DEFORMATION_OPTIONS)
        deformed = self.rest + self.blend * (self.deformed - self.rest)
        deformed = self.deformed if self.blend == 1 else deformed
        return Deformation(self.rest, deformed, weights=self.weights, cuts=self.cuts, **settings)

    def changed(self, **values):
        """The same but for some attributes."""
        return replace(self, **values)

    def with_next_kind(self):
        """The same with maps of the next kind."""
        names = list(kinds.KINDS)
        return replace(self, kind=names[(names.index(self.kind) + 1) % len(names)])

    def with_alpha_times(self, factor):
        """The same with handles that act more or less locally."""
        return replace(self, alpha=options.ALPHA.limited(self.alpha * factor, self.alpha))

    def with_nu_times(self, factor):
        """The same with influence that fades more or less with the detour around cuts."""
        return replace(self, nu=options.NU.limited(1 + (self.nu - 1) * factor, self.nu))

    def moved(self, rows, positions):
        """The same with some handles at other positions (m, 3); anchored ones stay."""
        deformed, rows = self.deformed.copy(), np.asarray(rows, int)
        free = ~self.anchored[rows]
        deformed[rows[free]] = np.asarray(positions, float)[free]
        return replace(self, deformed=deformed)

    def at_rest(self):
        """The same with all handles back where they were laid."""
        return replace(self, deformed=self.rest)

    def with_handle(self, rest, deformed):
        """The same with one more, the last."""
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
        """The same with fewer handles."""
        kept = np.setdiff1d(np.arange(len(self)), rows)
        return replace(
            self,
            rest=self.rest[kept],
            deformed=self.deformed[kept],
            weights=None if self.weights is None else self.weights[kept],
            labels=tuple(self.labels[i] for i in kept),
            anchored=self.anchored[kept],
        )

    def with_anchors(self, rows):
        """The same with some handles anchored, or all of these free if they were."""
        anchored = self.anchored.copy()
        anchored[rows] = not anchored[rows].all()
        return replace(self, anchored=anchored)

    def with_handles_at(self, rest):
        """The same map with other handles (n, 3), all at rest."""
        return replace(self, rest=rest, deformed=rest, weights=None, labels=(), anchored=None)
