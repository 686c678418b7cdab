"""An output that is not complete: its folder, and the list of its written blocks.

`out.ome.zarr.unfinished` holds the new `out.ome.zarr` in a folder with a hash of all inputs as its
name, and a file with the names of written blocks. When all are written, the new folder is moved to
its place. So an output with its own name is complete, and an interrupted one is resumed. One
process at a time has the lock of the folder, which the system frees when that process ends.
"""

import dataclasses
import errno
import hashlib
import io
import json
import os
import pickle
import shutil
import time
from contextlib import suppress
from functools import partial
from pathlib import Path

from vtk_mls.base.messages import warn
from vtk_mls.files.ome_zarr import SUFFIX, complete_labels, has_image, has_metadata, is_array
from vtk_mls.files.paths import check_apart

ENDING = ".unfinished"
_METADATA = "zarr.json", ".zgroup", ".zattrs", ".zarray"
_CONSOLIDATED = "consolidated_metadata"
_PATIENCE = 3.0  # seconds until another job is refused: the child of a killed command ends later


class Unfinished:
    """An unfinished output at `path`; as a context manager, it is locked until the end of the
    block.

    `inputs` is a hash of all that determines the output. `data` is the folder of the new output,
    `done` the names of written blocks. `is_resumed` and `replaced_other` say whether there was an
    unfinished output of the same or of other inputs; the latter is removed. An OSError names the
    path, if it cannot be written to, or another job writes it.
    """

    def __init__(self, path, inputs):
        self.path = check_output(path)
        self.folder = self.path.with_name(self.path.name + ENDING)
        self.data, self._list = self.folder / inputs, self.folder / "done.txt"
        self._lock = None
        try:
            self._open()
        except OSError as error:
            self.__exit__()
            raise OSError(f"`{path}` could not be written: {error.strerror or error}") from error

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self._lock is not None:
            self._lock.close()

    def _open(self):
        lock = self.folder / "lock"
        if self.folder.exists() and any(self.folder.iterdir()) and not lock.exists():
            raise OSError(f"`{self.folder}` is in the way; remove it")
        self.folder.mkdir(exist_ok=True)
        self._lock = lock.open("a")
        _take(self._lock)
        self.is_resumed = self.data.is_dir()
        self.replaced_other = not self.is_resumed and len(self._entries()) > 0
        if self.replaced_other:
            self._clear()
        self.data.mkdir(exist_ok=True)
        self._remove_partial()
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
        self._remove_partial()
        old = self.folder / "old"
        if self.path.exists():
            self.path.rename(old)
        self.data.rename(self.path)
        self._clear()
        if os.name == "nt":  # where no open file can be removed
            self._lock.close()
        with suppress(OSError):  # the next job may have begun
            Path(self._lock.name).unlink()
            self.folder.rmdir()

    def _entries(self):
        """What is in the folder, but the lock."""
        return [path for path in self.folder.iterdir() if path.name != Path(self._lock.name).name]

    def _clear(self):
        """Remove all but the lock; first the list, so that nothing is in it that is not there."""
        for path in sorted(self._entries(), key=Path.is_dir):
            shutil.rmtree(path) if path.is_dir() else path.unlink()

    def _remove_partial(self):
        """Remove chunks that a killed process began."""
        for remains in self.data.rglob("*.partial"):
            remains.unlink()


def _take(lock):
    """Lock an open file until it is closed, or raise OSError: another job has it."""
    if os.name == "nt":
        import msvcrt

        take = partial(msvcrt.locking, lock.fileno(), msvcrt.LK_NBLCK, 1)
    else:
        import fcntl

        take = partial(fcntl.flock, lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    end = time.monotonic() + _PATIENCE
    while True:
        try:
            take()
            break
        except OSError as error:
            if error.errno not in (errno.EACCES, errno.EAGAIN, errno.EDEADLK):
                warn(
                    f"`{lock.name}` cannot be locked ({error.strerror}): let no other job write "
                    "there"
                )
                break
            if time.monotonic() > end:
                text = "another job is writing it; wait for that, or choose another output"
                raise OSError(text) from None
            time.sleep(0.1)
    with suppress(FileNotFoundError):
        if os.path.samestat(os.stat(lock.name), os.fstat(lock.fileno())):
            return
    raise OSError("another job has just written it; run the same again to replace that")


def check_output(path, inputs=()):
    """`path` as a Path, if an OME-Zarr can be written there. Errors name it."""
    path = Path(os.path.abspath(path))
    if not path.name.lower().endswith(SUFFIX):
        raise ValueError(f"`{path}` must end in {SUFFIX}, as the name of an OME-Zarr")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"there is no folder `{path.parent}` to write `{path.name}` in")
    if path.exists() and not has_metadata(path):
        raise FileExistsError(f"`{path}` cannot be written: it exists and is not an OME-Zarr")
    check_apart(path, *inputs)
    return path


def copy_metadata(source, target, paths):
    """Copy the metadata of a group, of arrays and groups in it (`paths`) and of groups that they
    are in; and other groups, as they are. A warning names other arrays and images, which are not
    copied.
    """
    folders, left_out = {Path()}, []
    for path in map(Path, paths):
        folders |= {path, *path.parents}
    for folder in sorted(folders):
        (target / folder).mkdir(parents=True, exist_ok=True)
        for name in _METADATA:
            file = source / folder / name
            if file.is_file():
                text = file.read_text()
                if name == "zarr.json" and _CONSOLIDATED in (content := json.loads(text)):
                    del content[_CONSOLIDATED]  # copies of the metadata of other folders
                    text = json.dumps(content, indent=2)
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
    content = io.BytesIO()
    pickler = _Pickler(content)
    pickler.fast = True  # values that are equal, and not just the same, have one hash
    pickler.dump(values)
    digest.update(content.getvalue())
    return digest.hexdigest()


class _Pickler(pickle.Pickler):
    """Pickles dataclasses by the arguments that make them, without cached properties."""

    def reducer_override(self, value):
        if not dataclasses.is_dataclass(value) or isinstance(value, type):
            return NotImplemented
        names = [field.name for field in dataclasses.fields(value) if field.init]
        return type(value), tuple(getattr(value, name) for name in names)
