"""Values of images along the axes of the world, and presets of colors and opacities for them."""

from dataclasses import dataclass

import numpy as np
from vtkmodules.vtkCommonCore import VTK_BIT, VTK_DOUBLE, VTK_UNSIGNED_CHAR
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

_MAX_SAMPLES = 1 << 20
_MAX_LABELS = 512
_DARK_MARGIN = 0.4  # below the range of a preset, relative to it, where slices turn black
_AIR, _BONE = -400, 300  # Hounsfield units below and above which a CT image has values


@dataclass(frozen=True)
class TransferFunctionPreset:
    """Colors (value, red, green, blue) and opacities (value, opacity) as functions of values.

    Opacities are those of a layer one voxel thick; with `is_nearest` nothing is interpolated.
    """

    name: str
    colors: tuple
    opacities: tuple
    is_nearest: bool = False


_CT = (
    TransferFunctionPreset(
        "CT, soft tissue and bone",
        (
            (-400, 0.55, 0.25, 0.15),
            (-50, 0.80, 0.48, 0.36),
            (120, 0.87, 0.62, 0.48),
            (250, 0.98, 0.88, 0.72),
            (1500, 1.0, 0.99, 0.95),
        ),
        ((-400, 0), (-150, 0.03), (20, 0.10), (150, 0.2), (300, 0.75), (3000, 0.9)),
    ),
    TransferFunctionPreset(
        "CT, bone",
        ((150, 0.75, 0.55, 0.38), (400, 0.95, 0.86, 0.70), (1500, 1.0, 0.99, 0.95)),
        ((160, 0), (350, 0.7), (3000, 0.95)),
    ),
    TransferFunctionPreset(
        "CT, skin",
        ((-500, 0.62, 0.38, 0.28), (-100, 0.93, 0.72, 0.60), (3000, 1.0, 0.92, 0.84)),
        ((-500, 0), (-250, 0.85), (3000, 0.95)),
    ),
)
# Soft tissue, from the threshold to air (0) to the brightest values (1).
_TISSUE = (
    (0.0, 0.82, 0.56, 0.47),
    (0.35, 0.88, 0.66, 0.55),
    (0.7, 0.96, 0.84, 0.73),
    (1.0, 1.0, 0.97, 0.92),
)
_GRAY = ((0.0, 0.15, 0.16, 0.18), (1.0, 1.0, 1.0, 1.0))
_HUES = np.array(
    [
        *((0.90, 0.37, 0.34), (0.36, 0.66, 0.89), (0.97, 0.78, 0.36), (0.45, 0.77, 0.49)),
        *((0.72, 0.53, 0.86), (0.95, 0.58, 0.27), (0.40, 0.80, 0.78), (0.93, 0.60, 0.74)),
        *((0.76, 0.72, 0.55), (0.60, 0.68, 0.75)),
    ]
)


def presets_of(values, are_labels):
    """A list of presets for an image with values (n,), the best first.

    `are_labels`: the file declares the values to be labels of segments.
    """
    samples = _finite(values)
    low, high = (samples.min(), samples.max()) if len(samples) else (0.0, 1.0)
    if are_labels and high - low < _MAX_LABELS:
        return [_label_preset(np.unique(samples))]
    level = _threshold(samples, low, high) if low < high else low - max(1, abs(low) / 100)
    top = np.quantile(samples[samples >= level], 0.995) if len(samples) else high
    top = top if top > level else max(high, level + 1e-6 * max(1.0, abs(level)))
    tissue = (
        _scaled("MR, solid", _TISSUE, ((0, 0), (0.15, 0.4), (0.4, 0.8), (1, 0.95)), level, top),
        _scaled("MR, see-through", _TISSUE, ((0, 0), (0.5, 0.08), (1, 0.6)), level, top),
        _scaled("gray", _GRAY, ((0, 0), (0.3, 0.3), (1, 0.9)), level, top),
    )
    is_ct = low < _AIR and np.quantile(samples, 0.01) < _AIR and high > _BONE
    return [*_CT, *tissue] if is_ct else [*tissue]


def _finite(values):
    """Finite values of a sample of values (n,), as float64."""
    samples = values[:: max(1, len(values) // _MAX_SAMPLES)].astype(float)
    return samples[np.isfinite(samples)]


def opacity(preset, values):
    """Opacities (n,) of values (n,)."""
    nodes, opacities = np.transpose(preset.opacities)
    with np.errstate(invalid="ignore"):
        return np.nan_to_num(np.interp(values, nodes, opacities))


def gray_range(preset):
    """The values that are black and white in slices: below the range of the preset, and its end.

    Slices also show values that are transparent in the volume.
    """
    low, high = preset.colors[0][0], preset.colors[-1][0]
    return low - _DARK_MARGIN * (high - low), high


def slice_colors(preset, values, limits=None):
    """Colors (n, 3), 0 to 255, of values (n,) in a slice: gray, or the colors of labels.

    `limits` are the values that are black and white, those of `gray_range` by default.
    """
    if not preset.is_nearest:
        return shades(values[:, None] * np.ones(3), limits or gray_range(preset))
    nodes = np.array([value for value, *_ in preset.colors])
    hues = np.array([color for _, *color in preset.colors])
    colors = hues[np.clip(np.searchsorted(nodes, values), 0, len(nodes) - 1)]
    colors = colors * (opacity(preset, values) > 0)[:, None]
    return np.rint(255 * colors).astype(np.uint8)


def shades(values, limits):
    """Values (n, 3) as colors, 0 to 255, with `limits` that are black and white."""
    low, high = limits
    with np.errstate(invalid="ignore"):
        colors = np.clip((values - low) / max(high - low, 1e-30), 0, 1)
    return np.rint(255 * np.nan_to_num(colors)).astype(np.uint8)


def value_range(values):
    """The lowest and the highest of values (...), without a few outliers."""
    low, high = np.quantile(_finite(values.ravel()), (0.001, 0.999))
    return (low, high) if low < high else (low - 1, high)


def _scaled(name, colors, opacities, low, high):
    """A preset over fractions of the range from `low` to `high`."""
    return TransferFunctionPreset(
        name,
        tuple((low + fraction * (high - low), *color) for fraction, *color in colors),
        tuple((low + fraction * (high - low), opacity) for fraction, opacity in opacities),
    )


def _label_preset(values):
    """A color for each label; the background, 0 or the lowest value, is transparent."""
    background = 0 if 0 in values else values.min(initial=0)
    colors = [(value, *_HUES[int(value) % len(_HUES)]) for value in values]
    steps = [(background - 0.5, 0.0)]
    for value in values:
        height = 0.0 if value == background else 0.85
        steps += [(value - 0.49, height), (value + 0.49, height)]
    return TransferFunctionPreset("segments", tuple(colors), tuple(sorted(steps)), is_nearest=True)


def _threshold(values, low, high):
    """Otsu's threshold, without the highest 0.1 % of the values."""
    if len(values) == 0 or high <= low:
        return low
    ceiling = np.quantile(values, 0.999)
    counts, edges = np.histogram(values, 256, (low, ceiling if ceiling > low else high))
    centers = (edges[:-1] + edges[1:]) / 2
    below, total = np.cumsum(counts), np.cumsum(counts * centers)
    above = below[-1] - below
    with np.errstate(all="ignore"):
        variance = below * above * (total / below - (total[-1] - total) / above) ** 2
    return float(edges[1 + np.nan_to_num(variance[:-1]).argmax()])


def colors_of(image):
    """Colors (nz, ny, nx, 3), 0 to 255, along axes of the world; None for other values."""
    values = arrays.to_numpy(_numeric_array(image))
    if values.ndim == 1 or values.dtype != np.uint8 or values.shape[1] not in (3, 4):
        return None
    _, reorder = arrays.along_world_axes(ImageGeometry.of_image(image).grid)
    return reorder(values[:, :3].reshape(*image.GetDimensions()[::-1], 3))


def scalar_image(image):
    """A copy of a vtkImageData with one scalar per point and axes along those of the world.

    The scalars are the active ones, or the first array; the mean of several components. Axes are
    permuted and mirrored, as VTK 9.7 lights volumes without their direction matrix: if that mirrors
    axes, as in most NIfTI files, surfaces towards the light are dark. Without numbers at its
    points, ValueError.
    """
    array = _numeric_array(image)
    values, vtk_type = arrays.to_numpy(array), array.GetDataType()
    if values.ndim > 1:
        values, vtk_type = values.mean(axis=1, dtype=float), VTK_DOUBLE
    elif vtk_type == VTK_BIT:
        vtk_type = VTK_UNSIGNED_CHAR
    values = values.reshape(image.GetDimensions()[::-1])
    grid, reorder = arrays.along_world_axes(ImageGeometry.of_image(image).grid)
    copy = ImageGeometry.of_grid(grid).apply_to(vtkImageData())
    scalars = arrays.from_numpy(np.ascontiguousarray(reorder(values)).ravel(), vtk_type)
    scalars.SetName(array.GetName() or "values")
    copy.GetPointData().SetScalars(scalars)
    return copy


def _numeric_array(image):
    """The active scalars, or the first array of numbers."""
    data = image.GetPointData()
    candidates = [data.GetScalars(), *map(data.GetArray, range(data.GetNumberOfArrays()))]
    numeric = [array for array in candidates if array is not None and arrays.is_numeric(array)]
    if not numeric:
        raise ValueError("the image has no values at its points to show; only those of cells")
    return numeric[0]
