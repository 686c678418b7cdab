"""Arrays that the filters add, for the page of properties; a test runs the filters for them."""

import re
from collections import namedtuple

POINTS, CELLS, FIELD = "point", "cell", "field"  # attribute data of an array
# Writers.
IMAGE, MESH = "MLSDeform of an image", "MLSDeform of a mesh"
MAP = "MLSDisplacementField"
CONTROL_POINTS, ARROWS = "MLSControlPoints", "its output Arrows"
_WRITERS = {"image": IMAGE, "mesh": MESH, "map": MAP, "points": CONTROL_POINTS, "arrows": ARROWS}

# An array of an output: of points, cells or fields; some of the writers above; type and number of
# the values, with unit or frame; the condition, "" for always; and the meaning of the values.
Array = namedtuple("Array", "name of writers values when help")

# Name, attribute data, writers and values of each; its meaning; and its condition, if it has one.
_TEXT = """
BackwardDisplacement | point | map | 3 float32, world coordinates
  G(v) - v: from a point to the original position of its material.
  Unless Inverse
ForwardDisplacement | point | mesh map | 3 float32, world coordinates
  F(x) - x: the displacement of the material that was at a point.
  In MLSDisplacementField with Inverse
NoInverse | point | mesh map | 0 or 1
  1 if no position maps back to the point, which then lies at the nearest one found.
  In MLSDisplacementField with Inverse
FailedInverses | field | mesh map | 1 int64
  Number of points without an inverse.
  In MLSDisplacementField with Inverse
Void | point | image map | 0 or 1
  1 if there is no material: VoidDistance is negative.
  With cuts; in MLSDisplacementField unless Inverse
VoidDistance | point | image map | 1 float32, world units
  Distance from the void, negative inside it. Its zero level is the face of the cut.
  With cuts; in MLSDisplacementField unless Inverse
Void | cell | image | 0 or 1
  1 if the center of the cell is void.
  With cuts
Void | cell | mesh | 0 or 1
  1 if a cut has torn the cell.
  With cuts, unless SplitCells
vtkGhostType | point | image | flags of VTK
  Hides points that are void.
  With cuts and HideVoid
vtkGhostType | cell | image mesh | flags of VTK
  Hides cells that are void or torn; for images, from VTK 9.3 on.
  With cuts; in an image with HideVoid, in a mesh unless SplitCells
Overlap | point | image map | 0 or 1
  1 if material from both sides of a cut has reached the point.
  With GenerateOverlap
OverlappingPoints | field | image map | 1 int64
  Number of points that overlap.
  With GenerateOverlap
Gradient | point | image | 3 float32, per world unit
  Gradient of the deformed volume.
  With GradientArray
Jacobian | point | image mesh map | 9 float32
  Component 3 i + j is the derivative of G_j in the direction i.
  With GenerateJacobian
JacobianDeterminant | point | image mesh map | 1 float32
  det dG/dv: zero or negative where space is folded.
  With GenerateJacobianDeterminant
FoldedVoxels | field | image map | 1 int64
  Number of folded points that are not void.
  With GenerateJacobianDeterminant
Folded | point | image map | 0 or 1
  1 at corners of voxels that fold: the map at a corner or the center, or the linear field.
  With Steps 0; the linear field in MLSDisplacementField, unless Inverse
Folded | cell | mesh | 0 or 1
  1 if the deformation has inverted the cell.
  With Steps 0
StepsUsed | field | image mesh map | 1 int64
  Number of steps with which no fold was found; the field array `Path` is there if they follow one.
  With Steps 0
SmallestDeterminant | field | image mesh map | 1 float64
  The smallest determinant of the map around handles and in voxels that may fold.
  With Steps 0
InvertedCells | field | mesh | 1 int64
  Number of cells that the deformation has inverted.
  With GenerateJacobianDeterminant
UncheckedCells | field | mesh | 1 int64
  Number of cells without a result: lines, vertices, curved cells, cells without a size.
  With GenerateJacobianDeterminant
LargestBlend | field | mesh | 1 float64
  The largest Blend, in steps of 0.01, at which no cell is inverted.
  With GenerateLargestBlend
CellQuality | cell | mesh | 1 float64
  VTK's scaled Jacobian of the deformed cell: 0 or less if it is inverted.
  With GenerateCellQuality
CellQualityBefore | cell | mesh | 1 float64
  VTK's scaled Jacobian of the cell at rest.
  With GenerateCellQuality
Displacement | point | points | 3 float64, world coordinates
  q - p.
Displacement | point | arrows | 3 float32, world coordinates
  q - p of the arrow's control point.
Weight | point | points | 1 float64
  The weight factor.
  With Weights
Label | point | points | text
  The label.
  With a file that has them
Space | field | points arrows | text
  Frame of the positions: LPS.
  With a file
"""


def _table(text):
    for block in re.split(r"\n(?=\S)", text.strip()):
        head, meaning, when = [*map(str.strip, block.splitlines()), ""][:3]
        name, of, writers, values = head.split(" | ")
        found = tuple(_WRITERS[writer] for writer in writers.split())
        yield Array(name, of, found, values, when, meaning)


TABLE = tuple(_table(_TEXT))
