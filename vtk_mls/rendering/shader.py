"""Shader code and map texture for VTK's GPU ray caster: samples are read at their origins.

`t` are texture coordinates of the box that rays traverse, as in VTK's own shader; `p` are those of
the volume. The map is a texture of one or several layers along z: with cuts, each layer is the map
of one side of the cuts, continued behind its face. `rgb` is G(v) - v in the coordinates of the
data, `a` the void distance.
"""

from vtkmodules.vtkCommonCore import VTK_FLOAT, vtkOutputWindow, vtkStringOutputWindow
from vtkmodules.vtkRenderingOpenGL2 import vtkTextureObject

# VTK declares uniforms that are set by name, but declares a sampler as an integer.
_UNIFORMS = """
uniform sampler3D mls_map;
#define mls_map mls_map_unit
{tag}
#undef mls_map
"""

_FUNCTIONS = """{tag}
float mls_distance_before = 0.0;  // void distance of the previous sample
bool mls_has_before = false;
bool mls_is_empty = true;  // no material on the ray so far
vec3 mls_p = vec3(0.0);    // origin of the sample

// Texture coordinates of the first layer of the map.
vec3 mlsMapCoordinates(vec3 t)
{{
  vec3 m = t * mls_map_scale + mls_map_bias;
  return vec3(m.xy, clamp(m.z, mls_map_low, 1.0 / mls_layers - mls_map_low));
}}

// The map of the side whose void distance is largest.
vec4 mlsMap(vec3 t)
{{
  vec3 m = mlsMapCoordinates(t);
  vec4 value = texture(mls_map, m);
  for (float layer = 1.0; layer < mls_layers; layer += 1.0)
  {{
    m.z += 1.0 / mls_layers;
    vec4 other = texture(mls_map, m);
    if (other.a > value.a) value = other;
  }}
  return value;
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

// For gradients: the lowest value of the volume's range outside and in voids, with a ramp of two
// voxels across the faces of voids; beyond the box the value at its end.
vec4 mlsFetchForGradient(sampler3D volume, vec3 t)
{{
  t = clamp(t, mls_end, 1.0 - mls_end);
  vec4 value = mlsMap(t), nothing = -in_volume_bias[0] / in_volume_scale[0];
  vec3 p = mlsOrigin(t, value.xyz);
  float share = clamp(0.5 + 0.5 * value.a / mls_voxel, 0.0, 1.0);
  if (mlsIsOutside(p) || share == 0.0) return nothing;
  return mix(nothing, texture(volume, p), share);
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
    vec4 mls_value = mlsMap(g_dataPos);
    if (mls_has_before && mls_distance_before < 0.0 && mls_value.a >= 0.0)
    {{
      g_dataPos -= g_dirStep * (mls_value.a / (mls_value.a - mls_distance_before));
      mls_value.xyz = mlsMap(g_dataPos).xyz;
    }}
    mls_distance_before = mls_value.a;
    mls_has_before = true;
    mls_p = mlsOrigin(g_dataPos, mls_value.xyz);
    if (mls_value.a < 0.0 || mlsIsOutside(mls_p)) g_skip = true;
    if (!g_skip) mls_is_empty = false;
#undef texture3D
#define texture3D(volume, t) texture(volume, mls_p)
{tag}
"""

# projections would show a value without samples
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
_PREFIX = "mls_"  # of the names of uniforms


class RenderingError(RuntimeError):
    """The graphics driver or VTK cannot draw the deformation."""


def install(shader):
    """Add the shader code to a vtkShaderProperty."""
    for tag, text in _REPLACEMENTS.items():
        shader.AddFragmentShaderReplacement(tag, True, text.format(tag=tag), False)


def remove(shader):
    """Undo `install`, and remove the uniforms of this package."""
    for tag in _REPLACEMENTS:
        shader.ClearFragmentShaderReplacement(tag, True)
    uniforms = shader.GetFragmentCustomUniforms()
    for name in [uniforms.GetNthUniformName(i) for i in range(uniforms.GetNumberOfUniforms())]:
        if name.startswith(_PREFIX):
            uniforms.RemoveUniform(name)


def set_values(shader, values):
    """Set uniforms by name: int for a texture unit, float or three floats."""
    uniforms = shader.GetFragmentCustomUniforms()
    for name, value in values.items():
        if isinstance(value, int):
            uniforms.SetUniformi(name, value)
        elif isinstance(value, float):
            uniforms.SetUniformf(name, value)
        else:
            uniforms.SetUniform3f(name, [float(component) for component in value])


class MapTexture:
    """The displacement map on the graphics card: a 3-D texture of four floats per point."""

    def __init__(self):
        self.uploads = 0
        self._texture, self._values, self._is_new = vtkTextureObject(), None, False

    def set(self, values):
        """Use the values, (nz, ny, nx, 4) float32 contiguous, from the next picture on."""
        self._values, self._is_new = values, True

    def bind(self, window):
        """Upload new values for a vtkRenderWindow; the texture unit for its shaders."""
        if self._texture.GetContext() is not window:
            self.free()
        texture = self._texture
        if texture.GetContext() is None:
            texture.SetContext(window)
            texture.SetMinificationFilter(vtkTextureObject.Linear)
            texture.SetMagnificationFilter(vtkTextureObject.Linear)
            for axis in "STR":
                getattr(texture, f"SetWrap{axis}")(vtkTextureObject.ClampToEdge)
        if self._is_new or not texture.GetHandle():
            nz, ny, nx, _ = self._values.shape
            if not texture.Create3DFromRaw(nx, ny, nz, 4, VTK_FLOAT, self._values):
                raise RenderingError(
                    f"the graphics driver has no 3-D texture of {nx} x {ny} x {nz} points with "
                    "four floats; draw the resampled volume instead"
                )
            self._is_new = False
            self.uploads += 1
        texture.Activate()
        return texture.GetTextureUnit()

    def release(self):
        """Free the texture unit after a picture."""
        if self._texture.GetContext() is not None:
            self._texture.Deactivate()

    def free(self):
        """Free the memory on the graphics card."""
        window = self._texture.GetContext()
        if window is not None:
            self._texture.ReleaseGraphicsResources(window)
            self._texture = vtkTextureObject()


class CapturedMessages:
    """Captures VTK's messages until `finish`, to find errors of the shader.

    Several may capture at the same time and finish in any order; each gets all messages.
    """

    _open_count = 0
    _usual = _capturing = None  # output windows
    _is_reported = False

    def __init__(self):
        if CapturedMessages._open_count == 0:
            CapturedMessages._usual = vtkOutputWindow.GetInstance()
            CapturedMessages._is_reported = False
            CapturedMessages._capturing = vtkStringOutputWindow()
            vtkOutputWindow.SetInstance(CapturedMessages._capturing)
        CapturedMessages._open_count += 1

    def finish(self, word):
        """Whether the messages contain a word; the caller then reports the error itself.

        If no caller does, the messages are passed on when the last capture finishes.
        """
        messages = CapturedMessages._capturing.GetOutput()
        has_word = word in messages
        CapturedMessages._is_reported |= has_word
        CapturedMessages._open_count -= 1
        if CapturedMessages._open_count == 0:
            usual = CapturedMessages._usual
            CapturedMessages._usual = CapturedMessages._capturing = None
            vtkOutputWindow.SetInstance(usual)
            if messages and not CapturedMessages._is_reported:
                usual.DisplayText(messages)
        return has_word


def report_error(sentence):
    """Report an error through VTK's output window, also while messages are captured."""
    window = CapturedMessages._usual or vtkOutputWindow.GetInstance()
    window.DisplayErrorText(sentence + "\n")
