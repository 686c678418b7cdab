"""An OME-Zarr image of version 0.4 or 0.5: its levels, axes and grids."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vtk_mls.base import validation
from vtk_mls.base.grid import Grid

SUFFIX = ".zarr"
_VERSIONS = "0.4", "0.5"
_AXES = "t", "c", "z", "y", "x"  # in the order of the specification
_ERRORS = (AttributeError, IndexError, KeyError, OSError, RuntimeError, TypeError, ValueError)


@dataclass(frozen=True, eq=False)
class Level:
    """One resolution of an image.

    Attributes
    ----------
    path : str
        Of its array, in the group of the image.
    array : zarr.Array
        With the axes of the image.
    grid : Grid
        Of its last axes z, y, x, in the units of the file; z has one point without such an axis.
    """

    path: str
    array: object
    grid: Grid


@dataclass(frozen=True, eq=False)
class Image:
    """A group with all resolutions of an image.

    Attributes
    ----------
    folder : Path
    axes : str
        Their names, in order: the end of "tczyx", perhaps without t, c and z.
    unit : str
        Of the axis x; "" if the file does not say.
    levels : list of Level
        The finest first.
    names : list of str
        Of the channels, as far as the file has them.
    labels : list of str
        Names of the label images in its group `labels`.
    is_label : bool
        Whether its values are labels.
    """

    folder: Path
    axes: str
    unit: str
    levels: list
    names: list
    labels: list
    is_label: bool

    @property
    def finest(self):
        """The first Level."""
        return self.levels[0]

    def factors(self, index):
        """How many points of the level before, (z, y, x), are one point of a level.

        Raises
        ------
        ValueError
            If it is not a whole number.
        """
        finer, coarser = self.levels[index - 1].grid, self.levels[index].grid
        ratio = coarser.spacing[::-1] / finer.spacing[::-1]
        factors = np.maximum(np.rint(ratio), 1).astype(int)
        size, coarse_size = np.array(finer.shape), np.array(coarser.shape)
        is_whole = np.abs(ratio - factors) <= factors / np.maximum(coarse_size, 1)
        is_covered = ((coarse_size - 1) * factors < size) & (size < (coarse_size + 1) * factors)
        if not (is_whole & is_covered).all():
            raise ValueError(
                f"`{self.folder}`: level `{self.levels[index].path}` must be a whole number of "
                f"times coarser than the one before, got {coarser.shape} after {finer.shape}"
            )
        return tuple(factors.tolist())

    def level_within(self, max_points):
        """The finest Level of at most so many points, or the coarsest; the finest for None."""
        fitting = [
            level for level in self.levels if max_points is None or level.grid.size <= max_points
        ]
        return (fitting or self.levels[-1:])[0]

    def channels(self, level):
        """Name and values (nz, ny, nx) of each channel of a level.

        Raises
        ------
        ValueError
            If there are several times, or the file is broken.
        """
        lead = level.array.shape[: len(self.axes.rstrip("zyx"))]
        if self.axes[0] == "t" and lead[0] > 1:
            raise ValueError(
                f"it has {lead[0]} times, expected one; only `vtk-mls deform` and `vtk-mls field` "
                "to another OME-Zarr take several"
            )
        count = int(np.prod(lead, dtype=int))
        names = self.names if len(set(self.names)) == count else []
        for index, place in enumerate(np.ndindex(*lead)):
            try:
                spatial = map(slice, (0,) * 3, level.array.shape[len(lead) :])
                rows = (*(slice(n, n + 1) for n in place), *spatial)
                values = read(level.array, rows).reshape(level.grid.shape)
            except (OSError, RuntimeError, ValueError) as error:
                raise ValueError(f"its level `{level.path}` is broken: {_text(error)}") from error
            default = "OME-Zarr" if count == 1 else f"channel {index + 1}"
            yield (names[index] if names else default), validation.native_array(values)


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
        pairs.append(
            [
                (slice(a, b), slice(a - rows.start, b - rows.start))
                for a, b in itertools.pairwise(bounds)
            ]
        )
    for chunk in itertools.product(*pairs):
        yield tuple(zip(*chunk))


def open_image(path, mode="r"):
    """The Image of a folder; with the mode "r+" its arrays can be written to.

    Raises
    ------
    OSError, ValueError
        Naming it.
    """
    path = Path(path)
    if not path.is_dir():
        missing = "is a file" if path.exists() else "does not exist"
        raise FileNotFoundError(f"`{path}` {missing}; expected the folder of an OME-Zarr")
    zarr = _zarr(path)
    try:
        group = zarr.open_group(path, mode=mode, use_consolidated=False)
    except _ERRORS as error:
        raise ValueError(f"`{path}` is not an OME-Zarr: {_text(error)}") from error
    try:
        return _image(path, group)
    except _ERRORS as error:
        raise ValueError(f"`{path}` is not a readable OME-Zarr: {_text(error)}") from error


def state_method(path, method):
    """Write the method of the coarser levels in the metadata of an image, if they name another."""
    group = _zarr(path).open_group(path, mode="r+", use_consolidated=False)
    attributes = dict(group.attrs)
    entry = attributes.get("ome", attributes)["multiscales"][0]
    if "type" in entry:
        entry["type"] = method
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
    axes = _axes(entry["axes"])
    levels = [_level(group, axes, entry, dataset) for dataset in entry["datasets"]]
    if not levels:
        raise ValueError("it has no resolutions")
    dtypes = sorted({str(level.array.dtype) for level in levels})
    if len(dtypes) > 1:
        raise ValueError(f"its resolutions must have one type, got {' and '.join(dtypes)}")
    sizes = [level.grid.size for level in levels]
    if sizes != sorted(sizes, reverse=True):
        raise ValueError(f"its finest resolution must be the first, got {sizes} points")
    unit = entry["axes"][-1].get("unit") or ""
    channels = (metadata.get("omero") or {}).get("channels") or ()
    names = [str(channel.get("label", "")) for channel in channels]
    labels = _labels(path, group)
    return Image(path, axes, unit, levels, names, labels, "image-label" in metadata)


def _check_content(path, metadata):
    if "plate" in metadata or "well" in metadata:
        raise ValueError("it is a plate or a well; name one of its images")
    if "multiscales" in metadata:
        return
    if (path / "0").is_dir() and "bioformats2raw.layout" in metadata:
        raise ValueError(f"it is a collection of images; name one, such as `{path / '0'}`")
    raise ValueError("it has no `multiscales`")


def _axes(entries):
    names = [entry["name"] for entry in entries]
    is_ordered = names == [name for name in _AXES if name in names]
    if not is_ordered or names[-2:] != ["y", "x"]:
        raise ValueError(
            "its axes must be t, c, z, y, x in this order, where t, c and z are optional, "
            f"got {', '.join(map(str, names))[:80]}"
        )
    units = {entry.get("unit") for entry in entries if entry["name"] in "zyx"}
    if len(units) > 1:
        listed = ", ".join(sorted(map(str, units)))
        raise ValueError(f"its axes in space must have one unit, got {listed}")
    return "".join(names)


def _level(group, axes, entry, dataset):
    path = dataset["path"]
    array = group[path]
    if not hasattr(array, "dtype"):
        raise ValueError(f"`{path}` must be an array, got a group")
    if array.ndim != len(axes):
        raise ValueError(f"array `{path}` must have the axes {axes}, got {array.ndim} axes")
    if array.dtype.kind not in "iuf" or array.dtype.itemsize > 8:
        raise ValueError(f"array `{path}` must hold integers or floats, got {array.dtype}")
    if 0 in array.shape:
        raise ValueError(f"array `{path}` is empty, got {array.shape}")
    scale, shift = np.ones(len(axes)), np.zeros(len(axes))
    common = entry.get("coordinateTransformations") or ()
    for transform in (*dataset["coordinateTransformations"], *common):
        scale, shift = _after(transform, scale, shift)
    if not (np.isfinite(scale) & (scale > 0)).all() or not np.isfinite(shift).all():
        raise ValueError(f"scales of `{path}` must be positive, got {scale.tolist()}")
    count = len(axes.lstrip("tc"))
    missing = 3 - count
    shape = [1] * missing + list(array.shape[-count:])
    spacing = [1.0] * missing + scale[-count:].tolist()
    origin = [0.0] * missing + shift[-count:].tolist()
    return Level(path, array, Grid(shape[::-1], origin[::-1], spacing[::-1]))


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
    """Names of label images."""
    if not (path / "labels").is_dir() or "labels" not in group:
        return []
    attributes = dict(group["labels"].attrs)
    return [str(name) for name in attributes.get("ome", attributes).get("labels", [])]
