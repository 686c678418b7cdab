"""Arrays that the filters add, for the page of properties.

This module does not need VTK.
"""

from __future__ import annotations

from dataclasses import dataclass

POINTS, CELLS, FIELD = "point", "cell", "field"  # attribute data of an array
# Writers.
IMAGE, MESH = "MLSDeform of an image", "MLSDeform of a mesh"
MAP = "MLSDisplacementField"
CONTROL_POINTS, ARROWS = "MLSControlPoints", "its output Arrows"


@dataclass(frozen=True)
class Array:
    """An array of an output."""

    name: str
    of: str  # POINTS, CELLS or FIELD
    writers: tuple[str, ...]  # some of the constants above
    values: str  # type and number of the values, with unit or frame
    help: str  # meaning of the values
    when: str = ""  # condition; "" for always


_CUTS = "With cuts"
_WORLD = "3 float32, world coordinates"
_COUNT = "1 int64"
WITH_CELL_QUALITY = "With GenerateCellQuality"
TABLE = (
    Array(
        "BackwardDisplacement",
        POINTS,
        (MAP,),
        _WORLD,
        "G(v) - v: from a point to the original position of its material.",
        "Unless Inverse",
    ),
    Array(
        "ForwardDisplacement",
        POINTS,
        (MESH, MAP),
        _WORLD,
        "F(x) - x: the displacement of the material that was at a point.",
        "In MLSDisplacementField with Inverse",
    ),
    Array(
        "NoInverse",
        POINTS,
        (MESH, MAP),
        "0 or 1",
        "1 if no position maps back to the point, which then lies at the nearest one found.",
        "In MLSDisplacementField with Inverse",
    ),
    Array(
        "FailedInverses",
        FIELD,
        (MESH, MAP),
        _COUNT,
        "Number of points without an inverse.",
        "In MLSDisplacementField with Inverse",
    ),
    Array(
        "Void",
        POINTS,
        (IMAGE, MAP),
        "0 or 1",
        "1 if there is no material: VoidDistance is negative.",
        f"{_CUTS}; in MLSDisplacementField unless Inverse",
    ),
    Array(
        "VoidDistance",
        POINTS,
        (IMAGE, MAP),
        "1 float32, world units",
        "Distance from the void, negative inside it. Its zero level is the face of the cut.",
        f"{_CUTS}; in MLSDisplacementField unless Inverse",
    ),
    Array("Void", CELLS, (IMAGE,), "0 or 1", "1 if the center of the cell is void.", _CUTS),
    Array(
        "Void",
        CELLS,
        (MESH,),
        "0 or 1",
        "1 if a cut has torn the cell.",
        f"{_CUTS}, unless SplitCells",
    ),
    Array(
        "vtkGhostType",
        POINTS,
        (IMAGE,),
        "flags of VTK",
        "Hides points that are void.",
        f"{_CUTS} and HideVoid",
    ),
    Array(
        "vtkGhostType",
        CELLS,
        (IMAGE, MESH),
        "flags of VTK",
        "Hides cells that are void or torn; for images, from VTK 9.3 on.",
        f"{_CUTS}; in an image with HideVoid, in a mesh unless SplitCells",
    ),
    Array(
        "Overlap",
        POINTS,
        (IMAGE, MAP),
        "0 or 1",
        "1 if material from both sides of a cut has reached the point.",
        "With GenerateOverlap",
    ),
    Array(
        "OverlappingPoints",
        FIELD,
        (IMAGE, MAP),
        _COUNT,
        "Number of points that overlap.",
        "With GenerateOverlap",
    ),
    Array(
        "Gradient",
        POINTS,
        (IMAGE,),
        "3 float32, per world unit",
        "Gradient of the deformed volume.",
        "With GradientArray",
    ),
    Array(
        "Jacobian",
        POINTS,
        (IMAGE, MESH, MAP),
        "9 float32",
        "Component 3 i + j is the derivative of G_j in the direction i.",
        "With GenerateJacobian",
    ),
    Array(
        "JacobianDeterminant",
        POINTS,
        (IMAGE, MESH, MAP),
        "1 float32",
        "det dG/dv: zero or negative where space is folded.",
        "With GenerateJacobianDeterminant",
    ),
    Array(
        "FoldedVoxels",
        FIELD,
        (IMAGE, MAP),
        _COUNT,
        "Number of folded points that are not void.",
        "With GenerateJacobianDeterminant",
    ),
    Array(
        "StepsUsed",
        FIELD,
        (IMAGE, MESH, MAP),
        _COUNT,
        "Number of steps with which no fold was found at sampled points.",
        "With Steps 0",
    ),
    Array(
        "SmallestDeterminant",
        FIELD,
        (IMAGE, MESH, MAP),
        "1 float64",
        "The smallest determinant of the Jacobian of a step, of sampled points near the handles.",
        "With Steps 0",
    ),
    Array(
        "InvertedCells",
        FIELD,
        (MESH,),
        _COUNT,
        "Number of cells that the deformation has inverted.",
        "With GenerateJacobianDeterminant",
    ),
    Array(
        "UncheckedCells",
        FIELD,
        (MESH,),
        _COUNT,
        "Number of cells without a result: lines, vertices, curved cells, cells without a size.",
        "With GenerateJacobianDeterminant",
    ),
    Array(
        "LargestBlend",
        FIELD,
        (MESH,),
        "1 float64",
        "The largest Blend, in steps of 0.01, at which no cell is inverted.",
        "With GenerateLargestBlend",
    ),
    Array(
        "CellQuality",
        CELLS,
        (MESH,),
        "1 float64",
        "VTK's scaled Jacobian of the deformed cell: 0 or less if it is inverted.",
        WITH_CELL_QUALITY,
    ),
    Array(
        "CellQualityBefore",
        CELLS,
        (MESH,),
        "1 float64",
        "VTK's scaled Jacobian of the cell at rest.",
        WITH_CELL_QUALITY,
    ),
    Array("Displacement", POINTS, (CONTROL_POINTS,), "3 float64, world coordinates", "q - p."),
    Array("Displacement", POINTS, (ARROWS,), _WORLD, "q - p of the arrow's control point."),
    Array("Weight", POINTS, (CONTROL_POINTS,), "1 float64", "The weight factor.", "With Weights"),
    Array("Label", POINTS, (CONTROL_POINTS,), "text", "The label.", "With a file that has them"),
    Array(
        "Space",
        FIELD,
        (CONTROL_POINTS, ARROWS),
        "text",
        "Frame of the positions: LPS.",
        "With a file",
    ),
)
