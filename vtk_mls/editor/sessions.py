"""Sessions: everything that an editor shows, in one file that opens again."""

from __future__ import annotations

import filecmp
import itertools
import shutil
from contextlib import suppress
from pathlib import Path

import numpy as np

from vtk_mls.editor import state_values
from vtk_mls.files import session_files
from vtk_mls.files.session_files import SessionFile

_INVALID = ValueError, KeyError, TypeError, IndexError, RecursionError, AttributeError
_CAMERA = "Position", "FocalPoint", "ViewUp"


def state_of(session, path):
    """The `State` of a `SessionFile` that was read from a path.

    Raises
    ------
    ValueError
        Naming the path.
    """
    try:
        return state_values.decoded(session.edit)
    except _INVALID as error:
        reason = " ".join(str(error).split())
        raise ValueError(f"`{path}` is no session: its edit is not valid ({reason})") from error


def write(editor):
    """Write the session of an `Editor`, and return the path.

    Raises
    ------
    OSError, ValueError, TypeError
        For data without files, and shapes without a format.
    """
    target = editor.target
    if target is not None and target.path is None:
        raise ValueError("a session names the files of its data, and the target has none")
    edit = state_values.encoded(editor.document.committed)
    path, data = editor.saver.session_place()
    file = None if target is None else _target_file(target, path.parent)
    session_files.write(path, SessionFile(tuple(data), file, edit, _views_of(editor)))
    return path


def _target_file(target, folder):
    """The file of a target that a session in a folder names; never in place of another file."""
    source = Path(target.path)
    if not target.is_upload:
        return source
    for count in itertools.count():
        path = folder / ("target-" * count + source.name)
        if not path.exists():
            shutil.copyfile(source, path)
        if filecmp.cmp(source, path, shallow=False):
            return path


def resume(editor, path, views):
    """Show the views of the session at a path, which the next `save_session` replaces."""
    editor.saver.session = path
    show_views(editor, views)


def show_views(editor, views):
    """Show the camera, slices and comparison of a session; those that are not valid are left."""
    with suppress(*_INVALID):
        camera = editor.scene.renderer.GetActiveCamera()
        vectors = {name: [float(x) for x in views["camera"][name]] for name in _CAMERA}
        if all(len(v) == 3 and np.isfinite(v).all() for v in vectors.values()):
            for name, vector in vectors.items():
                getattr(camera, f"Set{name}")(vector)
    with suppress(*_INVALID):
        if editor.target is not None:
            editor.set_comparison(mode=views["comparison"][0], share=float(views["comparison"][1]))
    with suppress(*_INVALID):
        if bool(views["slices"]) != editor.slices.is_visible:
            editor.toggle_slices()
        point = np.array(views["slice_point"], float)
        if point.shape == (3,) and np.isfinite(point).all():
            editor.look_at(point)
    editor.document.show()


def _views_of(editor):
    camera = editor.scene.renderer.GetActiveCamera()
    return {
        "camera": {name: list(getattr(camera, f"Get{name}")()) for name in _CAMERA},
        "slices": editor.slices.is_visible,
        "slice_point": editor.slices.point.tolist(),
        "comparison": [editor.comparison.mode, editor.comparison.share],
    }
