"""OME-Zarr images for tests, written with zarr alone."""

import numcodecs
import numpy as np
import zarr

SHAPE = (12, 20, 26)
SPACING, ORIGIN = (4.0, 2.0, 3.0), (5.0, -2.0, 3.0)  # z, y, x
HANDLES = np.array(  # world coordinates x, y, z of p and q
    [
        (10.5, 3, 15, 16.5, 4, 15),
        (63, 8, 21, 58.5, 10, 29),
        (21, 31, 41, 21, 26, 45),
        (70, 28, 45, 73, 31, 33),
        (42, 18, 29, 55, 18, 29),
    ]
)


def values(rng, lead=(), dtype="uint16"):
    """Noise on a slope, (*lead, z, y, x)."""
    slope = np.arange(SHAPE[2]) * 1000
    return (slope + rng.integers(0, 20000, (*lead, *SHAPE))).astype(dtype)


def halves(array, count=3, is_label=False):
    """Resolutions of an array, made slowly: windows of 2 x 2 x 2."""
    levels = [array]
    for _ in range(count - 1):
        array = levels[-1]
        size = [-(-n // 2) for n in array.shape[-3:]]
        result = np.zeros((*array.shape[:-3], *size), array.dtype)
        for place in np.ndindex(*size):
            rows = tuple(slice(2 * i, 2 * i + 2) for i in place)
            window = array[(..., *rows)]
            pads = [(0, 0)] * (array.ndim - 3) + [(0, 2 - n) for n in window.shape[-3:]]
            window = np.pad(window, pads, mode="edge").reshape(*array.shape[:-3], 8)
            mean = np.rint(window.mean(axis=-1, dtype=float))
            result[(..., *place)] = window[..., 0] if is_label else mean
        levels.append(result)
    return levels


def write(path, levels, version="0.5", chunks=(6, 8, 10), axes="zyx", stated=None, **metadata):
    """Write an image with these resolutions; each has half the size of the previous one.

    `stated` are other entries of axes, by their names.
    """
    file = zarr.open_group(path, mode="w", zarr_format=2 if version == "0.4" else 3)
    lead = len(axes.rstrip("zyx"))
    count = len(axes) - lead
    if version == "0.4":
        options = {"compressors": numcodecs.Blosc(cname="zstd", clevel=2)}
    else:
        options = {"compressors": zarr.codecs.BloscCodec(cname="lz4", clevel=2)}
        options["dimension_names"] = list(axes)
    datasets = []
    for number, level in enumerate(levels):
        array = file.create_array(
            f"scale{number}",
            shape=level.shape,
            dtype=level.dtype,
            chunks=(1,) * lead + chunks[-count:],
            **options,
        )
        array[...] = level
        scale = [n * 2.0**number for n in SPACING]
        shift = [a + n * (2.0**number - 1) / 2 for a, n in zip(ORIGIN, SPACING)]
        transforms = [
            {"type": "scale", "scale": [1.0] * lead + scale[-count:]},
            {"type": "translation", "translation": [0.0] * lead + shift[-count:]},
        ]
        datasets.append({"path": f"scale{number}", "coordinateTransformations": transforms})
    kinds = {"t": ("time", "second"), "c": ("channel", None)}
    described = []
    for name in axes:
        kind, unit = kinds.get(name, ("space", "micrometer"))
        more = {"unit": unit} if unit else {}
        described.append({"name": name, "type": kind, **more, **(stated or {}).get(name, {})})
    multiscale = {"name": "frog", "axes": described, "datasets": datasets}
    if version == "0.4":
        file.attrs.update({"multiscales": [{"version": "0.4", **multiscale}], **metadata})
    else:
        file.attrs.update({"ome": {"version": "0.5", "multiscales": [multiscale], **metadata}})
    return file


def files(folder):
    """The contents of all files of a folder, by their names."""
    return {
        str(file.relative_to(folder)): file.read_bytes()
        for file in sorted(folder.rglob("*"))
        if file.is_file()
    }
