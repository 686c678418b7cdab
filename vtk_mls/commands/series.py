"""Time series: a file with several time steps, or a file for each.

The files are named by a collection of ParaView (.pvd), a file series of ParaView (.series, JSON) or
a pattern of a shell, in the order of the numbers in their names.
"""

import glob
import json
import math
import os
import re
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

from vtk_mls import io
from vtk_mls.commands.supervision import step
from vtk_mls.files import formats
from vtk_mls.files.block_files import PIECES, joined
from vtk_mls.files.paths import check_replaceable, existing_file, named_file, replacing

SUFFIX = ".pvd"  # of output


def read_steps(path):
    """The (time, function that reads the dataset) of each time step of input, in the order of
    times.

    `path` is a pattern, a .pvd or .series file, or as of `io.read_dataset`. Files of the same time
    are its blocks. The times of a pattern are 0, 1, 2 ...; a file without a time has 0. Errors name
    the file; those of the functions are ValueErrors.
    """
    path = Path(path) if os.fspath(path) else existing_file(path)
    line = formats.find(path, reads=io.DATASETS)
    if is_series(path) or line is None or not line.has_times:
        return [(time, partial(_read, files)) for time, files in _files(path)]
    times, read = io.open_dataset(path)
    return [(time, partial(read, n)) for n, time in enumerate(times or (0.0,))]


def timed_files(path):
    """The (time, file) of a series with one file for each time, in the order of times: of a
    pattern, a .pvd or .series file, or a single file. Errors (OSError, ValueError) name the file.
    """
    path = Path(path) if os.fspath(path) else existing_file(path)
    steps = _files(path)
    for time, files in steps:
        if len(files) > 1:
            raise ValueError(
                f"`{path}` must have one file for each time, got {len(files)} at {time}"
            )
    return [(time, file) for time, (file,) in steps]


def is_series(path):
    """Whether a path names the files of several times: a pattern, .pvd or .series."""
    return _is_pattern(Path(path)) or Path(path).suffix.lower() in _INDICES


def _files(path):
    """List of (time, files) in the order of times."""
    if _is_pattern(path):
        files = sorted(glob.glob(str(path)), key=_by_number)
        if not files:
            raise FileNotFoundError(f"there are no files `{path}`")
        return [(float(time), [Path(file)]) for time, file in enumerate(files)]
    if not is_series(path):
        return [(0.0, [path])]
    existing_file(path)
    try:
        files = {}
        for time, name in _INDICES[path.suffix.lower()](path):
            if not math.isfinite(time):
                raise ValueError(f"its times must be finite, got {time}")
            files.setdefault(time, []).append(named_file(path, name))
        if not files:
            raise ValueError("it names no files")
    except ValueError as error:
        raise ValueError(f"`{path}` is not a time series: {error}") from None
    return [(time, files[time]) for time in sorted(files)]


def can_hold(path):
    """Whether a file of this name can hold several time steps."""
    return Path(path).suffix.lower() == SUFFIX or _line_of(path) is not None


def _line_of(path):
    """The format of images in time that a file name has, or None."""
    line = formats.find(Path(path), writes=(formats.IMAGE,))
    return line if line is not None and line.series_writer else None


def suffixes():
    """The endings of files that can hold several time steps."""
    return " ".join([SUFFIX, *(line.endings for line in formats.TABLE if line.series_writer)])


@contextmanager
def writing(path, times):
    """A context with a function of a dataset that adds the next of `times` to a file: a collection
    (.pvd) or, for images, a format with a time axis.

    The datasets of a .pvd file go to a folder of the same name beside it. All files appear when the
    block ends without an error, or none. Errors (OSError, ValueError) name `path`.
    """
    path = check_writable(path)
    line = None if path.suffix.lower() == SUFFIX else _line_of(path)
    with replacing(path) as new:
        if line is None:
            names = []
            yield lambda dataset: names.append(_write_step(new, dataset, len(names)))
            _write_collection(new, zip(times, names))
            return
        with line.write_series(new, tuple(times)) as add:

            def add_image(dataset):
                if not dataset.IsA("vtkImageData"):
                    kind = dataset.GetClassName()
                    raise ValueError(f"`{path}` holds images in time, got a {kind}; write {SUFFIX}")
                add(dataset)

            yield add_image


def _write_step(path, dataset, number):
    """Write a time step to the folder of a collection; its name in there."""
    suffix = PIECES.get(dataset.GetClassName(), ".vtm")
    name = f"{path.stem}/{path.stem}_{number:04}{suffix}"
    (path.parent / path.stem).mkdir(exist_ok=True)
    io.write_dataset(dataset, path.parent / name)
    return name


def check_writable(path):
    """`path` as a Path, if a series can be written there; an OSError names it."""
    path = Path(path)
    folder = check_replaceable(path).with_suffix("")
    if path.suffix.lower() == SUFFIX and folder.exists() and not folder.is_dir():
        raise FileExistsError(f"`{path}` cannot be written: `{folder}` is not a folder")
    return path


def _read(files):
    datasets = []
    try:
        for file in files:
            with step("read", file):
                datasets.append(io.read_dataset(file))
    except OSError as error:  # OSError is for the output
        raise ValueError(str(error)) from error
    return joined(datasets)


def _is_pattern(path):
    return bool(re.search(r"[*?\[]", str(path))) and not path.exists()


def _by_number(name):
    """A key that sorts names as their numbers go: 9 before 10."""
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", name)]


def _of_collection(path):
    """Times and names of files in a .pvd file."""
    try:
        root = ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:
        raise ValueError(f"it is not XML: {error}") from None
    if root.tag != "VTKFile" or root.get("type") != "Collection":
        raise ValueError("it is not a ParaView collection")
    return [(float(step.get("timestep", 0)), step.get("file", "")) for step in root.iter("DataSet")]


def _of_json(path):
    """Times and names of files in a .series file."""
    try:
        files = json.loads(path.read_text(encoding="utf-8"))["files"]
        return [(float(file.get("time", n)), str(file["name"])) for n, file in enumerate(files)]
    except (AttributeError, KeyError, RecursionError, TypeError) as error:
        raise ValueError(f"it is not a ParaView file series: {error!r:.100}") from None


_INDICES = {SUFFIX: _of_collection, ".series": _of_json}


def _write_collection(path, entries):
    lines = [
        f'    <DataSet timestep="{time!r}" part="0" file={quoteattr(name)}/>\n'
        for time, name in entries
    ]
    path.write_text(
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
        + "".join(lines)
        + "  </Collection>\n</VTKFile>\n",
        encoding="utf-8",
    )
