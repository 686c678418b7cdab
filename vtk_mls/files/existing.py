"""Files and folders that a caller names: that they are there, and of the right sort."""

from __future__ import annotations

import os
from pathlib import Path


def existing_file(path: str | os.PathLike[str]) -> Path:
    """`path` as a Path, if it is a file.

    Raises
    ------
    OSError
        Naming it.
    """
    if not os.fspath(path):
        raise FileNotFoundError("no file is named, got an empty name; choose a file")
    path = Path(path)
    if path.is_dir():
        raise IsADirectoryError(f"`{path}` is a folder; expected a file")
    if not path.exists():
        raise FileNotFoundError(f"there is no file `{path}`")
    if not path.is_file():
        raise OSError(f"`{path}` is no ordinary file, such as one on a disk")
    return path


def check_folder(path: str | os.PathLike[str]) -> None:
    """Raise OSError if a folder cannot be at `path` because a file is there or above it."""
    for folder in (Path(path), *Path(path).parents):
        if folder.exists():
            if not folder.is_dir():
                raise NotADirectoryError(f"`{folder}` is a file; expected a folder")
            return
