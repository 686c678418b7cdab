"""The mouse over two sides: it places landmarks, and corrects them on the moving data."""

import numpy as np

from vtk_mls.editor.mouse import Mouse


class MatchingMouse(Mouse):
    """A `Mouse` whose clicks beside handles place landmarks if there is a target."""

    def __init__(self, interactor, editor):
        self._editor, self._corrects_rest = editor, False
        super().__init__(interactor, editor.document, editor.tools, editor.enlarge)

    def _grab(self, row, keeps_selection):
        super()._grab(row, keeps_selection)
        view, document = self._view, self._document
        is_on_data = view.has_data_at(self.pixel) and not view.shows_both_at(self.pixel)
        are_points = document.dragged.max() < len(document.state)
        self._corrects_rest = view.target is not None and is_on_data and are_points

    def _click_beside(self):
        if self._view.target is None:
            return False
        self._document.say("")
        with self._document.reporting_errors():
            self._editor.place_at(self.pixel)
        self._document.draw(is_moving=True)
        return True

    def _drag_to(self, positions):
        """On the data, landmarks are corrected: the data do not follow."""
        if not self._corrects_rest:
            super()._drag_to(positions)
            return
        self._view.target.dragged = self._document.dragged, positions
        self._document.draw(is_moving=True)

    def _end_drag(self):
        if self._view.target is not None and self._view.target.dragged is not None:
            self._correct_rest()
        super()._end_drag()

    def _correct_rest(self):
        """Move p of dragged landmarks to where they are let go on the data."""
        target, state = self._view.target, self._document.state
        (rows, places), target.dragged = target.dragged, None
        deformation, is_free = self._view.distortion.deformation, ~state.anchored[rows]
        places = places if deformation is None else deformation.backward(places)
        if not np.isfinite(places[is_free]).all():
            self._document.say("There are no data at this place, which a cut has opened.")
            return
        for row, place in zip(rows[is_free], places[is_free]):
            state = state.with_rest(row, place)
        self._document.change(state)
