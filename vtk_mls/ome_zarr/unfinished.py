"""An output that is not complete: its folder, and the list of its written blocks.

`out.ome.zarr.unfinished` holds the new `out.ome.zarr`, a file with a hash of all inputs, and a file
with the names of written blocks. When all are written, the new folder is moved to its place. So an
output with its own name is complete, and an interrupted one is resumed.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
import pickle
import shutil
from pathlib import Path

import numpy as np

from vtk_mls.base.messages import warn
from vtk_mls.files.ome_zarr import SUFFIX, complete_labels, has_image, has_metadata, is_array

ENDING = ".unfinished"
_METADATA = "zarr.json", ".zgroup", ".zattrs", ".zarray"
_CONSOLIDATED = "consolidated_metadata"


class Unfinished:
    """An unfinished output.

    Parameters
    ----------
    path : path
        Of the complete output.
    inputs : str
        A hash of all that determines the output.

    Attributes
    ----------
    data : Path
        Folder of the new output.
    done : set of str
        Names of blocks that are written.
    is_resumed : bool
    replaced_other : bool
        Whether there was an unfinished output of other inputs, which is removed.

    Raises
    ------
    OSError
        Naming the path, if it cannot be written to.
    """

    def __init__(self, path, inputs):
        self.path = check_output(path)
        self.folder = self.path.with_name(self.path.name + ENDING)
        self.data = self.folder / self.path.name
        self._job, self._list = self.folder / "job.json", self.folder / "done.txt"
        try:
            self._open(inputs)
        except OSError as error:
            raise OSError(f"`{path}` could not be written: {error.strerror or error}") from error

    def _open(self, inputs):
        self.is_resumed = self.replaced_other = False
        if self.folder.exists() and any(self.folder.iterdir()):
            if not self._job.is_file():
                raise OSError(f"`{self.folder}` is in the way; remove it")
            self.is_resumed = self.data.is_dir() and _stored_inputs(self._job) == inputs
            self.replaced_other = not self.is_resumed
        if self.replaced_other:
            shutil.rmtree(self.folder)
        self.folder.mkdir(exist_ok=True)
        if not self.is_resumed:
            self._job.write_text(json.dumps({"inputs": inputs}))
        self.data.mkdir(exist_ok=True)
        for remains in self.data.rglob("*.partial"):  # chunks that a killed process began
            remains.unlink()
        # the last line may be incomplete
        lines = self._list.read_text().split("\n")[:-1] if self._list.exists() else []
        self.done = set(lines)
        self._list.write_text("".join(f"{line}\n" for line in lines))

    def note(self, name):
        """Note that a block is written."""
        self.done.add(name)
        with self._list.open("a") as file:
            file.write(f"{name}\n")

    def finish(self):
        """Move the output to its place, where an older one is removed."""
        old = self.folder / "old"
        if self.path.exists():
            self.path.rename(old)
        self.data.rename(self.path)
        shutil.rmtree(self.folder)


def check_output(path, inputs=()):
    """`path` as a Path, if an OME-Zarr can be written there.

    Raises
    ------
    OSError, ValueError
        Naming it.
    """
    path = Path(os.path.abspath(path))
    if not path.name.lower().endswith(SUFFIX):
        raise ValueError(f"`{path}` must end in {SUFFIX}, as the name of an OME-Zarr")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"there is no folder `{path.parent}` to write `{path.name}` in")
    if path.exists() and not has_metadata(path):
        raise FileExistsError(f"`{path}` cannot be written: it exists and is not an OME-Zarr")
    for other in map(Path, inputs):
        if path.resolve() in (other.resolve(), *other.resolve().parents):
            raise FileExistsError(f"`{path}` cannot be written: it is the input")
    return path


def copy_metadata(source, target, paths):
    """Copy the metadata of a group, and of groups and arrays in it; and other groups, as they are.

    A warning names other arrays and images, which are not copied.

    Parameters
    ----------
    source, target : Path
    paths : iterable of str
        Of arrays and groups; groups that they are in are copied, too.
    """
    folders, left_out = {Path()}, []
    for path in map(Path, paths):
        folders |= {path, *path.parents}
    for folder in sorted(folders):
        (target / folder).mkdir(parents=True, exist_ok=True)
        for name in _METADATA:
            file = source / folder / name
            if file.is_file():
                text = _without_copies(file) if name == "zarr.json" else file.read_text()
                (target / folder / name).write_text(text)
        for other in [] if is_array(source / folder) else sorted((source / folder).iterdir()):
            place = other.relative_to(source)
            if place in folders or other.name in (*_METADATA, ".zmetadata"):
                continue
            if not other.is_dir():
                shutil.copyfile(other, target / place)
            elif is_array(other) or has_image(other):
                left_out.append(str(place))
            else:
                shutil.copytree(other, target / place, dirs_exist_ok=True)
    complete_labels(source, target)
    if left_out:
        warn(f"`{source}`: {', '.join(left_out)} belong to no deformed image and are not copied")


def hash_of(folder, paths, *values):
    """A hash of the files of arrays and their groups, by names, sizes and times, and of values."""
    digest = hashlib.sha256()
    for path in paths:
        groups = (Path(folder, group, name) for group in Path(path).parents for name in _METADATA)
        for file in (*filter(Path.is_file, groups), *sorted(Path(folder, path).rglob("*"))):
            state = file.stat()
            if file.is_file():
                name = file.relative_to(folder)
                digest.update(f"{name} {state.st_size} {state.st_mtime_ns}\n".encode())
    for value in values:
        _add_content(digest, value)
    return digest.hexdigest()


def _add_content(digest, value):
    """Add a value to a hash, without cached properties."""
    digest.update(type(value).__qualname__.encode())
    if dataclasses.is_dataclass(value):
        members = [getattr(value, field.name) for field in dataclasses.fields(value) if field.init]
    elif isinstance(value, dict):
        members = [part for item in value.items() for part in item]
    elif isinstance(value, list | tuple):
        members = value
    elif isinstance(value, np.ndarray):
        digest.update(f"{value.dtype} {value.shape}".encode())
        digest.update(np.ascontiguousarray(value).tobytes())
        return
    else:
        digest.update(pickle.dumps(value))
        return
    digest.update(f"{len(members)}".encode())
    for member in members:
        _add_content(digest, member)


def _without_copies(file):
    """The text of a zarr.json, without copies of the metadata of other folders."""
    text = file.read_text()
    content = json.loads(text)
    if _CONSOLIDATED not in content:
        return text
    del content[_CONSOLIDATED]
    return json.dumps(content, indent=2)


def _stored_inputs(job):
    try:
        return json.loads(job.read_text()).get("inputs")
    except (ValueError, AttributeError):
        return None
