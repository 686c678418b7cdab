"""The edited value: handles, options of the map, cuts and mask."""

from __future__ import annotations

import functools
from dataclasses import dataclass, field, make_dataclass, replace

import numpy as np

from vtk_mls import BallMask, CurveHandle, Deformation, RegionHandle
from vtk_mls.editor import grips
from vtk_mls.model import kinds, options
from vtk_mls.model.handles.handle_paths import blended_path

_, _POLYNOMIAL = options.DEGREE.needs
_CHOSEN = ("order", "smoothing", "softening")  # options that may be automatic


@dataclass(frozen=True, eq=False)
class _Handles:
    rest: np.ndarray
    deformed: np.ndarray
    weights: np.ndarray | None = None
    labels: tuple = ()
    anchored: np.ndarray | None = None
    cuts: tuple = ()
    handles: tuple = ()
    mask: BallMask | None = None
    enabled: np.ndarray | None = None
    path: np.ndarray | None = None


# With the options, and their defaults in the editor.
_State = make_dataclass(
    "_State",
    [
        (option.name, type(option.default), field(default=option.interactive_default))
        for option in options.OPTIONS
    ],
    bases=(_Handles,),
    frozen=True,
    eq=False,
)


@dataclass(frozen=True, eq=False)
class State(_State):
    """Everything that an edit changes and undo restores.

    Attributes
    ----------
    rest, deformed : (n, 3) float64, world coordinates
        p and q of the point handles; n may be 0.
    weights : (n,) float64 or None
    labels : tuple of n str
    anchored : (n,) bool
        Whether the mouse cannot move a handle.
    enabled : (n,) bool
        Whether a point handle belongs to the map.
    path : (k, n, 3) float64, world coordinates
        Intermediate places of the point handles, at equal times; k is 0 if they go straight.
    cuts : tuple of Cut
    handles : tuple of RegionHandle and CurveHandle
    mask : BallMask or None
    kind, alpha, ...
        All of `options.OPTIONS`, with the defaults of the editor.
    """

    def __post_init__(self):
        if not isinstance(self.mask, (BallMask, type(None))):
            raise TypeError(f"`mask` must be a BallMask in the editor, got {self.mask!r}")
        count = len(self.rest)
        has_path = count > 0 and self.path is not None and len(self.path) > 0
        anchored = np.zeros(count, bool) if self.anchored is None else self.anchored
        enabled = np.ones(count, bool) if self.enabled is None else self.enabled
        for name, value in {
            "rest": np.array(self.rest, float).reshape(-1, 3),
            "deformed": np.array(self.deformed, float).reshape(-1, 3),
            "labels": tuple(self.labels) or ("",) * count,
            "anchored": np.array(anchored, bool),
            "enabled": np.array(enabled, bool),
            "path": np.array(self.path, float) if has_path else np.zeros((0, count, 3)),
            "cuts": tuple(self.cuts),
            "handles": tuple(self.handles),
        }.items():
            object.__setattr__(self, name, value)

    @classmethod
    def of(cls, deformation, labels=()):
        """The state of a Deformation; an error for constraints, and masks that are no balls."""
        if deformation.constraints:
            raise ValueError("`constraints` must be empty in the editor, which has none")
        settings = options.values_of(deformation, options.DEFORMATION_OPTIONS)
        weights = deformation.weights
        if weights is not None and (weights == 1).all():
            weights = None
        for name in ("cuts", "handles", "mask", "path"):
            settings[name] = getattr(deformation, name)
        return cls(deformation.rest, deformation.deformed, weights, labels, **settings)

    def __len__(self):
        return len(self.rest)

    @property
    def _times(self):
        """The times (k, 1, 1) of the intermediate places, from 0 to 1."""
        return np.linspace(0, 1, len(self.path) + 2)[1:-1, None, None]

    @property
    def is_resting(self):
        """Whether each point handle is at its rest position: (n,) bool."""
        return (self.rest == self.deformed).all(axis=1)

    @functools.cached_property
    def grips(self):
        """The points by which the mouse drags handles: `Grips`."""
        return grips.Grips.of(self)

    @property
    def regions(self):
        """The rigid regions among the handles."""
        return [handle for handle in self.handles if isinstance(handle, RegionHandle)]

    @property
    def is_identity(self):
        """Whether nothing moves."""
        return self.blend == 0 or bool(
            self.is_resting[self.enabled].all()
            and not len(self.path)
            and all(handle.is_resting for handle in self.handles)
        )

    def deformation(self):
        """The `Deformation`; None for the identity."""
        return self._deformation

    @functools.cached_property
    def _deformation(self):
        if self.is_identity:
            return None
        settings = options.values_of(self, options.DEFORMATION_OPTIONS)
        rest, deformed = self.rest[self.enabled], self.deformed[self.enabled]
        path = self.path[:, self.enabled]
        if self.blend != 1:
            deformed, path = blended_path(rest, deformed, path, self.blend)
        return Deformation(
            rest,
            deformed,
            weights=None if self.weights is None else self.weights[self.enabled],
            cuts=self.cuts,
            handles=[handle.blended(self.blend) for handle in self.handles],
            mask=self.mask,
            path=path,
            **settings,
        )

    def with_chosen_settings(self):
        """A copy whose automatic settings are those of now: numbers, for a drag."""
        if self.kind != "auto" and self.smoothing >= 0 and (self.kind != "spline" or self.order):
            return self
        deformation = self.deformation()
        if deformation is None:
            return self
        chosen = {name: getattr(deformation, f"{name}_used") for name in _CHOSEN}
        return replace(self, kind=deformation.kind, **chosen)

    def with_settings_of(self, state):
        """A copy with the kind of another state, and the settings that are chosen with it."""
        return replace(self, **{name: getattr(state, name) for name in ("kind", *_CHOSEN)})

    def changed(self, **values):
        """A copy with other values of some attributes."""
        return replace(self, **values)

    def with_next_kind(self):
        """A copy with the next kind of map; polynomials have degree 2, then 3."""
        if self.kind == _POLYNOMIAL and self.degree < max(options.DEGREE.choices):
            return replace(self, degree=self.degree + 1)
        names = [*(kinds.KINDS if self.cuts or self.regions else kinds.ALL_KINDS)]
        index = names.index(self.kind) if self.kind in names else -1
        kind = names[(index + 1) % len(names)]
        return replace(self, kind=kind, degree=options.DEGREE.default)

    def with_smoothing_times(self, factor, minimum):
        """A copy whose smoothing is multiplied: from 0 up to `minimum`, from there down to 0."""
        value = self.smoothing * factor
        if value < 0.99 * minimum:
            value = minimum if factor > 1 else 0.0
        return replace(self, smoothing=float(f"{value:.3g}"))

    def moved(self, rows, positions):
        """A copy with grips `rows` at other positions (m, 3); anchored ones stay."""
        table, rows = self.grips, np.asarray(rows, int)
        is_free = ~table.anchored[rows]
        rows, deformed = rows[is_free], table.deformed.copy()
        deformed[rows] = np.asarray(positions, float)[is_free]
        owners, handles, mask = table.owner[rows], list(self.handles), self.mask
        for index in np.unique(owners[owners >= 0]).tolist():
            handles[index] = handles[index].with_grips(deformed[table.rows_of(index)])
        if grips.MASK in owners:
            row = rows[owners == grips.MASK].min()  # its place before its radius and fall-off
            mask = grips.moved_mask(mask, table.part[row], deformed[row])
        deformed = deformed[: len(self)]
        path = self.path + self._times * (deformed - self.deformed)
        return replace(self, deformed=deformed, handles=handles, mask=mask, path=path)

    def at_rest(self):
        """A copy with all handles at rest."""
        handles = [handle.blended(0.0) for handle in self.handles]
        return replace(self, deformed=self.rest, handles=handles, path=None)

    def with_handle(self, rest, deformed):
        """A copy with one more handle, the last."""
        straight = rest + self._times * np.subtract(deformed, rest)
        return replace(
            self,
            path=np.concatenate([self.path, straight], axis=1),
            rest=np.vstack([self.rest, rest]),
            deformed=np.vstack([self.deformed, deformed]),
            weights=None if self.weights is None else np.append(self.weights, 1.0),
            labels=(*self.labels, ""),
            anchored=np.append(self.anchored, False),
            enabled=np.append(self.enabled, True),
        )

    def with_shape(self, handle, index=None):
        """A copy with another region or curve at an index, or with one more."""
        handles = list(self.handles)
        if index is None:
            handles.append(handle)
        else:
            handles[index] = handle
        return replace(self, handles=handles)

    def without(self, rows):
        """A copy without grips `rows`; curves with fewer than two nodes left are removed."""
        table, rows = self.grips, np.asarray(rows, int)
        owners, remaining = table.owner[rows], np.setdiff1d(np.arange(len(self)), rows)
        handles = []
        for index, handle in enumerate(self.handles):
            nodes = np.setdiff1d(table.rows_of(index), rows)
            if index not in owners:
                handles.append(handle)
            elif len(nodes) > 1:
                handles.append(CurveHandle(table.rest[nodes], table.deformed[nodes]))
        return replace(
            self,
            rest=self.rest[remaining],
            deformed=self.deformed[remaining],
            weights=None if self.weights is None else self.weights[remaining],
            labels=tuple(self.labels[i] for i in remaining),
            anchored=self.anchored[remaining],
            enabled=self.enabled[remaining],
            path=self.path[:, remaining],
            handles=handles,
            mask=None if grips.MASK in owners else self.mask,
        )

    def with_name(self, row, name):
        """A copy with another name of the point handle `row`."""
        labels = [*self.labels]
        labels[row] = name
        return replace(self, labels=tuple(labels))

    def with_rest(self, row, position):
        """A copy with the rest position (3,) of the grip `row` changed; no region, no mask."""
        owner, rest = self.grips.owner[row], self.grips.rest.copy()
        rest[row] = position
        if owner == grips.POINT:
            rest = rest[: len(self)]
            path = self.path + (1 - self._times) * (rest - self.rest)
            return replace(self, rest=rest, path=path)
        handle = self.handles[owner] if owner >= 0 else None
        if not isinstance(handle, CurveHandle):
            raise ValueError(
                "only points and nodes of curves have a rest position that can be changed"
            )
        nodes = rest[self.grips.rows_of(owner)]
        return self.with_shape(CurveHandle(nodes, handle.deformed), owner)

    def with_anchors(self, rows):
        """A copy with point handles `rows` anchored; free if all of them were anchored."""
        anchored = self.anchored.copy()
        anchored[rows] = not anchored[rows].all()
        return replace(self, anchored=anchored)

    def with_enabled(self, rows, are_enabled):
        """A copy with point handles `rows` in the map, or left out of it."""
        enabled = self.enabled.copy()
        enabled[rows] = are_enabled
        return replace(self, enabled=enabled)

    def enabled_only(self):
        """A copy without the landmarks that are left out."""
        return self.without(np.flatnonzero(~self.enabled))

    def with_handles_at(self, rest):
        """A copy with other point handles (n, 3), all at rest."""
        others = {"weights": None, "labels": (), "anchored": None, "enabled": None, "path": None}
        return replace(self, rest=rest, deformed=rest, **others)

    @property
    def flat_cut(self):
        """The last cut by numbers, which the widget moves; None without."""
        flat = [cut for cut in self.cuts if cut.labels()]
        return flat[-1] if flat else None

    def with_flat_cut(self, flat_cut):
        """A copy with another flat cut, or without one for None."""
        cuts = [cut for cut in self.cuts if cut is not self.flat_cut]
        return replace(self, cuts=cuts if flat_cut is None else [*cuts, flat_cut])
