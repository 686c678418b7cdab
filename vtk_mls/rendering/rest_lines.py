"""Lines of a regular grid of the undeformed space, as the deformation carries them.

On a mesh shader code draws them, from the array "RestPosition".
"""

from dataclasses import dataclass

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE
from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkImageData
from vtkmodules.vtkFiltersCore import vtkFlyingEdges2D

from vtk_mls.base.grid import Grid
from vtk_mls.base.interpolation import sample
from vtk_mls.rendering.rest_surface import REST_POSITION
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured, output_of

_ROUNDING = 1e-3  # of a step, by which lines may leave the grid


@dataclass(frozen=True, eq=False)
class RestLines:
    """A grid of cubes in the undeformed space, along the axes of the world."""

    origin: np.ndarray  # (3,) float64, world coordinates
    step: float  # world units
    counts: np.ndarray  # (3,) ints: cubes along each axis

    @classmethod
    def over(cls, bounds, count):
        """The grid around a box (2, 3), with `count` cubes along its longest side."""
        size, middle = np.ptp(bounds, axis=0), np.mean(bounds, axis=0)
        step = float(size.max() / count) or 1.0
        counts = np.maximum(np.ceil(size / step - _ROUNDING).astype(int), 1)
        return cls(middle - step * counts / 2, step, counts)

    def coordinates(self, points):
        """Coordinates (n, 3) of points (n, 3): a line passes where two of them are integers."""
        return (points - self.origin) / self.step

    def covers(self, coordinates):
        """Whether coordinates (n, 3) are inside: (n,) bool."""
        inside = (coordinates >= -_ROUNDING) & (coordinates <= self.counts + _ROUNDING)
        return inside.all(axis=1)

    def in_slice(self, axis, grid, origins, has_material):
        """Where the lines are in a slice across an axis: ends (m, 2, 3) of short segments.

        The samples of the slice are on a Grid along the axes of the world, with one sample along
        `axis`; lines along it are not drawn. `origins` (n, 3) are G(v) of the samples v, and
        `has_material` (n,) is false in voids.
        """
        across = [other for other in range(3) if other != axis]
        shape = [grid.dimensions[other] for other in across]
        coordinates = self.coordinates(origins).reshape(*shape[::-1], 3)
        usable = np.asarray(has_material).reshape(shape[::-1])
        segments = []
        for other in across:
            ends = _level_segments(coordinates[..., other], np.arange(self.counts[other] + 1))
            low = np.floor(ends).astype(int)
            high = np.minimum(low + 1, np.array(shape) - 1)
            inside = np.ones(len(ends), bool)
            for i, j in ((low, low), (low, high), (high, low), (high, high)):
                inside &= usable[j[..., 1], i[..., 0]].all(axis=1)
            index = np.insert(ends.reshape(-1, 2), 2, 0, axis=1)
            at_ends = sample(coordinates[None], index, "linear", 0, Grid((*shape, 1)))
            inside &= self.covers(at_ends).reshape(-1, 2).all(axis=1)
            segments.append(ends[inside])
        index = np.zeros((sum(map(len, segments)), 2, 3))
        index[..., across] = np.concatenate(segments)
        return grid.at(index.reshape(-1, 3)).reshape(-1, 2, 3)


def _level_segments(values, levels):
    """Segments (m, 2, 2) of the lines at which values (nj, ni) have some levels, as indices."""
    image = configured(vtkImageData(), Dimensions=(*values.shape[::-1], 1))
    image.GetPointData().SetScalars(arrays.from_numpy(values.ravel(), VTK_DOUBLE))
    lines = configured(vtkFlyingEdges2D(), NumberOfContours=len(levels), InputData=image)
    for index, level in enumerate(levels.tolist()):
        lines.SetValue(index, level)
    output = output_of(lines)
    if output.GetNumberOfLines() == 0:
        return np.zeros((0, 2, 2))
    points = arrays.to_numpy(output.GetPoints().GetData())[:, :2].astype(float)
    ends = points[arrays.to_numpy(output.GetLines().GetConnectivityArray()).reshape(-1, 2)]
    return ends[np.isfinite(ends).all(axis=(1, 2))]


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
