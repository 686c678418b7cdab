"""Files that are there as a whole or not at all.

A new file is made in a folder of its own beside the old one, and takes its place when it is
complete and on the disk. Whatever ends the writing before, a full disk, an error or a killed
process, leaves the old file as it was. A format of several files (.mhd and .raw, .nhdr and .raw.gz,
.vtm and a folder of blocks) has the one that names the others replaced last; only a process killed
between these renamings leaves new data under an old header. In folders only what is written is
replaced.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def replacing(path):
    """A path to write to, whose file replaces the one at `path` when the block has ended well.

    Files that are written beside it, also in folders, replace those beside `path`. Links stay, and
    lead to the new file; it has the old one's permissions.

    Raises
    ------
    OSError, ValueError
        Naming `path`, also where the block's own error names the path that it was given.
    """
    target = check_replaceable(path)
    try:
        folder = Path(tempfile.mkdtemp(prefix=_prefix(os.getpid()), dir=target.parent))
    except OSError as error:
        raise _failure(path, error) from error
    new = folder / target.name
    try:
        yield new
        _move_over(folder, target)
    except OSError as error:
        raise _failure(path, error) from error
    except ValueError as error:
        raise ValueError(str(error).replace(str(new), str(path))) from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def check_replaceable(path):
    """The file that `path` leads to, if it is or can become one.

    Raises
    ------
    OSError
        Naming the file.
    """
    if not os.fspath(path):
        raise FileNotFoundError("no file is named to write, got an empty name; choose one")
    target = Path(os.path.realpath(path))
    if target.is_dir():
        raise IsADirectoryError(f"`{path}` is a folder; expected the name of a file to write")
    if target.parent.exists() and not target.parent.is_dir():
        raise NotADirectoryError(
            f"`{Path(path).parent}` is a file; expected a folder to write `{target.name}` in"
        )
    if not target.parent.is_dir():
        raise FileNotFoundError(
            f"there is no folder `{Path(path).parent}` to write `{target.name}` in"
        )
    if target.exists() and not target.is_file():
        raise FileExistsError(f"`{path}` cannot be written: it is no ordinary file")
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise PermissionError(f"`{path}` cannot be written: no file can be made in its folder")
    return target


def remove_remains(path, process):
    """Remove what the killed `process` (its id) has left beside the file at `path`."""
    for folder in Path(os.path.realpath(path)).parent.glob(f"{_prefix(process)}*"):
        shutil.rmtree(folder, ignore_errors=True)


def _failure(path, error):
    return OSError(f"`{path}` could not be written: {error.strerror or error}")


def _prefix(process):
    return f".vtk-mls-{process}-"


def _move_over(folder, target):
    """Move the files in `folder` beside and over `target`, the one of its name last."""
    files = [file for file in folder.rglob("*") if file.is_file()]
    files.sort(key=lambda file: file == folder / target.name)
    paths = [target.parent / file.relative_to(folder) for file in files]
    for file, old in zip(files, paths):
        with file.open("r+b") as written:
            os.fsync(written.fileno())  # some file systems find out here that they are full
        if old.is_file():
            shutil.copymode(old, file)
    for file, old in zip(files, paths):
        old.parent.mkdir(parents=True, exist_ok=True)
        file.replace(old)
