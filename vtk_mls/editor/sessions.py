"""Saving of edits, and sessions: everything that an editor shows, in one file."""

from contextlib import suppress

import numpy as np

from vtk_mls.base.progress import Aborted
from vtk_mls.editor import saving, state_values
from vtk_mls.editor.document import FAILURES, sentence_of
from vtk_mls.files import session_files
from vtk_mls.files.session_files import SessionFile

_INVALID = ValueError, KeyError, TypeError, IndexError, RecursionError, AttributeError
_CAMERA = "Position", "FocalPoint", "ViewUp"


def state_of(session, path):
    """The `State` of a `SessionFile` that was read from a path, which a ValueError names."""
    try:
        return state_values.decoded(session.edit)
    except _INVALID as error:
        reason = " ".join(str(error).split())
        raise ValueError(f"`{path}` is not a session: its edit is not valid ({reason})") from error


class Saving:
    """Base of `Editor` with the methods that save edits, and show sessions."""

    def save_session(self):
        """Save a session file, which opens again; whether it is saved."""
        self.finish()
        try:
            path = self._write_session()
        except (OSError, *FAILURES) as error:
            self.say(sentence_of(error))
            return False
        self.saver.session, self.saver.files = path, [path]
        self.document.note_save()
        self.say(f"The session is saved: vtk-mls view {path} opens it again.")
        self.document.draw()
        return True

    def save(self):
        """Save handles, data, field, picture, script and session; whether all are saved.

        Without handles the data are saved as they are, by a handle that rests.
        """
        self.finish()
        state = self.state
        if not len(state.enabled_only().grips):
            middle = self.scene.bounds.mean(axis=0)
            state = state.with_handle(middle, middle)
        self.document.show_deformed()
        self.view.draw_for_file(self.state)
        picture = saving.picture_of(self.scene.window)
        self.say("Saving ...")
        self.document.draw(is_moving=True)  # stays in the window while the files are written
        is_saved = False
        try:
            sentence = self.saver.save(state, picture)
            self.saver.files.append(self._write_session())
            is_saved = True
            self.document.note_save()
        except Aborted:
            sentence = "Saving was stopped; no file has changed."
        except (OSError, *FAILURES) as error:
            sentence = sentence_of(error)
        self.say(sentence)
        self.document.draw()
        return is_saved

    def resume_session(self, path, views):
        """Show the views of the session at a path, which the next save replaces by default."""
        self.saver.session = self.saver.session or path
        self.show_views(views)

    def show_views(self, views):
        """Show the camera, slices and comparison of a session; ignore values that are not valid."""
        with suppress(*_INVALID):
            camera = self.scene.renderer.GetActiveCamera()
            vectors = {name: [float(x) for x in views["camera"][name]] for name in _CAMERA}
            if all(len(v) == 3 and np.isfinite(v).all() for v in vectors.values()):
                for name, vector in vectors.items():
                    getattr(camera, f"Set{name}")(vector)
        with suppress(*_INVALID):
            if self.target is not None:
                mode, share = views["comparison"]
                self.set_comparison(mode=mode, share=float(share))
        with suppress(*_INVALID):
            if bool(views["slices"]) != self.slices.is_visible:
                self.toggle_slices()
            point = np.array(views["slice_point"], float)
            if point.shape == (3,) and np.isfinite(point).all():
                self.move_slices(point)
        self.document.show()

    def _write_session(self):
        """Write the session file, and return its path."""
        camera = self.scene.renderer.GetActiveCamera()
        edit = state_values.encoded(self.document.committed)
        path, data, target = self.saver.session_place()
        views = {
            "camera": {name: list(getattr(camera, f"Get{name}")()) for name in _CAMERA},
            "slices": self.slices.is_visible,
            "slice_point": self.slices.point.tolist(),
            "comparison": [self.comparison.mode, self.comparison.share],
        }
        session_files.write(path, SessionFile(tuple(data), target, edit, views))
        return path
