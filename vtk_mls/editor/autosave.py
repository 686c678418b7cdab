"""Keeps unsaved edits in one file per data file; the next session offers them."""

from __future__ import annotations

import hashlib
import json
import os
import time
from contextlib import suppress
from pathlib import Path

import numpy as np

from vtk_mls.editor import json_values
from vtk_mls.editor.pairs import Pending
from vtk_mls.editor.state import State
from vtk_mls.engine.device import caches
from vtk_mls.files.paths import replacing
from vtk_mls.model import options

_FOLDER = "vtk_mls", "unsaved"


class Autosave:
    """The unsaved state of one data file.

    Parameters
    ----------
    path : path
        Of the data file.
    folder : path, optional
        Of the autosave files; by default in the cache folder of the user.
    digest : str, optional
        Of the bytes of the data, instead of the path of a temporary file.

    Attributes
    ----------
    offered : State or None
        Unsaved state of an earlier session, until it is restored or dropped, or a save ends it.
    """

    def __init__(self, path, folder=None, digest=None):
        self._path = os.path.abspath(path) if digest is None else digest
        cache = caches.folder()
        folder = folder or (cache and cache.joinpath(*_FOLDER))
        name = hashlib.sha256(self._path.encode()).hexdigest()[:16]
        self._file = folder and Path(folder) / f"{name}.json"
        self.offered, self._offered_time = self._read() or (None, None)
        self._unsaved = None  # state of this session

    def keep(self, state):
        """Write the unsaved `state` of this session; None if everything is saved.

        Raises
        ------
        OSError
            Naming the file.
        """
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
            new.write_text(_text(self._path, state), encoding="utf-8")

    def note_save(self):
        """Delete the file after a save, and end the offer."""
        self.offered = self._unsaved = None
        self._remove()

    def take(self):
        """Return the offered state and end the offer; the file keeps the state until a save."""
        state, self.offered = self.offered, None
        return state

    def drop(self):
        """End the offer, and forget its state."""
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
        return (
            f"{count} handles of {saved_at} were not saved: Return restores them, N deletes them."
        )

    def _read(self):
        """The state in the file, and its time in seconds; None if the file is not readable."""
        if self._file is not None:
            with suppress(OSError, ValueError, KeyError, TypeError, RecursionError):
                return _state(self._file.read_text(encoding="utf-8")), self._file.stat().st_mtime
        return None

    def _remove(self):
        if self._file is not None:
            with suppress(OSError):
                self._file.unlink()


def _text(path, state):
    values = options.values_of(state)
    values.update(
        path=path,
        rest=state.rest.tolist(),
        deformed=state.deformed.tolist(),
        weights=None if state.weights is None else state.weights.tolist(),
        labels=list(state.labels),
        anchored=state.anchored.tolist(),
        enabled=state.enabled.tolist(),
        pending=_encoded_pending(state.pending),
        cuts=[json_values.encoded(cut) for cut in state.cuts],
        handles=[json_values.encoded(handle) for handle in state.handles],
        mask=None if state.mask is None else json_values.encoded(state.mask),
    )
    return json.dumps(values)


def _encoded_pending(pending):
    """Side, position and label of a `Pending`; None for none."""
    return None if pending is None else [pending.side, pending.position.tolist(), pending.label]


def _state(text):
    values = json.loads(text)
    weights, mask, pending = values["weights"], values.get("mask"), values.get("pending")
    return State(
        values["rest"],
        values["deformed"],
        None if weights is None else np.array(weights),
        values["labels"],
        values["anchored"],
        cuts=[json_values.decoded(cut) for cut in values["cuts"]],
        # files of earlier versions lack them
        handles=[json_values.decoded(handle) for handle in values.get("handles", ())],
        mask=None if mask is None else json_values.decoded(mask),
        enabled=values.get("enabled"),
        pending=None if pending is None else Pending(*pending),
        **{o.name: values[o.name] for o in options.OPTIONS if o.name in values},
    )
