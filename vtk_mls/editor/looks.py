"""How images look by themselves: colours and opacities by what their values are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_SAMPLED = 1 << 20  # values that are looked at
_MOST_LABELS = 512
_DARKER = 0.4  # of the range of a look, below which slices are black
_AIR, _BONE = -400, 300  # Hounsfield units that images of computed tomography reach


@dataclass(frozen=True)
class Look:
    """Colours and opacities over values.

    Attributes
    ----------
    name : str
    colours : tuple of (value, red, green, blue)
    opacities : tuple of (value, opacity)
        Of a layer as thick as a voxel.
    is_nearest : bool
        Whether values must not be mixed.
    """

    name: str
    colours: tuple
    opacities: tuple
    is_nearest: bool = False


_CT = (
    Look(
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
    Look(
        "CT, bone",
        ((150, 0.75, 0.55, 0.38), (400, 0.95, 0.86, 0.70), (1500, 1.0, 0.99, 0.95)),
        ((160, 0), (350, 0.7), (3000, 0.95)),
    ),
    Look(
        "CT, skin",
        ((-500, 0.62, 0.38, 0.28), (-100, 0.93, 0.72, 0.60), (3000, 1.0, 0.92, 0.84)),
        ((-500, 0), (-250, 0.85), (3000, 0.95)),
    ),
)
# Of soft tissue, from the level that parts it from air to the brightest.
_TISSUE = (
    (0.0, 0.82, 0.56, 0.47),
    (0.35, 0.88, 0.66, 0.55),
    (0.7, 0.96, 0.84, 0.73),
    (1.0, 1.0, 0.97, 0.92),
)
_GREY = ((0.0, 0.15, 0.16, 0.18), (1.0, 1.0, 1.0, 1.0))
_HUES = np.array(
    [
        *((0.90, 0.37, 0.34), (0.36, 0.66, 0.89), (0.97, 0.78, 0.36), (0.45, 0.77, 0.49)),
        *((0.72, 0.53, 0.86), (0.95, 0.58, 0.27), (0.40, 0.80, 0.78), (0.93, 0.60, 0.74)),
        *((0.76, 0.72, 0.55), (0.60, 0.68, 0.75)),
    ]
)


def looks_of(values, are_labels):
    """The looks that suit an image, the best first.

    Parameters
    ----------
    values : (n,) array of real numbers
    are_labels : bool
        Whether the file says that they are numbers of segments.

    Returns
    -------
    list of Look
    """
    some = values[:: max(1, len(values) // _SAMPLED)].astype(float)
    some = some[np.isfinite(some)]
    low, high = (some.min(), some.max()) if len(some) else (0.0, 1.0)
    if are_labels and high - low < _MOST_LABELS:
        return [_of_labels(np.unique(some))]
    level = _level(some, low, high)
    top = np.quantile(some[some >= level], 0.995) if len(some) else high
    top = top if top > level else max(high, level + 1e-6 * max(1.0, abs(level)))
    tissue = (
        _over("MR, solid", _TISSUE, ((0, 0), (0.15, 0.4), (0.4, 0.8), (1, 0.95)), level, top),
        _over("MR, see-through", _TISSUE, ((0, 0), (0.5, 0.08), (1, 0.6)), level, top),
        _over("grey", _GREY, ((0, 0), (0.3, 0.3), (1, 0.9)), level, top),
    )
    is_ct = low < _AIR and high > _BONE
    return [*_CT, *tissue] if is_ct else [*tissue]


def opacity(look, values):
    """Opacities (n,) of values (n,)."""
    at, opacities = np.transpose(look.opacities)
    with np.errstate(invalid="ignore"):
        return np.nan_to_num(np.interp(values, at, opacities))


def slice_colours(look, values):
    """Colours (n, 3), 0 to 255, of values (n,) in a slice: grey over the look's range, or labels'.

    Below the values that the look shows there is room for darker ones, which slices show, too.
    """
    at = np.array([value for value, *_ in look.colours])
    with np.errstate(invalid="ignore"):
        if look.is_nearest:
            hues = np.array([colour for _, *colour in look.colours])
            shown = hues[np.clip(np.searchsorted(at, values), 0, len(at) - 1)]
            shown = shown * (opacity(look, values) > 0)[:, None]
        else:
            low, high = at[0] - _DARKER * (at[-1] - at[0]), at[-1]
            shown = np.clip((values - low) / max(high - low, 1e-30), 0, 1)[:, None] * np.ones(3)
    return np.rint(255 * np.nan_to_num(shown)).astype(np.uint8)


def _over(name, colours, opacities, low, high):
    """A look whose values are fractions between two others."""
    return Look(
        name,
        tuple((low + share * (high - low), *colour) for share, *colour in colours),
        tuple((low + share * (high - low), opacity) for share, opacity in opacities),
    )


def _of_labels(values):
    """A colour for each segment; 0, or the lowest, is nothing."""
    nothing = 0 if 0 in values else values.min(initial=0)
    colours = [(value, *_HUES[int(value) % len(_HUES)]) for value in values]
    steps = [(nothing - 0.5, 0.0)]
    for value in values:
        is_seen = 0.0 if value == nothing else 0.85
        steps += [(value - 0.49, is_seen), (value + 0.49, is_seen)]
    return Look("segments", tuple(colours), tuple(sorted(steps)), is_nearest=True)


def _level(values, low, high):
    """The value that parts two kinds of values best (Otsu's method); few high ones do not count."""
    if len(values) == 0 or high <= low:
        return low
    ceiling = np.quantile(values, 0.999)
    counts, edges = np.histogram(values, 256, (low, ceiling if ceiling > low else high))
    middles = (edges[:-1] + edges[1:]) / 2
    below, total = np.cumsum(counts), np.cumsum(counts * middles)
    above = below[-1] - below
    with np.errstate(all="ignore"):
        apart = below * above * (total / below - (total[-1] - total) / above) ** 2
    return float(edges[1 + np.nan_to_num(apart[:-1]).argmax()])
