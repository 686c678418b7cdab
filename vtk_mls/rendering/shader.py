"""VTK's GPU ray caster, redirected: each sample is fetched where its material came from.

`t` are texture coordinates of the box that rays go through, as in VTK's own shader; `p` are those
of the volume. The map is a texture of one layer or several, one behind the other along z: with
cuts, each is the map of one side of them, continued behind its face. `rgb` is G(v) - v in the
coordinates of the data, `a` the void distance.
"""

# VTK declares what a program sets by name, but takes a sampler for an integer.
_UNIFORMS = """
uniform sampler3D mls_map;
#define mls_map mls_map_unit
{tag}
#undef mls_map
"""

_FUNCTIONS = """{tag}
float mls_distance_before = 0.0;  // of the sample before, from the void
bool mls_has_before = false;
bool mls_is_empty = true;   // the ray, so far
vec3 mls_p = vec3(0.0);     // of the sample

// Of the material that is there: of all sides the one that is farthest from its face.
vec4 mlsMap(vec3 t)
{{
  vec3 m = t * mls_map_scale + mls_map_bias;
  m.z = clamp(m.z, mls_map_low, 1.0 / mls_layers - mls_map_low);
  vec4 here = texture(mls_map, m);
  for (float layer = 1.0; layer < mls_layers; layer += 1.0)
  {{
    m.z += 1.0 / mls_layers;
    vec4 other = texture(mls_map, m);
    if (other.a > here.a) here = other;
  }}
  return here;
}}

vec3 mlsOrigin(vec3 t, vec3 d)
{{
  return t * mls_origin_scale + mls_origin_bias +
    vec3(dot(mls_to_x, d), dot(mls_to_y, d), dot(mls_to_z, d));
}}

bool mlsIsOutside(vec3 p)
{{
  return any(lessThan(p, vec3(0.0))) || any(greaterThan(p, vec3(1.0)));
}}

// For gradients: outside and in voids the lowest value of the volume's range, with a ramp of two
// voxels across the faces of voids; beyond the box what is at its end.
vec4 mlsFetchForGradient(sampler3D volume, vec3 t)
{{
  t = clamp(t, mls_end, 1.0 - mls_end);
  vec4 here = mlsMap(t), nothing = -in_volume_bias[0] / in_volume_scale[0];
  vec3 p = mlsOrigin(t, here.xyz);
  float there = clamp(0.5 + 0.5 * here.a / mls_voxel, 0.0, 1.0);
  if (mlsIsOutside(p) || there == 0.0) return nothing;
  return mix(nothing, texture(volume, p), there);
}}
#undef texture3D
#define texture3D mlsFetchForGradient
"""

# central differences with steps of one voxel of the volume, not of the box
_STEPS = """
#define in_cellStep vec3[1](mls_step)
#define in_cellSpacing vec3[1](mls_spacing)
{tag}
"""

_BEFORE_RAYS = """
#undef texture3D
#define texture3D(volume, t) texture(volume, mlsOrigin(t, mlsMap(t).xyz))
{tag}
"""

_BEFORE_SAMPLES = """
  mls_has_before = false;
{tag}
"""

# A ray that leaves a void steps back to its face, as at a clipping plane.
_SAMPLE = """
    vec4 mls_here = mlsMap(g_dataPos);
    if (mls_has_before && mls_distance_before < 0.0 && mls_here.a >= 0.0)
    {{
      g_dataPos -= g_dirStep * (mls_here.a / (mls_here.a - mls_distance_before));
      mls_here.xyz = mlsMap(g_dataPos).xyz;
    }}
    mls_distance_before = mls_here.a;
    mls_has_before = true;
    mls_p = mlsOrigin(g_dataPos, mls_here.xyz);
    if (mls_here.a < 0.0 || mlsIsOutside(mls_p)) g_skip = true;
    if (!g_skip) mls_is_empty = false;
#undef texture3D
#define texture3D(volume, t) texture(volume, mls_p)
{tag}
"""

# projections make something of no sample, too
_AFTER_SAMPLES = """{tag}
  if (mls_is_empty) g_fragColor = vec4(0.0);
"""

_REPLACEMENTS = {
    "//VTK::CustomUniforms::Dec": _UNIFORMS,
    "//VTK::Base::Dec": _FUNCTIONS,
    "//VTK::ComputeGradient::Dec": _STEPS,
    "//VTK::Picking::Dec": _BEFORE_RAYS,
    "//VTK::Shading::Init": _BEFORE_SAMPLES,
    "//VTK::Cropping::Impl": _SAMPLE,
    "//VTK::Shading::Exit": _AFTER_SAMPLES,
}
_NAMES = [
    *("mls_map", "mls_layers", "mls_map_low", "mls_end", "mls_voxel", "mls_step", "mls_spacing"),
    *("mls_map_scale", "mls_map_bias", "mls_origin_scale", "mls_origin_bias"),
    *("mls_to_x", "mls_to_y", "mls_to_z"),
]


def install(shader):
    """Redirect a vtkShaderProperty."""
    for tag, text in _REPLACEMENTS.items():
        shader.AddFragmentShaderReplacement(tag, True, text.format(tag=tag), False)


def remove(shader):
    """Take back what `install` and `set_values` did."""
    for tag in _REPLACEMENTS:
        shader.ClearFragmentShaderReplacement(tag, True)
    for name in _NAMES:
        shader.GetFragmentCustomUniforms().RemoveUniform(name)


def set_values(shader, values):
    """Set uniforms by name: int for a texture unit, float or three floats."""
    uniforms = shader.GetFragmentCustomUniforms()
    for name, value in values.items():
        if isinstance(value, int):
            uniforms.SetUniformi(name, value)
        elif isinstance(value, float):
            uniforms.SetUniformf(name, value)
        else:
            uniforms.SetUniform3f(name, [float(each) for each in value])
