"""The properties of the filters: one table for each, in the order of ParaView's panels."""

from __future__ import annotations

import re

from vtk_mls import INTERPOLATIONS, VOID_VALUES, Sampling
from vtk_mls.filters.properties import (
    ArrayName,
    ArrayNames,
    Choice,
    Dimensions,
    Factors,
    FileName,
    Flag,
    Number,
    Planes,
    Positions,
    Slider,
    Text,
    TransformFile,
    Value,
    Values,
    Vector,
)
from vtk_mls.handles.handle_cells import HANDLE_SHAPES
from vtk_mls.model import options


def _of_option(option, is_interactive=False):
    """The property of an option; `is_interactive` takes the default of ParaView and the editor."""
    default = option.interactive_default if is_interactive else option.default
    keywords = {"more": option.more, "is_advanced": option.section != "map"}
    if option.section == "cut":
        keywords |= {"hidden_when": ("CutType", "none"), "shown_with": "Cuts"}
    if option.needs:
        name, value = option.needs
        keywords["shown_when"] = (re.sub(r"(?:^|_)(\w)", lambda m: m[1].upper(), name), value)
    about = option.property_name, "" if default is None else default, option.help
    if option.slider:
        low, high, _ = option.slider
        return Slider(*about, low=low, high=high, **keywords)
    if option.choices and isinstance(option.default, int):
        low, high = min(option.choices), max(option.choices)
        return Slider(*about, low=low, high=high, **keywords)
    if option.choices:
        return Choice(*about, choices=option.choices, **keywords)
    if option.default is None:
        return Text(*about, **keywords)
    return Number(*about, spellings=option.spellings, **keywords)


def _of_section(section, is_interactive=False):
    """Properties of the options in a section of panels."""
    return tuple(_of_option(o, is_interactive) for o in options.OPTIONS if o.section == section)


MAP = _of_section("map")
CUT_OPTIONS = _of_section("cut")

# A cut by properties.
CUT_TYPE = Choice(
    "CutType",
    "none",
    """A cut through the volume beside those of the input Cuts: a plane divides everything; a
    half-plane has an edge through its origin, and begins there.""",
    choices=("none", "plane", "half-plane"),
)
_HAS_CUT = {"hidden_when": ("CutType", "none"), "unit": "world coordinates"}
CUT_ORIGIN = Vector(
    "CutOrigin",
    (0.0, 0.0, 0.0),
    """A point of the plane, or of the edge of the half-plane. While CutFrame is rest, the cut in
    the view stays at the undeformed volume, where it was laid, and the material takes the cut
    itself along.""",
    **_HAS_CUT,
)
CUT_NORMAL = Vector(
    "CutNormal",
    (1.0, 0.0, 0.0),
    "Normal of the plane or half-plane.",
    more="Its length does not count.",
    **_HAS_CUT,
)
CUT_INWARD = Vector(
    "CutInward",
    (0.0, 0.0, 1.0),
    """Direction in which the half-plane extends from its edge, which goes through the origin at a
    right angle to it and to the normal; the view shows all of the plane.""",
    more="Its part along the normal does not count.",
    unit="world coordinates",
    shown_when=("CutType", "half-plane"),
)

# All cuts.
CUTS = Values(
    "Cuts",
    (),
    "Cuts beside those of CutType and of input port 2.",
    kinds="a `vtk_mls.Plane`, `HalfPlane` or `Surface`",
)

# Control points of a filter's own.
OWN_CONTROL_POINTS = (
    Positions(
        "DeformedPoints",
        (),
        """Positions q to which the handles are dragged, with the mouse in the view or here.
        Those that are not dragged hold the material where it is.""",
        more="Without any, q = p. Unused where input port 1 is connected.",
        unit="world coordinates",
    ),
    Positions(
        "RestPoints",
        (),
        """Positions p of the handles in the undeformed space, one for each of those dragged;
        to begin with a lattice over the bounds of the input.""",
        more="""That lattice is ParaView's: without it there are none, and nothing moves. Those that
        rest on the cut of CutType belong to neither of its sides and do not count: they would hold
        it shut. Unused where input port 1 is connected.""",
        unit="world coordinates",
    ),
    Factors(
        "Weights",
        (),
        "A positive factor for each handle; empty: all count alike.",
        is_advanced=True,
        shown_when=("ControlPoints", None),
    ),
)

# Handles beside points.
HANDLE_SHAPES_CHOICE = Choice(
    "HandleShapes",
    "points",
    """What the input ControlPoints is: points, each a handle; or cells: vertices, and points
    without a cell, are points, lines are curves, and closed surfaces are rigid regions.""",
    more="""Curves are carried along their whole length. Each connected surface moves by the
    rotation and translation that its points have in common; cells with a volume count by their
    outer faces. Weights and paths are those of points.""",
    choices=HANDLE_SHAPES,
    hidden_when=("ControlPoints", None),
)
HANDLES = Values(
    "Handles",
    (),
    "Handles beside those of input port 1, or of RestPoints.",
    kinds="a `vtk_mls.CurveHandle` or `RegionHandle`",
)
HANDLE_OPTIONS = (HANDLE_SHAPES_CHOICE, HANDLES)

# Where the deformation acts.
_LIMIT = {"is_advanced": True, "unit": "world coordinates"}
MASK_BALL = Vector(
    "MaskBall",
    (0.0, 0.0, 0.0, 0.0, 0.0),
    """Ball in the deformed space in which the deformation acts: center, radius, and the distance
    over which it fades to nothing outside of the ball. All 0: no ball.""",
    labels=("x", "y", "z", "radius", "falloff"),
    **_LIMIT,
)
MASK = Value(
    "Mask",
    None,
    """Image in the deformed space by which displacements are multiplied, from 0 to 1; of integers,
    as of labels, what is not 0 counts as 1. Outside of the image nothing moves.""",
    more="Or input port 3.",
    kinds="a vtkImageData, or a `vtk_mls.BallMask`, `BoxMask` or `ImageMask`",
)
FIXED_PLANES = Planes(
    "FixedPlanes",
    (),
    """Planes that stay where they are: a point, a normal, and the distance from the plane over
    which the deformation grows to its whole.""",
    **_LIMIT,
)
SLIDING_PLANES = Planes(
    "SlidingPlanes",
    (),
    """Planes along which material slides, as at a plane of symmetry: a point, a normal, and the
    distance from the plane over which displacements along the normal grow to their whole.""",
    **_LIMIT,
)
CONSTRAINTS = Values(
    "Constraints",
    (),
    "Faces beside those of FixedPlanes and SlidingPlanes.",
    kinds="a `vtk_mls.FixedFace` or `SlidingFace`",
)
LIMITS = (MASK_BALL, MASK, FIXED_PLANES, SLIDING_PLANES, CONSTRAINTS)

# What moves the material before.
INITIAL_TRANSFORM = TransformFile(
    "InitialTransform",
    "",
    """Transform that moves the material first, so that the handles correct it: a file of ITK, ANTs
    or 3D Slicer with an affine transform or a displacement field that resamples images. Handles at
    rest, and cuts in the rest frame, are in the space that it leads to.""",
    more="""Images are resampled once, by both; points of meshes are moved by both.""",
    is_advanced=True,
)

INTERPOLATION = Choice(
    "Interpolation",
    Sampling.interpolation,
    "How values between the points of the input are interpolated.",
    choices=INTERPOLATIONS,
)
LABEL_ARRAYS = ArrayNames(
    "LabelArrays",
    (),
    """Arrays with labels, whose values must not be mixed: they are sampled nearest whatever
    the interpolation is.""",
    more="""So are those that the input itself names in its field data LabelArrays, as the images of
    segmentations do that `vtk_mls.io` reads.""",
)
BACKGROUND = Number(
    "Background",
    Sampling.background,
    "Value where the deformed image has no material.",
    more="""That is outside of the input and, unless values are continued there, in the void; in the
    array vtkGhostType it is 0. An array whose type does not have the value gets the nearest that it
    has (integers 0 for NaN), with a warning.""",
)

# Where the output's points are.
_GIVEN = {"shown_when": ("OutputGrid", "given")}
OUTPUT_GRID = Choice(
    "OutputGrid",
    "input",
    """Grid of the output: that of the input; fitted, with the input's spacing but large enough
    for the deformed volume; or given by dimensions, spacing and origin.""",
    more="""For "fitted" control points and cuts are updated in RequestInformation; "given" has the
    directions of the input.""",
    choices=("input", "fitted", "given"),
    shown_when=("Reference", None),
)
GIVEN_GRID = (
    Vector(
        "OutputDimensions",
        (64, 64, 64),
        "Number of points of the output in each direction.",
        labels=("nx", "ny", "nz"),
        **_GIVEN,
    ),
    Vector(
        "OutputSpacing",
        (1.0, 1.0, 1.0),
        "Distance of the output's points in each direction.",
        unit="world units",
        **_GIVEN,
    ),
    Vector(
        "OutputOrigin",
        (0.0, 0.0, 0.0),
        "Position of the output's first point.",
        unit="world coordinates",
        **_GIVEN,
    ),
)
REFERENCE = Value(
    "Reference",
    None,
    """Image whose grid the output of an image has, with its directions; only the place of its
    points counts.""",
    more="""Or input port 5, which does not count then. OutputGrid does not count with either. A
    warning says if nothing of the input arrives there. Meshes are an error.""",
    kinds="a vtkImageData or a `vtk_mls.Grid`",
)

# What a cut has torn.
VOID_VALUES_CHOICE = Choice(
    "VoidValues",
    Sampling.void_values,
    """What arrays hold in the void: the background; or continued, as if the material of each
    side went on behind the face of the cut. Turn HideVoid off, contour or slice that and clip
    the result by VoidDistance at 0: it ends at the face without steps.""",
    choices=VOID_VALUES,
)
VOID = (
    Flag(
        "HideVoid",
        True,
        """Whether the void that a cut opens is hidden (by the array vtkGhostType). Turn it off to
        clip or contour by VoidDistance at 0, which gives a smooth face.""",
    ),
    Flag(
        "SplitCells",
        True,
        """Whether the cells of a mesh are split along a cut, so that it opens. Otherwise cells that
        are torn are kept, marked in the cell array Void, and hidden.""",
    ),
    VOID_VALUES_CHOICE,
)

OVERLAP = Flag(
    "GenerateOverlap",
    False,
    """Whether to make the point array Overlap of an image, which is 1 where material from both
    sides of a cut has come to the same place and only one can be shown, and the field array
    OverlappingPoints with the number of such points.""",
    more="""With CutFrame deformed there is none: what comes to a cut is gone. Meshes keep both
    sides. If the output is made in pieces, it is the number of each piece.""",
)

GRADIENT_ARRAY = ArrayName(
    "GradientArray",
    "",
    """Point scalars whose gradient in the deformed volume is wanted, as the point array
    Gradient, for shading: it follows the deformation exactly.""",
    more="""Three floats, per world unit: J_G^T (grad f)(G(v)), and across the face on the face of
    the void unless values are continued behind it.""",
)
GRADIENT_VECTOR_ARRAYS = ArrayNames(
    "GradientVectorArrays",
    (),
    """Arrays of the input that are gradients, and are transformed as such (covariantly). So are
    the active normals, without being named.""",
    components=3,
)
PUSH_FORWARD_ARRAYS = ArrayNames(
    "PushForwardArrays",
    (),
    """Arrays of vectors that move with the material, as velocities do, and are transformed as such
    (contravariantly).""",
    components=3,
)
VECTORS = (
    GRADIENT_ARRAY,
    GRADIENT_VECTOR_ARRAYS,
    Flag("NormalizeGradient", False, "Whether gradients get length 1."),
    PUSH_FORWARD_ARRAYS,
)

JACOBIAN = (
    Flag(
        "GenerateJacobian",
        False,
        """Whether to make the point array Jacobian with 9 components: component 3 i + j is the
        derivative of G_j in the direction i, where G(v) is the point that the material now at v
        came from. It takes gradients of the input to those of the output.""",
        more="It is (I + J_D)^T of Eq. 29, row by row.",
    ),
    Flag(
        "GenerateJacobianDeterminant",
        False,
        """Whether to make the point array JacobianDeterminant, zero or negative where space is
        folded, and the field array FoldedVoxels with the number of such points.""",
        more="""The void does not count. Of a mesh the field arrays are InvertedCells, the number of
        cells that the deformation has inverted, and UncheckedCells, the number of cells without a
        result. If the output is made in pieces, each piece has its own numbers, without ghost
        cells.""",
    ),
)

CELL_QUALITY = (
    Flag(
        "GenerateCellQuality",
        False,
        """Whether to make the cell arrays CellQuality and CellQualityBefore of a mesh: VTK's scaled
        Jacobian of the deformed cells, and of the same cells at rest. It is 1 for regular cells,
        and 0 or less for cells that are inverted or, of quads, concave.""",
        more="""NaN for cells that are no triangles, quads, tetrahedra, hexahedra, wedges or
        pyramids. That a triangle or quad is turned over shows in InvertedCells only.""",
    ),
    Flag(
        "GenerateLargestBlend",
        False,
        """Whether to make the field array LargestBlend of a mesh: the largest Blend, up to that of
        the filter, at which no cell is inverted.""",
        more="""Where cells are inverted, it is found by bisection and rounded down to a multiple of
        0.01: no cell is inverted there, and some cell is at 0.01 more. The mesh is moved about
        eight times for that. If the output is made in pieces, it is the blend of each piece.""",
    ),
)

INVERSE = Flag(
    "Inverse",
    False,
    """Whether to make the displacement to where the material goes, which moves points, instead
    of the one to where it came from, which resamples images.""",
)
SAMPLE_DIMENSIONS = Dimensions(
    "SampleDimensions",
    (32, 32, 32),
    "Number of points in each direction where the input is not an image.",
    labels=("nx", "ny", "nz"),
)

# What both filters ask of the deformation.
CUTTING = (CUT_TYPE, CUT_ORIGIN, CUT_NORMAL, CUT_INWARD, CUTS, *CUT_OPTIONS)
_SHARED = (
    *MAP,
    *CUTTING,
    *OWN_CONTROL_POINTS,
    *HANDLE_OPTIONS,
    *LIMITS,
    INITIAL_TRANSFORM,
)
COMPUTING = _of_section("computing")
INTERACTIVE_COMPUTING = _of_section("computing", is_interactive=True)
DEFORMING = (*_SHARED, OVERLAP, *JACOBIAN, *COMPUTING)
# MLSDeform
SAMPLING = (INTERPOLATION, LABEL_ARRAYS, BACKGROUND, OUTPUT_GRID, *GIVEN_GRID, REFERENCE)
DEFORM = (*_SHARED, *SAMPLING, *VOID, OVERLAP, *VECTORS, *JACOBIAN, *CELL_QUALITY, *COMPUTING)
# MLSDisplacementField
DISPLACEMENT_FIELD = (*_SHARED, INVERSE, SAMPLE_DIMENSIONS, OVERLAP, *JACOBIAN, *COMPUTING)

# MLSLandmarkReport
LANDMARK_REPORT = (next(prop for prop in COMPUTING if prop.name == "Device"),)

# MLSControlPoints
MODE = Choice(
    "Mode",
    "points",
    """points: the rest positions are listed; lattice: they fill a box regularly; file: they are
    read from one.""",
    choices=("points", "lattice", "file"),
)
_FILE = {"shown_when": ("Mode", "file")}
SPACE = Choice(
    "Space",
    "lps",
    """Frame of files that do not say theirs: markups do. What comes out is in LPS (x to the
    patient's left, y to the back, z to the head), as from MLS Image Reader.""",
    choices=("lps", "ras"),
    **_FILE,
)
FILES = (
    FileName(
        "FileName",
        "",
        """File with control points: markups of 3D Slicer (.fcsv, .mrk.json) and other landmarks,
        which are p; or pairs, as of px,py,pz,qx,qy,qz[,weight] (.csv, .txt) and of BigWarp. The
        list of deformed positions goes first, if it is not empty.""",
        **_FILE,
    ),
    FileName(
        "DeformedFileName",
        "",
        """File with the positions q that control points were moved to, such as markups; or none.
        They are matched with their p by labels, or else by order.""",
        **_FILE,
    ),
    SPACE,
)
LISTS = (
    Positions(
        "DeformedPoints",
        (),
        """Positions q to which the control points are dragged, with the mouse in the view or
        here, one for each; none: they stay at rest.""",
        more="They count in every mode.",
        unit="world coordinates",
    ),
    Positions(
        "RestPoints",
        (),
        "Positions p of the control points in the undeformed space.",
        unit="world coordinates",
    ),
)
_LATTICE = {"shown_when": ("Mode", "lattice")}
LATTICE_DIMENSIONS = Dimensions(
    "LatticeDimensions",
    (3, 3, 3),
    "Number of control points in each direction of the lattice.",
    more="A single one lies in the middle.",
    labels=("nx", "ny", "nz"),
    **_LATTICE,
)
LATTICE = (
    LATTICE_DIMENSIONS,
    Vector(
        "Bounds",
        (-1.0, 1.0, -1.0, 1.0, -1.0, 1.0),
        "Box of the lattice: xmin, xmax, ymin, ymax, zmin, zmax.",
        labels=("xmin", "xmax", "ymin", "ymax", "zmin", "zmax"),
        unit="world coordinates",
        **_LATTICE,
    ),
)
WEIGHTS = Factors(
    "Weights",
    (),
    "A positive factor for each control point; empty: all count alike.",
    more="They count in every mode.",
    is_advanced=True,
)
CONTROL_POINTS = (MODE, *FILES, *LISTS, *LATTICE, WEIGHTS)
