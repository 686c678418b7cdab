"""The properties of the filters: one table for each, in the order of ParaView's panels."""

from vtk_mls import INTERPOLATIONS, VOID_VALUES, BallMask, Sampling
from vtk_mls.filters.option_properties import CUT_SHAPES, WITH_CUTS, of_cut_field, of_section
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
    Property,
    TransformFile,
    Value,
    Values,
    Vector,
)
from vtk_mls.model import cuts
from vtk_mls.model.handles.handle_cells import HANDLE_SHAPES

_OF_IMAGES = {"is_advanced": True, "only_for": "images"}
_OF_MESHES = {"is_advanced": True, "only_for": "meshes"}

MAP = of_section("map")
CUT_OPTIONS = of_section("cut")

# A cut by properties.
CUT_TYPE = Choice(
    "CutType",
    "none",
    " ".join(["A cut in addition to those of the input Cuts.", *(s.help for s in CUT_SHAPES)]),
    choices=("none", *cuts.BY_NUMBERS),
)

CUT_FIELDS: dict[str, Property] = {}  # by the names of fields
for _field in (field for shape in CUT_SHAPES for field in shape.fields):
    CUT_FIELDS.setdefault(_field.name, of_cut_field(_field))

CUTS = Values(
    "Cuts",
    "Cuts in addition to those of CutType and of input port 2.",
    values="each a `vtk_mls.Plane`, `HalfPlane` or `Surface`",
)

# Control points of a filter's own.
OWN_CONTROL_POINTS = (
    Positions(
        "DeformedPoints",
        """Positions q to which the handles are dragged, with the mouse or here. Handles that are
        not dragged hold the material in place.""",
        more="If empty, q = p. Ignored if input port 1 is connected.",
        unit="world coordinates",
    ),
    Positions(
        "RestPoints",
        """Positions p of the handles in the undeformed space, one for each deformed point. ParaView
        starts with a lattice over the bounds of the input.""",
        more="""Outside of ParaView there are no handles by default, and nothing moves. Handles that
        rest on the cut of CutType belong to neither side and are ignored, because they would hold
        it shut. Ignored if input port 1 is connected.""",
        unit="world coordinates",
    ),
    Factors(
        "Weights",
        "A positive factor for each handle. If empty, all factors are 1.",
        is_advanced=True,
        shown_when=("ControlPoints", None),
    ),
)

# Handles beside points.
HANDLE_SHAPES_CHOICE = Choice(
    "HandleShapes",
    "points",
    """Whether the points or the cells of the input ControlPoints are handles. With cells, vertices
    and points without a cell are points, lines are curves, and closed surfaces are rigid
    regions.""",
    more="""Curves are moved along their whole length. Each connected surface moves by the rotation
    and translation of its points. Cells with a volume count by their outer faces. Weights and paths
    belong to points.""",
    choices=HANDLE_SHAPES,
    hidden_when=("ControlPoints", None),
)
HANDLES = Values(
    "Handles",
    "Handles in addition to those of input port 1 or of RestPoints.",
    values="each a `vtk_mls.CurveHandle` or `RegionHandle`",
)
HANDLE_OPTIONS = (HANDLE_SHAPES_CHOICE, HANDLES)

# Where the deformation acts.
_LIMIT = {"is_advanced": True, "unit": "world coordinates"}
MASK_BALL = Vector(
    "MaskBall",
    (0.0, 0.0, 0.0, 0.0, 0.0),
    """Ball in the deformed space in which the deformation acts: center, radius, and the distance
    outside the ball over which the deformation fades to zero. All 0: no ball.""",
    labels=tuple(BallMask.labels()),
    **_LIMIT,
)
MASK = Value(
    "Mask",
    """Image in the deformed space by which displacements are multiplied, with values from 0 to 1.
    In an image of integers, such as labels, every value except 0 counts as 1. Outside the image,
    nothing moves.""",
    more="Alternative: input port 3.",
    values="a vtkImageData, or a `vtk_mls.BallMask`, `BoxMask` or `ImageMask`",
)
FIXED_PLANES = Planes(
    "FixedPlanes",
    """Planes that stay in place: a point, a normal, and the distance from the plane over which the
    deformation grows from zero to its full size.""",
    **_LIMIT,
)
SLIDING_PLANES = Planes(
    "SlidingPlanes",
    """Planes along which material slides, such as a plane of symmetry: a point, a normal, and a
    distance. Over this distance from the plane, displacements along the normal grow from zero to
    their full size.""",
    **_LIMIT,
)
CONSTRAINTS = Values(
    "Constraints",
    "Faces in addition to those of FixedPlanes and SlidingPlanes.",
    values="each a `vtk_mls.FixedFace` or `SlidingFace`",
)
LIMITS = (MASK_BALL, MASK, FIXED_PLANES, SLIDING_PLANES, CONSTRAINTS)

# What moves the material before.
INITIAL_TRANSFORM = TransformFile(
    "InitialTransform",
    """Transform that moves the material first, so that the handles correct it. It is a file of ITK,
    ANTs or 3D Slicer with an affine transform or a displacement field, as used to resample images.
    Handles at rest, and cuts in the rest frame, lie in the space after this transform.""",
    more="Images are resampled once, with both combined. Points of meshes are moved by both.",
    is_advanced=True,
)

INTERPOLATION = Choice(
    "Interpolation",
    Sampling.interpolation,
    "How values between the points of the input are interpolated.",
    choices=INTERPOLATIONS,
    **_OF_IMAGES,
)
LABEL_ARRAYS = ArrayNames(
    "LabelArrays",
    """Arrays with labels, whose values must not be mixed. The nearest value is taken, whatever the
    interpolation is.""",
    more="""Arrays that the field data LabelArrays of the input names are also labels. `vtk_mls.io`
    sets it for segmentations.""",
    **_OF_IMAGES,
)
BACKGROUND = Number(
    "Background",
    Sampling.background,
    "Value where the deformed image has no material.",
    more="""This is outside the input and, unless VoidValues is continued, in the void. In the array
    vtkGhostType the value is 0. If the type of an array cannot hold the value, the nearest one is
    used (0 for NaN in integers), with a warning.""",
    spellings={"auto": "auto"},
    **_OF_IMAGES,
)
AUTOMATIC_BACKGROUND = Flag(
    "AutomaticBackground",
    False,
    """Whether each array has its own Background, from the corners of the input: the median of the
    values at the eight corners (four of a slice), such as air around a CT. For labels it is 0.""",
    more="""Of two middle values it is the lower. Each component has its own. NaN is ignored. At all
    times the value is that of the first time step. Background has no effect then. In ParaView it
    is on by default, and a Background other than 0 is used instead.""",
    is_on_in_paraview=True,
    **_OF_IMAGES,
)

# Where the output's points are.
_GIVEN = {"shown_when": ("OutputGrid", "given"), **_OF_IMAGES}
OUTPUT_GRID = Choice(
    "OutputGrid",
    "input",
    """Grid of the output. input: the grid of the input. fitted: the spacing of the input, but large
    enough for the deformed volume. given: by dimensions, spacing and origin.""",
    more="""With "fitted", control points and cuts are updated in RequestInformation. "given" has
    the directions of the input.""",
    choices=("input", "fitted", "given"),
    shown_when=("Reference", None),
    **_OF_IMAGES,
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
        "Distance between the output's points in each direction.",
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
    """Image whose grid the output image gets, with its directions. The values of the image are not
    used.""",
    more="""Alternative: input port 5, which is ignored if this is set. Both override OutputGrid. A
    warning says if no material of the input arrives there. Meshes are an error.""",
    values="a vtkImageData or a `vtk_mls.Grid`",
)

# What a cut has torn.
_CUTS_OF_IMAGES = {**WITH_CUTS, "only_for": "images"}
VOID_VALUES_CHOICE = Choice(
    "VoidValues",
    Sampling.void_values,
    """Values of arrays in the void. background: the value of Background. continued: as if the
    material of each side continued behind the face of the cut. For a smooth face, turn HideVoid
    off, contour or slice the continued array, and clip the result by VoidDistance at 0.""",
    choices=VOID_VALUES,
    **_CUTS_OF_IMAGES,
)
VOID = (
    Flag(
        "HideVoid",
        True,
        """Whether the void that a cut opens is hidden (by the array vtkGhostType). Turn it off to
        clip or contour by VoidDistance at 0, for a smooth face.""",
        **_CUTS_OF_IMAGES,
    ),
    Flag(
        "SplitCells",
        True,
        """Whether the cells of a mesh are split along a cut, so that it opens. Otherwise, torn
        cells are kept, marked in the cell array Void, and hidden.""",
        **WITH_CUTS,
        only_for="meshes",
    ),
    VOID_VALUES_CHOICE,
)

OVERLAP = Flag(
    "GenerateOverlap",
    False,
    """Whether an image gets the point array Overlap and the field array OverlappingPoints. Overlap
    is 1 where material from both sides of a cut is at the same place. The image shows only one
    side there. OverlappingPoints is the number of such points.""",
    more="""With CutFrame deformed, nothing overlaps, because material that reaches a cut is lost.
    Meshes keep both sides. If the output is made in pieces, each piece has its own number.""",
    **_CUTS_OF_IMAGES,
)

GRADIENT_ARRAY = ArrayName(
    "GradientArray",
    "",
    """Point scalars whose gradient in the deformed volume becomes the point array Gradient, for
    shading. It follows the deformation exactly.""",
    more="""Three floats, per world unit: J_G^T (grad f)(G(v)). On the face of the void, it is
    normal to the face unless VoidValues is continued.""",
    **_OF_IMAGES,
)
GRADIENT_VECTOR_ARRAYS = ArrayNames(
    "GradientVectorArrays",
    """Arrays of the input that are gradients and are transformed as such (covariantly). Active
    normals are always transformed.""",
    components=3,
    is_advanced=True,
)
PUSH_FORWARD_ARRAYS = ArrayNames(
    "PushForwardArrays",
    """Arrays of vectors that move with the material, such as velocities, and are transformed as
    such (contravariantly).""",
    components=3,
    is_advanced=True,
)
VECTORS = (
    GRADIENT_ARRAY,
    GRADIENT_VECTOR_ARRAYS,
    Flag("NormalizeGradient", False, "Whether gradients are scaled to length 1.", is_advanced=True),
    PUSH_FORWARD_ARRAYS,
)

JACOBIAN = (
    Flag(
        "GenerateJacobian",
        False,
        """Whether to write the point array Jacobian with 9 components. Component 3 i + j is the
        derivative of G_j in the direction i, where G(v) is the original position of the material
        now at v. It transforms gradients of the input to gradients of the output.""",
        more="It is (I + J_D)^T of Eq. 29, row by row.",
        is_advanced=True,
    ),
    Flag(
        "GenerateJacobianDeterminant",
        False,
        """Whether to write the point array JacobianDeterminant, which is zero or negative where
        space is folded, and the field array FoldedVoxels with the number of such points.""",
        more="""The void does not count. A mesh gets the field arrays InvertedCells, the number of
        cells that the deformation has inverted, and UncheckedCells, the number of cells without a
        result. If the output is made in pieces, each piece has its own numbers, without ghost
        cells.""",
        is_advanced=True,
    ),
)

CELL_QUALITY = (
    Flag(
        "GenerateCellQuality",
        False,
        """Whether a mesh gets the cell arrays CellQuality and CellQualityBefore: VTK's scaled
        Jacobian of the deformed cells, and of the same cells at rest. It is 1 for regular cells,
        and 0 or less for inverted cells and concave quads.""",
        more="""It is NaN for cells other than triangles, quads, tetrahedra, hexahedra, wedges and
        pyramids. Only InvertedCells shows that a triangle or quad is turned over.""",
        **_OF_MESHES,
    ),
    Flag(
        "GenerateLargestBlend",
        False,
        """Whether a mesh gets the field array LargestBlend: the largest Blend, up to that of the
        filter, at which no cell is inverted.""",
        more="""If cells are inverted, it is found by bisection and rounded down to a multiple of
        0.01. At this blend no cell is inverted, and at 0.01 more some cell is. This moves the mesh
        about eight times. If the output is made in pieces, each piece has its own blend.""",
        **_OF_MESHES,
    ),
)

INVERSE = Flag(
    "Inverse",
    False,
    """Whether to write the displacement to the new position of the material, which moves points,
    instead of the displacement to its original position, which resamples images.""",
)
SAMPLE_DIMENSIONS = Dimensions(
    "SampleDimensions",
    (32, 32, 32),
    "Number of points in each direction if the input is not an image.",
    labels=("nx", "ny", "nz"),
    only_for="meshes",
)

# What both filters ask of the deformation.
CUTTING = (CUT_TYPE, *CUT_FIELDS.values(), CUTS, *CUT_OPTIONS)
_SHARED = (*MAP, *CUTTING, *OWN_CONTROL_POINTS, *HANDLE_OPTIONS, *LIMITS, INITIAL_TRANSFORM)
COMPUTING = of_section("computing")
INTERACTIVE_COMPUTING = of_section("computing", is_interactive=True)
DEFORMING = (*_SHARED, OVERLAP, *JACOBIAN, *COMPUTING)
# MLSDeform
SAMPLING = (
    INTERPOLATION,
    LABEL_ARRAYS,
    BACKGROUND,
    AUTOMATIC_BACKGROUND,
    OUTPUT_GRID,
    *GIVEN_GRID,
    REFERENCE,
)
DEFORM = (*_SHARED, *SAMPLING, *VOID, OVERLAP, *VECTORS, *JACOBIAN, *CELL_QUALITY, *COMPUTING)
DISPLACEMENT_FIELD = (*_SHARED, INVERSE, SAMPLE_DIMENSIONS, OVERLAP, *JACOBIAN, *COMPUTING)
LANDMARK_REPORT = (next(prop for prop in COMPUTING if prop.name == "Device"),)

# MLSControlPoints
MODE = Choice(
    "Mode",
    "points",
    """Source of the rest positions. points: a list. lattice: a regular lattice in a box. file: a
    file.""",
    choices=("points", "lattice", "file"),
)
_FILE = {"shown_when": ("Mode", "file")}
SPACE = Choice(
    "Space",
    "lps",
    """Frame of files that do not state their own, as markups do. The output is in LPS (x to the
    patient's left, y to the back, z to the head), like that of MLS Image Reader.""",
    choices=("lps", "ras"),
    **_FILE,
)
FILES = (
    FileName(
        "FileName",
        """File with control points. Markups of 3D Slicer (.fcsv, .mrk.json) and other landmarks are
        p. Tables px,py,pz,qx,qy,qz[,weight] (.csv, .txt) and files of BigWarp have pairs.
        DeformedPoints overrides the q of the file if it is not empty.""",
        **_FILE,
    ),
    FileName(
        "DeformedFileName",
        """File with the deformed positions q of the control points, such as markups. May be empty.
        They are paired with p by label, or else by order.""",
        **_FILE,
    ),
    SPACE,
)
LISTS = (
    Positions(
        "DeformedPoints",
        """Positions q to which the control points are dragged, with the mouse or here, one for each
        control point. If empty, they stay at rest.""",
        more="Used in every mode.",
        unit="world coordinates",
    ),
    Positions(
        "RestPoints",
        "Positions p of the control points in the undeformed space.",
        unit="world coordinates",
    ),
)
_LATTICE = {"shown_when": ("Mode", "lattice")}
LATTICE_DIMENSIONS = Dimensions(
    "LatticeDimensions",
    (3, 3, 3),
    "Number of control points in each direction of the lattice.",
    more="A single one is in the middle of the box.",
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
    "A positive factor for each control point. If empty, all factors are 1.",
    more="Used in every mode.",
    is_advanced=True,
)
CONTROL_POINTS = (MODE, *FILES, *LISTS, *LATTICE, WEIGHTS)
