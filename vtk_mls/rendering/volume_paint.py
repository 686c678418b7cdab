"""Shader code that paints the deformed grid and the change of volume on a deformed volume.

It uses the functions and uniforms of `shader`. A sample is painted before it is lit.
"""

import numpy as np

from vtk_mls.rendering import volume_colors
from vtk_mls.rendering.rest_lines import LINE_COLOR

_TAG = "//VTK::ComputeColor::Dec"
_LINE_WIDTH = 0.035  # of a step of the grid

_FUNCTIONS = """
{volume_color}
// The map of one side.
vec3 mlsDisplacement(vec3 t, float layer)
{{
  vec3 m = mlsMapCoordinates(t);
  m.z += layer / mls_layers;
  return texture(mls_map, m).xyz;
}}

// The side of a point: the layer with the largest void distance.
float mlsLayer(vec3 t)
{{
  if (mls_layers == 1.0) return 0.0;
  vec3 m = mlsMapCoordinates(t);
  float found = 0.0, largest = texture(mls_map, m).a;
  for (float layer = 1.0; layer < mls_layers; layer += 1.0)
  {{
    m.z += 1.0 / mls_layers;
    float distance = texture(mls_map, m).a;
    if (distance > largest) {{ found = layer; largest = distance; }}
  }}
  return found;
}}

// Derivatives of G along the axes of the box, as columns: differences between nodes of the map.
mat3 mlsSlope(vec3 t)
{{
  float layer = mlsLayer(t);
  mat3 slope = mat3(mls_axis_x, mls_axis_y, mls_axis_z);
  for (int axis = 0; axis < 3; ++axis)
  {{
    vec3 low = t, high = t;
    low[axis] = max(t[axis] - mls_node[axis], mls_end[axis]);
    high[axis] = min(t[axis] + mls_node[axis], 1.0 - mls_end[axis]);
    float count = max((high[axis] - low[axis]) / mls_node[axis], 1e-3);  // of nodes
    vec3 change = mlsDisplacement(high, layer) - mlsDisplacement(low, layer);
    slope[axis] += change / (count * mls_node_size[axis]);
  }}
  return slope;
}}

vec4 mlsPainted(vec4 color)
{{
  mat3 slope = mlsSlope(g_dataPos);
  if (mls_paints_volume > 0.5)
  {{
    float volume =
      determinant(slope) / determinant(mat3(mls_axis_x, mls_axis_y, mls_axis_z));
    float change = volume > 0.0 ? min(abs(log2(volume)), 1.0) : 1.0;
    color.rgb = mix(color.rgb, mlsVolumeColor(volume), change);
  }}
  if (mls_line_width > 0.0)
  {{
    vec3 c = vec3(dot(mls_line_x, mls_p), dot(mls_line_y, mls_p), dot(mls_line_z, mls_p));
    c += mls_line_bias;
    // distances along the surface: across it, a plane of the grid would be a blot
    vec3 normal = computeGradient(g_dataPos, 0, in_volume[0], 0).xyz;
    normal /= max(length(normal), 1e-30);
    float nearest = 1e30;
    for (int i = 0; i < 3; ++i)
    {{
      vec3 rise = vec3(slope[0][i], slope[1][i], slope[2][i]) / mls_line_step;
      rise -= dot(rise, normal) * normal;
      nearest = min(nearest, abs(fract(c[i] - 0.5) - 0.5) / max(length(rise), 1e-30));
    }}
    float half_width = 0.5 * mls_line_width;
    float share = 1.0 - smoothstep(half_width, half_width + 0.5 * mls_voxel, nearest);
    color.rgb = mix(color.rgb, {line_color}, share);
  }}
  return color;
}}
#define computeLighting(color, part, label) computeLighting(mlsPainted(color), part, label)
{tag}
"""


def install(shader):
    """Add the shader code to a vtkShaderProperty, after that of `shader`."""
    color = volume_colors.shader_function("mlsVolumeColor")
    text = _FUNCTIONS.format(volume_color=color, line_color=LINE_COLOR, tag=_TAG)
    shader.AddFragmentShaderReplacement(_TAG, True, text, False)


def remove(shader):
    """Undo `install`; uniforms stay."""
    shader.ClearFragmentShaderReplacement(_TAG, True)


def values_of(box, nodes, lines, has_colors):
    """Uniforms by their names, for a `MapBox`, the `nodes` of its map, and `RestLines` or None.

    `has_colors`: the change of volume is painted.
    """
    values, points = box.values, np.array(box.image.grid.dimensions, float)
    margin = 0 if box.is_cell_data else 1 / points
    axes = values.direction * np.sign(values.spacing)
    step, origin = (1.0, np.zeros(3)) if lines is None else (lines.step, lines.origin)
    matrix = values.index_to_world * values.dimensions / step
    return {
        "mls_node": (1 - margin) / (np.array(nodes.dimensions) - 1),
        "mls_node_size": np.abs(nodes.spacing),
        **{f"mls_axis_{name}": axis for name, axis in zip("xyz", axes.T)},
        "mls_paints_volume": float(has_colors),
        "mls_line_width": 0.0 if lines is None else _LINE_WIDTH * step,
        "mls_line_step": step,
        **{f"mls_line_{name}": row for name, row in zip("xyz", matrix)},
        "mls_line_bias": (values.at([[-0.5] * 3])[0] - origin) / step,
    }
