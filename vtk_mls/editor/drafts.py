"""Edits that are not saved yet, kept in a file that the next start offers."""

from __future__ import annotations

import hashlib
import json
import os
import time
from contextlib import suppress
from pathlib import Path

import numpy as np

from vtk_mls import HalfPlane, Plane, Surface
from vtk_mls.editor.state import State
from vtk_mls.engine import caches
from vtk_mls.files.replacing import replacing

_FOLDER = "vtk_mls", "unsaved"
_CUTS = {"plane": Plane, "half-plane": HalfPlane, "surface": Surface}
_PLAIN = ("kind", "alpha", "degree", "nu", "cut_frame", "map_tolerance", "blend", "device")


class Drafts:
    """Keeps what is edited of a file, and finds what an earlier session has left.

    Parameters
    ----------
    path : path
        Of the data.
    folder : path, optional
        Where drafts are; the user's caches if not given.
    digest : str, optional
        Of the data's bytes, if these are to be known again wherever they lie.
    """

    def __init__(self, path, folder=None, digest=None):
        self._path = os.path.abspath(path) if digest is None else digest
        cache = caches.folder()
        folder = folder or (cache and cache.joinpath(*_FOLDER))
        name, self._began = hashlib.sha256(self._path.encode()).hexdigest()[:16], time.time_ns()
        self._file = folder and Path(folder) / f"{name}-{self._began}-{os.getpid()}.json"
        self._pattern, self._found, self._taken = f"{name}-*.json", None, []

    def keep(self, state):
        """Keep a `State` until it is saved; it replaces the one before.

        Raises
        ------
        OSError
            Naming the file.
        """
        if self._file is None:
            raise OSError("there is no folder for unsaved handles; save them with S")
        self._file.parent.mkdir(parents=True, exist_ok=True)
        with replacing(self._file) as new:
            new.write_text(_text(self._path, state), encoding="utf-8")

    def found(self):
        """The newest `State` that another session has left, and when (seconds); None without.

        What was taken is passed over.
        """
        for file in self._others():
            with suppress(OSError, ValueError, KeyError, TypeError):
                found = _state(file.read_text(encoding="utf-8")), file.stat().st_mtime
                self._found = file
                return found
        return None

    def take(self):
        """Count what was found last as one's own."""
        self._taken.append(self._found)

    def drop(self):
        """Remove what was found last: nobody wants it."""
        self._remove([self._found])

    def forget(self):
        """Remove the own one, for it is saved, or nothing is changed."""
        self._remove([self._file])

    def forget_all(self):
        """Remove the own one, what was taken, and what was passed over."""
        self._remove([self._file, *self._taken, *self._passed_over()])

    def _passed_over(self):
        """Files that were offered and not taken, in this session or in the one found last.

        Those of sessions that go on are not among them.
        """
        if self._found is None or self._found in self._taken:
            return []
        began = _began(self._found)
        older = [file for file in self._others() if _written(file) < began]
        return [
            file
            for file in (self._found, *older)
            if _written(file) < self._began and not _is_running(file)
        ]

    def _others(self):
        """Files of other sessions, the newest first."""
        if self._file is None:
            return []
        own = {self._file, *self._taken}
        return sorted({*self._file.parent.glob(self._pattern)} - own, reverse=True)

    def _remove(self, files):
        for file in files:
            if file is not None:
                with suppress(OSError):
                    file.unlink()


def _began(file):
    """When the session of a file began, in ns."""
    return int(file.stem.split("-")[1])


def _written(file):
    """When a file was written last, in ns; later than all if it is gone."""
    try:
        return file.stat().st_mtime_ns
    except OSError:
        return 2**63


def _is_running(file):
    """Whether the process of a file's session goes on, as far as one can know."""
    if os.name != "posix":  # elsewhere there is no such question
        return True
    try:
        os.kill(int(file.stem.split("-")[2]), 0)
    except ProcessLookupError:
        return False
    except OSError:  # it is another user's
        return True
    return True


def _text(path, state):
    values = {name: getattr(state, name) for name in _PLAIN}
    values.update(
        path=path,
        rest=state.rest.tolist(),
        deformed=state.deformed.tolist(),
        weights=None if state.weights is None else state.weights.tolist(),
        labels=list(state.labels),
        anchored=state.anchored.tolist(),
        cuts=[_numbers(cut) for cut in state.cuts],
    )
    return json.dumps(values)


def _numbers(cut):
    """The name of a cut's shape, and what makes it."""
    name = next(name for name, kind in _CUTS.items() if isinstance(cut, kind))
    attributes = {
        "plane": ("point", "normal"),
        "half-plane": ("point", "normal", "inward"),
        "surface": ("points", "triangles"),
    }[name]
    return [name, [getattr(cut, each).tolist() for each in attributes]]


def _state(text):
    values = json.loads(text)
    weights = values["weights"]
    return State(
        values["rest"],
        values["deformed"],
        None if weights is None else np.array(weights),
        values["labels"],
        values["anchored"],
        cuts=[_CUTS[name](*numbers) for name, numbers in values["cuts"]],
        **{name: values[name] for name in _PLAIN if name in values},  # some are newer
    )
