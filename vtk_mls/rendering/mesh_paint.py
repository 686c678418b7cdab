"""Shader code that draws the deformed grid on a mesh, from the array "RestPosition"."""

from vtkmodules.vtkCommonDataModel import vtkDataObject

from vtk_mls.rendering.rest_surface import REST_POSITION

LINE_COLOR = "vec3(0.04, 0.20, 0.22)"
_ATTRIBUTE = "mlsRest"
_LINE_PIXELS = 1.6
# By the kind of shader and the tag; the text comes before the tag.
_TEXTS = {
    ("Vertex", "//VTK::PositionVC::Dec"): "in vec3 mlsRest;\nout vec3 mlsRestVSOutput;\n",
    ("Vertex", "//VTK::PositionVC::Impl"): "  mlsRestVSOutput = mlsRest;\n",
    ("Fragment", "//VTK::Light::Dec"): "in vec3 mlsRestVSOutput;\n",
    # a face along a plane of the grid has no line of that plane
    ("Fragment", "//VTK::Light::Impl"): f"""
  vec3 mls_c = (mlsRestVSOutput - mls_line_origin) / mls_line_step;
  vec3 mls_width = fwidth(mls_c);
  vec3 mls_pixels = abs(fract(mls_c - 0.5) - 0.5) / max(mls_width, 1e-30);
  float mls_nearest = 1e30;
  for (int i = 0; i < 3; ++i)
    if (mls_width[i] > 1e-4) mls_nearest = min(mls_nearest, mls_pixels[i]);
  float mls_share = 1.0 - smoothstep({_LINE_PIXELS / 2}, {_LINE_PIXELS / 2 + 1}, mls_nearest);
  ambientColor = mix(ambientColor, {LINE_COLOR}, mls_share);
  diffuseColor = mix(diffuseColor, {LINE_COLOR}, mls_share);
""",
}


def show(actor, mapper, lines):
    """Draw a `RestLines` on an actor, or none for None.

    The input of its vtkPolyDataMapper has the array "RestPosition".
    """
    shader = actor.GetShaderProperty()
    for kind, tag in _TEXTS:
        getattr(shader, f"Clear{kind}ShaderReplacement")(tag, True)
    mapper.RemoveVertexAttributeMapping(_ATTRIBUTE)
    if lines is None:
        return
    points = vtkDataObject.FIELD_ASSOCIATION_POINTS
    mapper.MapDataArrayToVertexAttribute(_ATTRIBUTE, REST_POSITION, points, -1)
    for (kind, tag), text in _TEXTS.items():
        getattr(shader, f"Add{kind}ShaderReplacement")(tag, True, text + tag, False)
    uniforms = shader.GetFragmentCustomUniforms()
    uniforms.SetUniform3f("mls_line_origin", lines.origin.tolist())
    uniforms.SetUniformf("mls_line_step", lines.step)
