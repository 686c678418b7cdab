"""An OME-Zarr image of version 0.4 or 0.5: its levels and grids, its axes, their names, units and
directions in a patient (RFC 4).
"""

import contextlib
import itertools
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vtk_mls.base import validation
from vtk_mls.base.errors import InputError
from vtk_mls.base.grid import Grid
from vtk_mls.base.messages import warn
from vtk_mls.files import frames, volumes
from vtk_mls.files.volumes import NANOMETERS, symbol

SUFFIX = ".zarr"
LABELS = "labels"  # name of the group of label images
_VERSIONS = "0.4", "0.5"
_AXES = "t", "c", "z", "y", "x"  # in the order of the specification
_ROUNDING = 0.01  # voxels
_ERRORS = (AttributeError, IndexError, KeyError, OSError, RuntimeError, TypeError, ValueError)


@dataclass(frozen=True, eq=False)
class Level:
    """One resolution of an image: the `path` of its array in the group of the image, the zarr.Array
    with the axes of the image, and the `grid` of its last axes z, y, x, in the unit of the image; z
    has one point without such an axis. The grid is in LPS if the file states the orientation of its
    axes.
    """

    path: str
    array: object
    grid: Grid


@dataclass(frozen=True, eq=False)
class Image:
    """A group with all resolutions of an image."""

    folder: Path
    axes: str  # names in order: the end of "tczyx", perhaps without t, c and z
    space: list  # dicts: what the file says about its axes z, y, x; with one unit, of lengths
    levels: list  # of Level, the finest first
    names: list  # of the channels, as far as the file has them
    labels: list  # names of the label images in its group `labels`
    is_label: bool  # whether its values are labels
    guess: str  # what had to be guessed, as a sentence; "" for nothing

    @property
    def finest(self):
        """The first Level."""
        return self.levels[0]

    @property
    def channel_names(self):
        """The name of each channel; those of the file if they differ."""
        count = self.finest.array.shape[self.axes.index("c")] if "c" in self.axes else 1
        if len(self.names) == count == len({*self.names} - {""}):
            return self.names
        return ["OME-Zarr"] if count == 1 else [f"channel {n + 1}" for n in range(count)]

    def methods(self, interpolation):
        """The interpolation of each channel, given that of all or of each; of labels "nearest"."""
        count = len(self.channel_names)
        methods = (interpolation,) * count if isinstance(interpolation, str) else interpolation
        return ("nearest",) * count if self.is_label else methods

    def windows(self, index):
        """The windows of a level in an earlier one, along (z, y, x).

        The earlier one, whose number is returned first, is the last that is a whole number of times
        finer, or else the one before. Then come (3,) the distance of the centers of windows, the
        first of them, and the points of a window, in indices of the earlier level. If windows do
        not touch each other from the border on, the level was made by sampling, and has 1 point. A
        ValueError says that it is finer than the one before, or lies elsewhere.
        """
        found = [self._windows(index, source) for source in range(index)][::-1]
        _, steps, first, _ = found[0]
        size, count = (np.array(self.levels[n].grid.shape) for n in (index - 1, index))
        low = first - steps / 2 + 0.5
        gaps = np.abs([low, low + steps * count - size])
        if not ((steps > 1 - _ROUNDING) & (gaps < steps)).all():
            raise ValueError(
                f"`{self.folder}`: level `{self.levels[index].path}` must be coarser than the one "
                f"before and in the same place, got points at steps of {steps.tolist()} points "
                f"from {first.tolist()} on (z, y, x)"
            )
        are_whole = (window for window in found if (window[1] == np.rint(window[1])).all())
        return next(are_whole, found[0])

    def _windows(self, index, source):
        coarser = self.levels[index].grid
        matrix, first = coarser.index_transform(self.levels[source].grid)
        steps, first = matrix.diagonal()[::-1], first[::-1]
        whole, half = np.rint(steps), np.rint(2 * first) / 2
        steps = np.where(np.abs(steps - whole) * coarser.shape < _ROUNDING, whole, steps)
        first = np.where(np.abs(first - half) < _ROUNDING, half, first)
        is_mean = np.abs(first - (steps - 1) / 2) < _ROUNDING
        return source, steps, first, np.where(is_mean, steps, 1.0)

    def channels(self, level):
        """Name and values (nz, ny, nx) of each channel of a level; a ValueError says that there are
        several times, or that the file is broken.
        """
        lead = level.array.shape[: len(self.axes.rstrip("zyx"))]
        if self.axes[0] == "t" and lead[0] > 1:
            raise ValueError(
                f"it has {lead[0]} times, expected one; only `vtk-mls deform` and `vtk-mls field` "
                "to another OME-Zarr take several"
            )
        for name, place in zip(self.channel_names, np.ndindex(*lead)):
            try:
                spatial = map(slice, (0,) * 3, level.array.shape[len(lead) :])
                rows = (*(slice(n, n + 1) for n in place), *spatial)
                values = read(level.array, rows).reshape(level.grid.shape)
            except (OSError, RuntimeError, ValueError) as error:
                raise ValueError(f"its level `{level.path}` is broken: {_text(error)}") from error
            yield name, validation.native_array(values)


def is_ome_zarr(path):
    """Whether a path is the name of an OME-Zarr, or an image in one."""
    path = Path(path)
    return path.name.lower().endswith(SUFFIX) or has_metadata(path)


def has_metadata(path):
    """Whether a folder is a group of zarr."""
    return any((path / name).is_file() for name in ("zarr.json", ".zgroup"))


def read(array, place):
    """The values of a zarr.Array in slices.

    They are read chunk by chunk: zarr reads the chunks of one call concurrently, and after a broken
    one it prints the errors of the remaining tasks.
    """
    values = np.empty([rows.stop - rows.start for rows in place], array.dtype)
    for part, where in _chunks_in(array, place):
        _check_chunk(array, part)
        values[where] = array[part]
    return values


def _check_chunk(array, place):
    """Raise ValueError if a chunk of Blosc is truncated: it would be read from foreign memory."""
    if array.shards or not any("Blosc" in type(codec).__name__ for codec in array.compressors):
        return
    index = [rows.start // n for rows, n in zip(place, array.chunks)]
    key = array.metadata.encode_chunk_key(tuple(index))
    file = Path(array.store.root, array.path, key)
    if not file.is_file():  # all values are the fill value
        return
    with file.open("rb") as chunk:
        head = chunk.read(16)
        size = chunk.seek(0, 2)
    if len(head) < 16 or int.from_bytes(head[12:], "little") > size:
        raise ValueError(f"its chunk `{array.path}/{key}` is truncated")


def write(array, place, values):
    """Write values in slices of a zarr.Array, chunk by chunk."""
    for part, where in _chunks_in(array, place):
        array[part] = values[where]


def _chunks_in(array, place):
    """Slices of the array, and of the values in `place`, for each chunk that these touch."""
    pairs = []
    for rows, n in zip(place, array.shards or array.chunks):
        bounds = [rows.start, *range((rows.start // n + 1) * n, rows.stop, n), rows.stop]
        ends = zip(bounds, bounds[1:])
        pairs.append([(slice(a, b), slice(a - rows.start, b - rows.start)) for a, b in ends])
    for chunk in itertools.product(*pairs):
        yield tuple(zip(*chunk))


def open_image(path, mode="r"):
    """The Image of a folder; with the mode "r+" its arrays can be written to.

    Errors (OSError, ValueError) name it.
    """
    path = Path(path)
    if not path.is_dir():
        missing = "is a file" if path.exists() else "does not exist"
        raise FileNotFoundError(f"`{path}` {missing}; expected the folder of an OME-Zarr")
    zarr = _zarr(path)
    try:
        return _image(path, zarr.open_group(path, mode=mode, use_consolidated=False))
    except _ERRORS as error:
        raise InputError(f"is not a readable OME-Zarr: {_text(error)}", path=path) from error


def open_input(path):
    """The Image of a folder; a warning says what had to be guessed."""
    image = open_image(path)
    if image.guess:
        warn(f"`{path}`: {image.guess}")
    return image


def state_method(path, method):
    """Write the method of the coarser levels in the metadata of an image, if they name another."""
    group = _zarr(path).open_group(path, mode="r+", use_consolidated=False)
    attributes = dict(group.attrs)
    entries = attributes.get("ome", attributes)["multiscales"]
    entry, image = entries[0], _image(path, group)
    if entries[1:]:  # other images, which are not deformed
        del entries[1:]
        group.attrs.update(attributes)
    if "type" in entry:
        is_sampled = len(image.levels) > 1 and (image.windows(1)[3] == 1).all()
        entry["type"] = "nearest" if is_sampled else method
        entry.pop("metadata", None)  # of that method
        group.attrs.update(attributes)


def _zarr(path):
    try:
        import zarr
    except ModuleNotFoundError as error:
        raise OSError(f"`{path}` needs the package zarr: pip install 'vtk-mls[zarr]'") from error
    return zarr


def _text(error):
    """The sentence of an error, without the type."""
    name = type(error).__name__
    text = str(error).strip() or name
    return f"{name} {text}" if isinstance(error, (KeyError, AttributeError)) else text


def _image(path, group):
    attributes = dict(group.attrs)
    metadata = attributes.get("ome", attributes)
    _check_content(path, metadata)
    entry = metadata["multiscales"][0]
    version = str(metadata.get("version", entry.get("version", _VERSIONS[0])))
    if version not in _VERSIONS:
        raise ValueError(f"its version must be {' or '.join(_VERSIONS)}, got {version}")
    axes = _axis_names(entry["axes"])
    is_in_labels, image_space = _image_of_labels(path)
    space = entry["axes"][len(axes.rstrip("zyx")) :]
    space, lengths, no_unit = _in_space(space, image_space)
    directions, no_frame = _directions(space)
    levels = [
        _level(group, axes, entry, dataset, lengths, directions) for dataset in entry["datasets"]
    ]
    if not levels:
        raise ValueError("it has no resolutions")
    dtypes = sorted({str(level.array.dtype) for level in levels})
    if len(dtypes) > 1:
        raise ValueError(f"its resolutions must have one type, got {' and '.join(dtypes)}")
    sizes = [level.grid.size for level in levels]
    if sizes != sorted(sizes, reverse=True):
        raise ValueError(f"its finest resolution must be the first, got {sizes} points")
    channels = (metadata.get("omero") or {}).get("channels") or ()
    names = [str(channel.get("label", "")) for channel in channels]
    is_label = "image-label" in metadata or is_in_labels or dtypes == ["bool"]
    guess = "; ".join(filter(None, (no_unit, no_frame)))
    return Image(path, axes, space, levels, names, _labels(path, group), is_label, guess)


def _check_content(path, metadata):
    if "plate" in metadata or "well" in metadata:
        raise ValueError("it is a plate or a well; name one of its images")
    if "multiscales" in metadata:
        return
    if (path / "0").is_dir() and "bioformats2raw.layout" in metadata:
        raise ValueError(f"it is a collection of images; name one, such as `{path / '0'}`")
    raise ValueError("it has no `multiscales`")


def _axis_names(entries):
    """The names of axes in lower case, as one text."""
    names = [str(entry["name"]).lower() for entry in entries]
    is_ordered = names == [name for name in _AXES if name in names]
    if not is_ordered or names[-2:] != ["y", "x"]:
        raise ValueError(
            "its axes must be t, c, z, y, x in this order, where t, c and z are optional, "
            f"got {', '.join(names)[:80]}"
        )
    return "".join(names)


def _in_space(entries, image_entries):
    """Entries of axes in space with one unit, the lengths of their own units, and what is guessed.

    The unit is that of the last axis that has one. Label images take unit and orientation from the
    entries of their image, if it has some.
    """
    space = [{**entry, "name": str(entry["name"]).lower()} for entry in entries]
    if not any(map(_orientation, space)):
        stated = {axis["name"]: axis["orientation"] for axis in image_entries if _orientation(axis)}
        for axis in space:
            axis |= {"orientation": stated[axis["name"]]} if axis["name"] in stated else {}
    units = [axis.get("unit") or "" for axis in space]
    image_units = [axis.get("unit") or "" for axis in image_entries]
    unit = next(filter(None, (*image_units, *units[::-1])), "")
    missing = ", ".join(axis["name"] for axis, own in zip(space, units) if unit and not own)
    units = [own or unit for own in units]
    nanometers = [NANOMETERS.get(symbol(name)) for name in (unit, *units)]
    lengths = [1.0] * len(units)
    if {*units} != {unit} and None not in nanometers:
        lengths = [float(f"{own / nanometers[0]:.12g}") for own in nanometers[1:]]
    elif {*units} != {unit}:
        raise ValueError(
            f"its axes in space must have units of length, got {', '.join(sorted({unit, *units}))}"
        )
    if unit:
        space = [{**axis, "unit": unit} for axis in space]
    is_guess = missing and not image_entries
    return space, lengths, f"{missing} has no unit; {unit} is assumed" if is_guess else ""


def _directions(space):
    """Columns (3, 3) along x, y, z in LPS (the identity if not stated), and what is guessed."""
    words = [_orientation(axis) for axis in space[::-1]]
    if not any(words):
        return np.eye(3), ""
    columns = np.zeros((3, 3))
    columns[:, : len(words)] = np.transpose([frames.direction(word) for word in words])
    columns = volumes.full_steps(columns, (2, 2, len(words) - 1))
    if np.linalg.matrix_rank(columns) == 3:
        return columns, ""
    listed = ", ".join(f"{axis['name']} {word or '?'}" for axis, word in zip(space[::-1], words))
    return np.eye(3), f"the orientation ({listed}) does not give LPS; positions are used as LPS"


def _orientation(axis):
    """What an axis states, as "left-to-right"; "" for nothing about a patient."""
    stated = axis.get("orientation") or ""
    if isinstance(stated, dict):
        stated = stated.get("value") if stated.get("type") == "anatomical" else ""
    return str(stated)


def _level(group, axes, entry, dataset, lengths, directions):
    path = dataset["path"]
    array = group[path]
    if not hasattr(array, "dtype"):
        raise ValueError(f"`{path}` must be an array, got a group")
    if array.ndim != len(axes):
        raise ValueError(f"array `{path}` must have the axes {axes}, got {array.ndim} axes")
    if array.dtype.kind not in "biuf" or array.dtype.itemsize > 8:
        raise ValueError(f"array `{path}` must hold integers or floats, got {array.dtype}")
    if 0 in array.shape:
        raise ValueError(f"array `{path}` is empty, got {array.shape}")
    scale, shift = np.ones(len(axes)), np.zeros(len(axes))
    common = entry.get("coordinateTransformations") or ()
    for transform in (*dataset["coordinateTransformations"], *common):
        scale, shift = _after(transform, scale, shift)
    if not (np.isfinite(scale) & (scale > 0)).all() or not np.isfinite(shift).all():
        raise ValueError(f"scales of `{path}` must be positive, got {scale.tolist()}")
    count = len(lengths)
    missing = 3 - count
    shape = [1] * missing + list(array.shape[-count:])
    spacing = [1.0] * missing + (scale[-count:] * lengths).tolist()
    origin = [0.0] * missing + (shift[-count:] * lengths).tolist()
    grid = Grid(shape[::-1], directions @ origin[::-1], spacing[::-1], directions)
    return Level(path, array, grid)


def _after(transform, scale, shift):
    """Scale and translation after another transform."""
    kind = transform["type"]
    if kind == "identity":
        return scale, shift
    if kind not in ("scale", "translation") or kind not in transform:
        raise ValueError(f"its transforms must be scales and translations, got {kind!r:.60}")
    numbers = np.array(transform[kind], float)
    if numbers.shape != scale.shape:
        raise ValueError(f"a {kind} must have {len(scale)} numbers, got {numbers.tolist()}")
    return (scale * numbers, shift * numbers) if kind == "scale" else (scale, shift + numbers)


def _labels(path, group):
    """Names of label images, listed or not."""
    folder = path / LABELS
    if not folder.is_dir():
        return []
    attributes = dict(group[LABELS].attrs) if LABELS in group else {}
    listed = [str(name) for name in attributes.get("ome", attributes).get("labels", [])]
    found = sorted(child.name for child in folder.iterdir() if has_image(child))
    return list(dict.fromkeys([*listed, *found]))


def _image_of_labels(path):
    """Whether an image stands in the group `labels` of another, and the `space` of this Image."""
    for folder in path.resolve().parents:
        if folder.name == LABELS and has_metadata(folder.parent):
            with contextlib.suppress(OSError, ValueError):
                return True, open_image(folder.parent).space
            return True, []
    return False, []


def complete_labels(source, target):
    """Write to a copy of a label image what its place in `labels` says, if it is not there."""
    if not _image_of_labels(source)[0] or _image_of_labels(target)[0]:
        return
    image, group = open_image(source), _zarr(target).open_group(target, mode="r+")
    attributes = dict(group.attrs)
    metadata = attributes.get("ome", attributes)
    metadata.setdefault("image-label", {})
    for axis, stated in zip(metadata["multiscales"][0]["axes"][::-1], image.space[::-1]):
        axis |= {**stated, **axis}
    group.attrs.update(attributes)


def is_array(folder):
    file = folder / "zarr.json"
    is_v3 = file.is_file() and json.loads(file.read_text()).get("node_type") == "array"
    return is_v3 or (folder / ".zarray").is_file()


def has_image(folder):
    """Whether a group of zarr is an image, or has one in it."""
    files = (file for name in ("zarr.json", ".zattrs") for file in folder.rglob(name))
    return any('"multiscales"' in file.read_text() for file in files)
