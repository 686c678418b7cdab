"""Point handles that a box turns together, and the path that they take."""

import numpy as np

from vtk_mls import Ball, RegionHandle
from vtk_mls.model.handles.handle_paths import along
from vtk_mls.model.handles.region import moved
from vtk_mls.model.handles.rigid_motion import screw
from vtk_mls.model.options import MAX_STEPS

_STAGE_ANGLE = np.radians(15)  # between intermediate places of a turn


class HandleGroup:
    """Point handles, rows (m,) at positions (m, 3), that turn about the center of their box.

    `bounds` (2, 3) are the box before the turn, and `motion` (4, 4) is the turn so far, in which
    angles above 180 degrees are the sum of small ones.
    """

    def __init__(self, rows, positions):
        self.rows, self.positions, self.motion = rows, positions, np.eye(4)
        self.bounds = np.array([positions.min(axis=0), positions.max(axis=0)])
        self._stages = [self.motion]

    def turn_to(self, motion):
        """Follow the box to a motion, by less than half a turn from the last one."""
        self.motion = motion
        while len(self._stages) > 1 and self._is_back():
            self._stages.pop()
        last = self._stages[-1]
        angle = _angle(last, motion)
        center = moved(last, self.bounds.mean(axis=0)[None])[0]
        rest = RegionHandle(Ball(center, 1), motion @ np.linalg.inv(last))
        for k in range(1, int(angle / _STAGE_ANGLE) + 1):
            self._stages.append(screw(rest, k * _STAGE_ANGLE / angle) @ last)

    def turned(self, state):
        """A copy of a `State` with these handles where the box has moved them.

        If they have turned by 15 degrees or more, the copy has their path.
        """
        if len(self._stages) == 1 and not len(state.path):
            return state.moved(self.rows, moved(self.motion, self.positions))
        motions = [*self._stages[1:], self.motion]
        places = [state.rest, *state.path, state.deformed]
        if not len(state.path) and state.is_resting[self.rows].all():
            places.pop()  # they start to turn where they rest
        before = [place[self.rows] for place in places]
        way = before + [moved(motion, self.positions) for motion in motions]
        return with_way(state, self.rows, way)

    def _is_back(self):
        before, last = self._stages[-2:]
        return _angle(before, self.motion) < _angle(before, last)


def with_way(state, rows, way):
    """A copy of a `State` whose handles `rows` go a way; the others go theirs in the same time.

    The way is a list of positions (m, 3) from rest to the deformed ones, at equal times. Anchored
    handles stay.
    """
    shares = np.linspace(0, 1, min(len(way), MAX_STEPS + 1))[1:]
    free = ~state.anchored[rows]
    places = [along([state.rest, *state.path, state.deformed], share) for share in shares]
    for place, share in zip(places, shares):
        place[rows[free]] = along(way, share)[free]
    return state.changed(deformed=places[-1], path=places[:-1])


def in_enough_steps(state):
    """A copy of a `State` with a path, in steps that do not fold at sampled points, or more."""
    if state.steps == 0 or not len(state.path) or state.is_identity:
        return state
    enough = state.changed(steps=0).deformation().steps_used
    return state.changed(steps=max(enough, state.steps))


def _angle(first, second):
    """The angle between two motions, in radians."""
    trace = np.einsum("ij,ij->", first[:3, :3], second[:3, :3])
    return np.arccos(np.clip((trace - 1) / 2, -1, 1))
