"""Colors of the local change of volume: blue where material shrinks, orange where it grows.

The volume of material at v relative to its volume at rest is 1 / det J_G(v). The colors are those
of the determinant, which is continuous where space starts to fold, while the ratio has a pole.
"""

import numpy as np
from vtkmodules.vtkCommonCore import vtkLookupTable

FOLDED = (0.80, 0.02, 0.12)  # where the determinant is not positive
MAX_DOUBLINGS = 2.0  # of the volume, up or down, beyond which colors stay the same
# Doublings of the volume, and colors between which is interpolated.
_NODES = (
    (-2.0, (0.10, 0.27, 0.65)),
    (-1.0, (0.46, 0.68, 0.93)),
    (0.0, (0.96, 0.96, 0.96)),
    (1.0, (0.99, 0.77, 0.42)),
    (2.0, (0.93, 0.49, 0.00)),
)
_STEPS = 33  # of the table for VTK, which interpolates linearly in the determinant
_MIN_DETERMINANT = 1e-6  # determinant that is drawn as not folded
TABLE_SIZE, _TABLE_MARGIN = 1024, 0.125  # of tables of determinants, linear in these
_MIN_BRIGHTNESS = 0.35  # share of a color that is visible on black


def doublings(determinants):
    """How often material at rest doubles its volume: -log2(det J_G), NaN where space folds."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(determinants > 0, -np.log2(determinants), np.nan)


def colors_of(determinants):
    """Colors (n, 3), 0 to 1, of determinants (n,) of J_G; NaN is a fold."""
    change = doublings(np.asarray(determinants, float))
    nodes, colors = [node for node, _ in _NODES], np.array([color for _, color in _NODES])
    result = np.stack([np.interp(change, nodes, channel) for channel in colors.T], axis=-1)
    result[np.isnan(change)] = FOLDED
    return result


def tinted(colors, determinants):
    """Colors (n, 3), 0 to 255, of a picture that shows determinants (n,) by its hue.

    Colors stay where the volume does; elsewhere dark colors become lighter.
    """
    change = np.minimum(np.abs(doublings(determinants)), 1)
    lift = (_MIN_BRIGHTNESS * np.where(np.isnan(change), 1, change))[:, None]
    shade = lift + (1 - lift) * np.asarray(colors, float) / 255
    white = colors_of([1.0])
    return np.rint(255 * shade * np.minimum(colors_of(determinants) / white, 1)).astype(np.uint8)


def table():
    """(determinant, red, green, blue) in increasing order, for linear interpolation."""
    change = np.linspace(MAX_DOUBLINGS, -MAX_DOUBLINGS, _STEPS)
    determinants = np.concatenate([[-_TABLE_MARGIN, 0.0, _MIN_DETERMINANT], 2.0**-change])
    return np.column_stack([determinants, colors_of(determinants)])


def lookup_table():
    """A vtkLookupTable of determinants; beyond its range colors stay the same."""
    table = vtkLookupTable()
    table.SetTableRange(-_TABLE_MARGIN, 2**MAX_DOUBLINGS + _TABLE_MARGIN)
    table.SetNumberOfTableValues(TABLE_SIZE)
    for index, color in enumerate(colors_of(np.linspace(*table.GetTableRange(), TABLE_SIZE))):
        table.SetTableValue(index, *color)
    return table


def shader_function(name):
    """GLSL of a function `vec3 name(float volume)` with these colors."""
    lines = [f"vec3 {name}(float volume)", "{"]
    lines.append(f"  if (!(volume > 0.0)) return {_vec3(FOLDED)};")
    lines.append("  float change = -log2(volume);")
    lines.append(f"  vec3 color = {_vec3(_NODES[0][1])};")
    for (low, _), (high, color) in zip(_NODES, _NODES[1:]):
        share = f"clamp((change - {low}) / {high - low}, 0.0, 1.0)"
        lines.append(f"  color = mix(color, {_vec3(color)}, {share});")
    return "\n".join([*lines, "  return color;", "}", ""])


def _vec3(color):
    return f"vec3({', '.join(map(str, color))})"
