"""Unsaved edits, in one file per data file; the next session offers them."""

import hashlib
import json
import os
import time
from contextlib import suppress
from pathlib import Path

from vtk_mls.editor import state_values
from vtk_mls.engine.device import caches
from vtk_mls.files.paths import replacing

_FOLDER = "vtk_mls", "unsaved"


class Autosave:
    """The unsaved state of one data file.

    Its file is in `folder`, by default in the cache folder of the user, and named after the path of
    the data, or after a `digest` of their bytes if the path is temporary. `offered` is an unsaved
    `State` of an earlier session, until it is restored or deleted, or until a save.
    """

    def __init__(self, path, folder=None, digest=None):
        self._path = os.path.abspath(path) if digest is None else digest
        cache = caches.folder()
        folder = folder or (cache and cache.joinpath(*_FOLDER))
        name = hashlib.sha256(self._path.encode()).hexdigest()[:16]
        self._file = folder and Path(folder) / f"{name}.json"
        self.offered, self._offered_time = self._read() or (None, None)
        self._unsaved = None  # state of this session

    def store(self, state):
        """Write the unsaved `state` of this session, None for none. OSErrors name the file."""
        self._unsaved = state
        if state is None:
            state = self.offered
        if state is None:
            self._remove()
            return
        if self._file is None:
            raise OSError("there is no cache folder for unsaved edits; save them with S")
        self._file.parent.mkdir(parents=True, exist_ok=True)
        with replacing(self._file) as new:
            values = {"path": self._path, **state_values.encoded(state)}
            new.write_text(json.dumps(values), encoding="utf-8")

    def note_save(self):
        """Delete the file after a save, and end the offer."""
        self.offered = self._unsaved = None
        self._remove()

    def delete_offer(self):
        """End the offer, and delete its state."""
        self.offered = None
        if self._unsaved is None:
            self._remove()

    @property
    def offer(self):
        """A sentence about the offered state; empty without one."""
        if self.offered is None:
            return ""
        saved_at = time.strftime("%d %B, %H:%M", time.localtime(self._offered_time))
        count = len(self.offered) + len(self.offered.handles)
        handles = "1 handle" if count == 1 else f"{count} handles"
        return f"{handles} of {saved_at}, not saved: Return restores them, N deletes them."

    def _read(self):
        """The state in the file, and its time in seconds; None if the file is not readable."""
        if self._file is not None:
            with suppress(OSError, ValueError, KeyError, TypeError, RecursionError):
                values = json.loads(self._file.read_text(encoding="utf-8"))
                return state_values.decoded(values), self._file.stat().st_mtime
        return None

    def _remove(self):
        if self._file is not None:
            with suppress(OSError):
                self._file.unlink()
