"""Paths to read from, and files that are replaced as a whole or not at all.

A new file is written to a temporary folder next to the old one, and replaces it when it is complete
and on the disk. The old file stays as it was if the writing ends early: disk full, error, killed
process. Of a format of several files (.mhd and .raw, .nhdr and .raw.gz, .vtm and a folder of
blocks), the file that names the others is replaced last. Only a process killed between these
renamings leaves new data under an old header. In folders only files of the same names are replaced.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from contextlib import contextmanager
from pathlib import Path, PurePosixPath, PureWindowsPath

from vtk_mls.base.errors import InputError
from vtk_mls.files.ome_zarr import is_ome_zarr

_INDICES = ".vtm", ".vtmb", ".vtpc", ".pvd"  # their data are in a folder of the same name


def existing_file(path: str | os.PathLike[str]) -> Path:
    """`path` as a Path, if it is a file; an OSError names it."""
    if not os.fspath(path):
        raise FileNotFoundError("no file is named, got an empty name; choose a file")
    path = Path(path)
    if path.is_dir():
        raise IsADirectoryError(f"`{path}` is a folder; expected a file")
    if not path.exists():
        raise FileNotFoundError(f"there is no file `{path}`")
    if not path.is_file():
        raise OSError(f"`{path}` is not a regular file")
    return path


def check_folder(path: str | os.PathLike[str]) -> None:
    """Raise OSError if `path` cannot be a folder because it, or a parent, is a file."""
    for folder in (Path(path), *Path(path).parents):
        if folder.exists():
            if not folder.is_dir():
                raise NotADirectoryError(f"`{folder}` is a file; expected a folder")
            return


def named_file(path, name):
    """The file that a header (a Path) names, relative to its folder.

    A ValueError says that the name leads out of that folder, or that the file does not exist.
    """
    check_within(name)
    file = path.parent / name
    if not file.is_file():
        raise ValueError(f"there is no data file `{file}`")
    return file


def check_within(name):
    """Raise ValueError if a file that a header names is not in the header's folder."""
    paths = PurePosixPath(name), PureWindowsPath(name)
    if any(path.is_absolute() or path.drive or ".." in path.parts for path in paths):
        raise ValueError(f"its data file `{name:.80}` is not in its own folder")


@contextmanager
def replacing(path):
    """A path to write to. Its file replaces the one at `path` when the block ends without error.

    Files that are written next to it, also in folders, replace those next to `path`. A link is kept
    and leads to the new file. The new file gets the permissions of the old one. Errors, also those
    of the block, name `path`.
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
    except InputError as error:
        if error.name and error.path != str(new):
            raise
        raise InputError(error.predicate, path=path) from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def check_replaceable(path):
    """The file that `path` leads to, if it exists or can be created; an OSError names it."""
    if not os.fspath(path):
        raise FileNotFoundError("no file is named to write, got an empty name; choose one")
    target = Path(os.path.realpath(path))
    folder = Path(path).parent
    if target.is_dir():
        raise IsADirectoryError(f"`{path}` is a folder; expected the name of a file to write")
    if target.parent.exists() and not target.parent.is_dir():
        raise NotADirectoryError(
            f"`{folder}` is a file; expected a folder to write `{target.name}` in"
        )
    if not target.parent.is_dir():
        raise FileNotFoundError(f"there is no folder `{folder}` to write `{target.name}` in")
    if target.exists() and not target.is_file():
        raise FileExistsError(f"`{path}` cannot be written: it is not a regular file")
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise PermissionError(f"`{path}` cannot be written: no file can be made in its folder")
    return target


def check_apart(path, *inputs):
    """Raise FileExistsError if an output is in the folder of an input, or the other way round."""
    target, folder = Path(os.path.realpath(path)), _data_folder(path)
    for source in inputs:
        place, data = Path(os.path.realpath(source)), _data_folder(source)
        if target == place == data:
            reason = "it is the input; name another"
        elif data in target.parents:
            reason = f"it is in the folder of `{source}`, which is read; choose another place"
        elif folder in place.parents:
            reason = f"`{source}`, which is read, is in its folder; choose another place"
        else:
            continue
        raise FileExistsError(f"`{path}` cannot be written: {reason}")


def _data_folder(path):
    """The folder of an OME-Zarr or of the data of an index of files; None for other formats."""
    target = Path(os.path.realpath(path))
    if target.suffix.lower() in _INDICES:
        return target.with_suffix("")
    return target if is_ome_zarr(target) else None


def remove_remains(path, process):
    """Remove what the killed `process` (its id) has left next to the file at `path`."""
    for folder in Path(os.path.realpath(path)).parent.glob(f"{_prefix(process)}*"):
        shutil.rmtree(folder, ignore_errors=True)


def _failure(path, error):
    reason = error.strerror or str(error)
    failure = OSError(f"`{path}` could not be written: {reason}")
    failure.strerror = reason  # for a caller whose file has another name
    return failure


def _prefix(process):
    return f".vtk-mls-{process}-"


def _move_over(folder, target):
    """Move the files of `folder` to the folder of `target`, the file named as `target` last."""
    files = [file for file in folder.rglob("*") if file.is_file()]
    files.sort(key=lambda file: file == folder / target.name)
    old_files = [target.parent / file.relative_to(folder) for file in files]
    for file, old in zip(files, old_files):
        with file.open("r+b") as new:
            os.fsync(new.fileno())  # some file systems find out only here that they are full
        if old.is_file():
            shutil.copymode(old, file)
    for file, old in zip(files, old_files):
        old.parent.mkdir(parents=True, exist_ok=True)
        file.replace(old)
