"""Sessions of the editor, `.mls.json`: the files of the data, the edit, and what is shown."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from vtk_mls.base.errors import InputError
from vtk_mls.files.paths import existing_file, replacing

ENDING = ".mls.json"
NAME = f"session{ENDING}"  # in the folder of a save
_FORMAT, _VERSION = "vtk_mls session", 1


@dataclass(frozen=True, eq=False)
class SessionFile:
    """The contents of a session file.

    `data` are the files of the moving data; the first is deformed, the others go along. `target` is
    a Path or None. `edit` (pairs, options, cuts, handles, mask) and `views` (camera, slices,
    comparison) are values of JSON.
    """

    data: tuple[Path, ...]
    target: Path | None
    edit: dict[str, Any]
    views: dict[str, Any] = field(default_factory=dict)

    @property
    def paths(self):
        """All files of data."""
        return self.data if self.target is None else (*self.data, self.target)


def is_session(path):
    return os.fspath(path).lower().endswith(ENDING)


def read(path):
    """The `SessionFile` at a path, whose files of data need not exist.

    Errors (OSError, ValueError) name the file.
    """
    path = existing_file(path)
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise InputError(f"is not a session: its JSON is broken ({error})", path=path) from error
    if not isinstance(values, dict) or values.get("format") != _FORMAT:
        raise InputError("is JSON, but not a session of `vtk-mls view`", path=path)
    version = values.get("version")
    if not isinstance(version, int) or version > _VERSION:
        reads = f"this vtk_mls reads sessions up to version {_VERSION}: update vtk_mls"
        raise InputError(f"has version {version}, and {reads}", path=path)
    data, target = values.get("data"), values.get("target")
    edit, views = values.get("edit"), values.get("views", {})
    names = [*data] if isinstance(data, list) else []
    is_valid = names and all(isinstance(name, str) for name in [*names, target or ""])
    if not (is_valid and isinstance(edit, dict) and isinstance(views, dict)):
        raise InputError("is not a session: it lacks valid `data`, `edit` or `views`", path=path)
    folder = path.absolute().parent
    files = tuple(Path(os.path.normpath(folder / name)) for name in data)
    target = None if target is None else Path(os.path.normpath(folder / target))
    return SessionFile(files, target, edit, views)


def check_files(session, path):
    """Raise OSError if a file of data of the session at a path does not exist."""
    for file in session.paths:
        if not file.exists():
            raise FileNotFoundError(
                f"`{path}` is a session of `{file}`, which does not exist: move it there, or "
                "change its name in the session"
            )


def write(path, session):
    """Write a `SessionFile` with paths relative to its folder. Errors name the file."""
    folder = Path(path).absolute().parent
    values = {
        "format": _FORMAT,
        "version": _VERSION,
        "data": [_relative(file, folder) for file in session.data],
        "target": None if session.target is None else _relative(session.target, folder),
        "edit": session.edit,
        "views": session.views,
    }
    text = json.dumps(values, indent=1, allow_nan=False)
    with replacing(path) as new:
        new.write_text(text + "\n", encoding="utf-8")


def _relative(file, folder):
    """A path relative to a folder, with slashes; absolute on another drive of Windows."""
    try:
        return Path(os.path.relpath(os.path.realpath(file), os.path.realpath(folder))).as_posix()
    except ValueError:
        return Path(file).absolute().as_posix()
