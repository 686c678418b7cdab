"""The edits of an editor that concern pairs of landmarks and the target."""

from dataclasses import replace

import numpy as np

from vtk_mls.base.progress import Aborted
from vtk_mls.editor import grips
from vtk_mls.editor.document import NO_SURFACE
from vtk_mls.editor.matching.pairs import MOVING, TARGET, key_of, refined_pairs, with_pair
from vtk_mls.editor.matching.target import Target
from vtk_mls.landmarks.text import refinement_sentence

_SHARE_STEP = 0.1  # of the target, at each key


class PairEdits:
    """Base of `Editor` with the methods for a second side, and landmarks on both.

    `target` is a `Target` or None; `scores` are scores of matches and why they are refused, by
    `pairs.key_of`.
    """

    target = None

    @property
    def comparison(self):
        """How both sides are drawn: `Comparison`."""
        return self.view.comparison

    def set_target(self, target):
        """Show another `Target` or vtkDataSet, or none for None; all pairs stay."""
        self.target = target if isinstance(target, (Target, type(None))) else Target(target)
        self.view.set_target(self.target)
        self.saver.target = self.target
        self.document.show()

    def place_at(self, pixel):
        """Place a landmark where the data, or the target, are at a pixel."""
        point = self.view.point_at(pixel)
        if point is None:
            self.say(NO_SURFACE)
        else:
            self.place(self.view.side_at(pixel), point)

    def place(self, side, point):
        """Place a landmark on a side, and its partner where the present map says.

        `side` is MOVING or TARGET, and the point (3,) is on the deformed data as they are drawn, or
        on the target.
        """
        point = np.array(point, float)
        rest = self._at_rest(point) if side == MOVING else None
        self.document.show_deformed()
        deformation = self.view.distortion.deformation
        if side == TARGET:
            rest, deformed = self._at_rest(point), point
        else:
            deformed = rest if deformation is None else deformation.forward([rest])[0]
        if not np.isfinite([rest, deformed]).all():
            self.say("There are no data at this place, which a cut has opened.")
        elif self.change(with_pair(self.state, rest, deformed)):
            self.document.selected = np.array([len(self.state) - 1])
            self.document.move_slices(deformed)
            name = self.state.labels[-1]
            self.say(f"Landmark {name} is on both sides. Drag it to its place where it is wrong.")

    def _at_rest(self, point):
        """p of a point (3,) of the drawn data."""
        deformation = self.view.distortion.deformation
        return point if deformation is None else deformation.backward([point])[0]

    def set_enabled(self, rows, are_enabled):
        """Let point handles belong to the map, or leave them out of it."""
        self.change(self.state.with_enabled(rows, are_enabled))

    def toggle_enabled(self):
        """Leave the selected point handles out of the map, or include them if all are out."""
        rows = self.document.target_rows()
        points = rows[rows < len(self.state)]
        if len(points):
            self.set_enabled(points, not self.state.enabled[points].any())
        elif len(rows):
            self.say("Only point handles can be left out; X deletes others.")

    def delete_pairs(self, rows):
        """Delete point handles."""
        self.document.clear_selection()
        self.change(self.state.without(rows))

    def jump_to(self, row):
        """Select a point handle, and move slices and cameras to it."""
        point = self.state.deformed[row]
        self.document.select([row])
        self.view.center_on(point)
        self.document.move_slices(point)

    def jump_by(self, step):
        """Jump to the next pair (1) or the previous one (-1)."""
        count = len(self.state)
        if not count:
            self.say("There are no pairs yet.")
            return
        points = self.selected[self.selected < count]
        first = 0 if step > 0 else count - 1
        self.jump_to(int(points[-1] + step) % count if len(points) else first)

    def refine(self, rows=None, progress=None):
        """Move landmarks to the best match of the images around them, where it is trustworthy.

        `rows` are by default the selected pairs, or that under the mouse; `progress` is as of
        `landmarks.refine`.
        """
        if self.target is None:
            self.say("There is no target to refine landmarks on: `--target FILE` names it.")
            return
        rows = self.document.target_rows() if rows is None else rows
        state, rows = self.state, [int(row) for row in rows if row < len(self.state)]
        rows = [row for row in rows if not state.anchored[row]]
        if not rows:
            self.say("There are no pairs to refine, or they are fixed.")
            return
        self.say("Refining ...")
        self.document.draw(is_moving=True)
        datasets = self.saver.datasets[0], self.target.dataset
        try:
            refined, found = refined_pairs(state, datasets, rows, progress)
        except Aborted:
            self.say("Refining was stopped; no landmark has moved.")
            return
        if found.moved.any() and not self.change(refined):
            return
        for i, row in enumerate(rows):
            self.scores[key_of(self.state, row)] = float(found.score[i]), found.refused[i]
        names = [grips.names_of(state)[row] for row in rows]
        self.say(refinement_sentence(found, names))

    def refine_all(self, progress=None):
        """Refine all pairs of the map, as of `refine`."""
        self.refine(np.flatnonzero(self.state.enabled), progress)

    def set_comparison(self, **values):
        """Change `mode` and `share` of the comparison; ValueError for those of no `Comparison`."""
        comparison = replace(self.comparison, **values)
        if self.target is not None:
            self.view.set_comparison(comparison)
        else:
            self.say("There is no target to compare with: `--target FILE` of the command names it.")
        self.document.show()

    def compare_by(self, mode):
        """Draw both sides by one of `target.MODES`."""
        self.set_comparison(mode=mode)

    def change_share(self, count):
        """Show more of the target (1) or less of it (-1) where it fades."""
        share = float(np.clip(self.comparison.share + count * _SHARE_STEP, 0, 1))
        self.set_comparison(share=round(share, 6))
