"""ParaView plugin: the filters MLSDeform and MLSDisplacementField, the source MLSControlPoints.

In the GUI: Tools > Manage Plugins > Load New, then choose this file.  In pvpython:
`LoadPlugin("/path/to/vtk_mls_plugin.py", ns=globals())`.  The work is done by `vtk_mls.filters`;
this file says how ParaView shows it.

Properties are declared as XML on the class: ParaView's method decorators do not see inherited
setters, and before ParaView 5.12 the panel would list their properties in alphabetical order.
"""

from __future__ import annotations

import sys
from contextlib import suppress
from pathlib import Path

from paraview.util.vtkAlgorithm import smhint, smproperty, smproxy
from vtkmodules.vtkCommonDataModel import vtkImageData

# This file lies in <checkout>/paraview_plugin or <site-packages>/vtk_mls/paraview_plugin.  Folders
# are appended to sys.path, not put in front: a site-packages may hold a VTK and a numpy, which must
# not replace ParaView's own.
try:
    import vtk_mls
except ModuleNotFoundError as error:
    if error.name != "vtk_mls":
        raise
# A folder vtk_mls beside the user's script, a clone, is found as a package without a file.
if getattr(sys.modules.get("vtk_mls"), "__file__", None) is None:
    sys.modules.pop("vtk_mls", None)
    _above = Path(__file__).resolve().parents[1]
    sys.path.append(str(_above.parent if (_above / "__init__.py").exists() else _above))
    import vtk_mls

from vtk_mls import filters, io
from vtk_mls.arrays import ImageGeometry
from vtk_mls.files import control_point_files
from vtk_mls.filters.algorithm import Algorithm
from vtk_mls.paraview import frame_check, handle_widget
from vtk_mls.paraview.image_axes import along_world
from vtk_mls.paraview.xml import (
    arrays_of,
    bounds,
    check_box,
    choice,
    data_input,
    documentation,
    input_arrays,
    limits,
    names,
    shown_when,
    table,
    vector,
    xml,
)

_here = str(Path(__file__).resolve().parent)
if _here not in sys.path:
    sys.path.append(_here)  # ParaView 5.11 can reload a plugin only from there

handle_widget.start()

paraview_plugin_version = vtk_mls.__version__

MENU = smhint.xml('<ShowInMenu category="MLS Deformation"/>')


def file_name(name, text):
    """A file with control points, asked for in the mode file."""
    return vector(
        "String",
        name,
        "",
        text,
        xml("FileListDomain", name="files"),
        xml(
            "Hints",
            xml(
                "FileChooser",
                extensions=" ".join(suffix[1:] for suffix in control_point_files.FORMATS),
                file_description="Handles",
            ),
            shown_when("Mode", "file"),
        ),
    )


def handle_array(name, index, default, domain, text):
    """A choice among the point arrays of the control points, not made for the user by ParaView."""
    return vector(
        "String",
        name,
        f"{index};1;0;0;{default}",
        text,
        domain,
        xml("Hints", xml("NoDefault"), shown_when("ControlPoints", "null", inverse=1)),
        default_values_delimiter=";",
        command="SetInputArrayToProcess",
        number_of_elements=5,
        element_types="0 0 0 0 2",
        animateable=0,
        panel_visibility="advanced",
    )


# 27 handles, in steps along a box: the widget draws a line through them.
LATTICE = [
    (x, y if x % 2 == 0 else 2 - y, z if (x + y) % 2 == 0 else 2 - z)
    for x in range(3)
    for y in range(3)
    for z in range(3)
]


def lattice(name, setter, text, *hints):
    """A list of handles that begins as a lattice over the bounds of the input.

    ParaView's bounds domain gives minima, centres and maxima of x, y, z in turn to a list that has
    as many elements as the domain has modes.
    """
    steps = [step for place in LATTICE for step in place]
    domain = bounds(",".join(("min", "mid", "max")[step] for step in steps))
    default = " ".join(str(step - 1) for step in steps)
    return table(name, setter, default, ("x", "y", "z"), text, *hints, domain=domain)


CONTROL_POINTS = data_input(
    "ControlPoints",
    1,
    "vtkPolyData",
    """Control points (optional), used instead of the handles below: their positions are p, where
    the material is at rest; a point vector array holds the displacement q - p to where they were
    dragged.""",
    xml("Hints", xml("Optional")),
    input_arrays("vectors", "point", components=3),
    input_arrays("factors", "point", components=1),
    clean_command="DisconnectControlPoints",
)

CUTS = data_input(
    "Cuts",
    2,
    "vtkPolyData",
    """Surfaces to cut along (optional): the polygons of each input, as from the sources Plane and
    Disk; several inputs, and parts that do not hang together, are several cuts.""",
    xml("Hints", xml("Optional")),
    command="AddInputConnection",
    clean_command="DisconnectCuts",
    multiple_input=1,
)


def widget(label, name, *hints):
    """The handles of a list in the view."""
    return xml(
        "PropertyGroup",
        xml("Property", function="HandlePositions", name=name),
        xml("Hints", *hints),
        label=label,
        panel_widget="InteractivePolyLine",
    )


def draggable(deformed, rest, *hints):
    """The two lists of handles, and which of them the mouse edits: the panel alone knows that."""
    return [
        choice(
            "Drag",
            ("deformed", "rest"),
            "deformed",
            """What dragging a handle does: deformed bends; rest moves the handle itself to another
            place of the material. It is also the one to add handles with.""",
            xml("Hints", *hints),
            command="",
        ),
        deformed,
        widget("Handles", "DeformedPoints", shown_when("Drag", "deformed"), *hints),
        rest,
        widget("Handles at Rest", "RestPoints", shown_when("Drag", "rest"), *hints),
    ]


OWN = shown_when("ControlPoints", "null")

# Handles of the filter's own, and which arrays say the same of connected ones. These come after
# Input: a property that names another one makes it, here ControlPoints, and the menu connects what
# is selected to the input that was made first.
HANDLES = [
    *draggable(
        lattice(
            "DeformedPoints",
            "SetDeformedPoint",
            """Positions q to which the handles are dragged, with the mouse in the view or here.
            Those that are not dragged hold the material where it is.""",
        ),
        lattice(
            "RestPoints",
            "SetRestPoint",
            """Positions p of the handles in the undeformed space, one for each of those dragged;
            to begin with a lattice over the bounds of the input.""",
        ),
        OWN,
    ),
    vector(
        "Int",
        "LatticeDimensions",
        "3 3 3",
        """Number of handles in each direction: a change lays them anew, at rest, as a lattice over
        the bounds of the input.""",
        xml("Hints", OWN),
        command="",
        panel_visibility="advanced",
    ),
    table(
        "Weights",
        "SetWeight",
        "",
        ("weight",),
        "A positive factor for each handle; empty: all count alike.",
        OWN,
        panel_visibility="advanced",
    ),
    handle_array(
        "DisplacementArray",
        0,
        "Displacement",
        arrays_of("vectors", "ControlPoints"),
        "Point vector array of the control points with their displacement q - p.",
    ),
    handle_array(
        "WeightArray",
        1,
        "Weight",
        arrays_of("factors", "ControlPoints"),
        """Point array of the control points with a positive factor for each; without it all count
        alike.""",
    ),
]

# What both filters ask of the deformation. The panel has the order of the work, and the long tables
# of the handles stand below all of which there are few: kind and cut.
DEFORMATION = [
    choice(
        "Kind",
        vtk_mls.KINDS,
        "rigid",
        """How the space between the control points follows them: rigid keeps sizes and angles as
        well as it can, similarity allows a change of size, affine allows shear, polynomial bends
        most freely.""",
    ),
    vector(
        "Int",
        "Degree",
        2,
        "Degree of the polynomials: 1 is the affine kind; 2 and 3 need more control points.",
        limits("Int", min=1, max=3),
        xml("Hints", shown_when("Kind", "polynomial")),
    ),
    vector(
        "Double",
        "Alpha",
        1.0,
        """How local the influence of a control point is: its weight at distance r is
        1 / r^(2 alpha). Must be greater than 0.""",
        limits("Double", min=0.1, max=4),
    ),
    vector(
        "Double",
        "Blend",
        1.0,
        """Which part of their way from p to q the handles go: 0 leaves everything exactly as it
        was.""",
        limits("Double", min=0, max=1),
    ),
]

HAS_CUT = shown_when("CutType", "none", inverse=1)

# A cut by properties, and what all cuts have in common. ParaView shows the plane's widget where the
# first property of its group stands, which is Input: that comes between these two.
CUT_TYPE = choice(
    "CutType",
    ("none", "plane", "half-plane"),
    "none",
    """A cut through the volume beside those of the input Cuts: a plane divides everything; a
    half-plane has an edge through its origin, and begins there.""",
)
CUT = [
    vector(
        "Double",
        "CutOrigin",
        "0 0 0",
        "A point of the plane, or of the edge of the half-plane.",
        bounds("mid"),
        xml("Hints", HAS_CUT),
    ),
    vector(
        "Double",
        "CutNormal",
        "1 0 0",
        "Normal of the plane or half-plane.",
        xml("Hints", HAS_CUT),
    ),
    xml(
        "PropertyGroup",
        xml("Property", function="Origin", name="CutOrigin"),
        xml("Property", function="Normal", name="CutNormal"),
        xml("Property", function="Input", name="Input"),
        xml("Hints", HAS_CUT),
        label="Cut Plane",
        panel_widget="InteractivePlane",
    ),
    vector(
        "Double",
        "CutInward",
        "0 0 1",
        """Direction in which the half-plane extends from its edge; the edge is at a right angle to
        it and to the normal.""",
        xml("Hints", shown_when("CutType", "half-plane")),
    ),
    vector(
        "Double",
        "Nu",
        2.0,
        """How fast the influence of control points behind a cut fades with the length of the way
        round it. Must be greater than 1.""",
        limits("Double", min=1.1, max=8),
        panel_visibility="advanced",
    ),
]

JACOBIAN = [
    check_box(
        "GenerateJacobian",
        """Whether to make the point array Jacobian with 9 components: component 3 i + j is the
        derivative of G_j in the direction i, where G(v) is the place that the material now at v
        came from. It turns gradients of the input into those of the output.""",
    ),
    check_box(
        "GenerateJacobianDeterminant",
        """Whether to make the point array JacobianDeterminant, which is not above 0 where space is
        folded, and the field array FoldedVoxels with the number of such points.""",
    ),
]

DEVICE = vector(
    "String",
    "Device",
    "",
    """Where to compute: empty for the first GPU, else the first CPU; cpu; gpu; platform:device as
    in 0:1; reference for the slow float64 specification in numpy.""",
    panel_visibility="advanced",
)

DEFORM = [
    documentation(
        """Deforms an image (a volume) or a mesh by control points that are dragged from p to q, by
        moving least squares. Arrays of an image are resampled; points of a mesh are moved by the
        exact inverse, so that both stay together. Cuts open it: the void in an image is in the
        array Void, and cells of a mesh are split along them."""
    ),
    *DEFORMATION,
    CUT_TYPE,
    data_input(
        "Input",
        0,
        "vtkDataSet",
        "The image or mesh to deform.",
        input_arrays("arrays", "any"),
        input_arrays("scalars", "point", components=1),
        input_arrays("gradients", "any", components=3),
        composite=1,
    ),
    CONTROL_POINTS,
    CUTS,
    *CUT,
    *HANDLES,
    choice(
        "Interpolation",
        vtk_mls.INTERPOLATIONS,
        "linear",
        "How values between the points of the input are made.",
    ),
    names(
        "LabelArrays",
        "AddLabelArray",
        """Arrays with labels, whose values must not be mixed: they are sampled nearest whatever
        the interpolation is.""",
        arrays_of("arrays", "Input"),
    ),
    vector("Double", "Background", 0.0, "Value where the deformed image has no material."),
    choice(
        "OutputGrid",
        ("input", "fitted", "given"),
        "input",
        """Grid of the output: that of the input; fitted, with the input's spacing but large enough
        for the deformed volume; or given by dimensions, spacing and origin.""",
    ),
    vector(
        "Int",
        "OutputDimensions",
        "64 64 64",
        "Number of points of the output in each direction.",
        xml("Hints", shown_when("OutputGrid", "given")),
    ),
    vector(
        "Double",
        "OutputSpacing",
        "1 1 1",
        "Distance of the output's points in each direction.",
        xml("Hints", shown_when("OutputGrid", "given")),
    ),
    vector(
        "Double",
        "OutputOrigin",
        "0 0 0",
        "Position of the output's first point.",
        xml("Hints", shown_when("OutputGrid", "given")),
    ),
    check_box(
        "HideVoid",
        """Whether the void that a cut opens is hidden (by the array vtkGhostType). Turn it off to
        clip or contour by VoidDistance at 0, which gives a smooth face.""",
        default=1,
    ),
    check_box(
        "SplitCells",
        """Whether the cells of a mesh are split along a cut, so that it opens. Otherwise cells that
        are torn are kept, marked in the cell array Void, and hidden.""",
        default=1,
    ),
    choice(
        "VoidValues",
        vtk_mls.VOID_VALUES,
        "background",
        """What arrays hold in the void: the background; or continued, as if the material of each
        side went on behind the face of the cut. Turn HideVoid off, contour or slice that and clip
        the result by VoidDistance at 0: it ends at the face without steps.""",
    ),
    vector(
        "String",
        "GradientArray",
        "none",
        """Point scalars whose gradient in the deformed volume is wanted, as the point array
        Gradient, for shading: it follows the deformation exactly.""",
        arrays_of("scalars", "Input", none_string="none"),
        xml("Hints", xml("NoDefault")),
    ),
    names(
        "GradientVectorArrays",
        "AddGradientVectorArray",
        """Arrays of the input that are gradients; they are turned with the material. So are the
        active normals, without being named.""",
        arrays_of("gradients", "Input"),
    ),
    check_box("NormalizeGradient", "Whether gradients get length 1."),
    names(
        "PushForwardArrays",
        "AddPushForwardArray",
        "Arrays of vectors that move with the material, as velocities do.",
        arrays_of("gradients", "Input"),
    ),
    *JACOBIAN,
    DEVICE,
]

FIELD = [
    documentation(
        """Makes an image with the displacement G(v) - v of each of its points v, where G(v) is the
        place that the material now at v came from."""
    ),
    *DEFORMATION,
    CUT_TYPE,
    data_input(
        "Input",
        0,
        "vtkDataSet",
        "Gives the grid of the field: its own if it is an image, else one over its bounds.",
        composite=1,
    ),
    CONTROL_POINTS,
    CUTS,
    *CUT,
    *HANDLES,
    check_box(
        "Inverse",
        """Whether to make the displacement to where the material goes, which moves points, instead
        of the one to where it came from, which resamples images.""",
    ),
    vector(
        "Int",
        "SampleDimensions",
        "32 32 32",
        "Number of points in each direction where the input is not an image.",
    ),
    *JACOBIAN,
    DEVICE,
]

SOURCE = [
    xml("OutputPort", name="Handles", index=0),
    xml("OutputPort", name="Arrows", index=1),
    documentation("Control points for the MLS filters, from lists or as a lattice over a box."),
    choice(
        "Mode",
        ("points", "lattice", "file"),
        "points",
        """points: the rest positions are listed; lattice: they fill a box regularly; file: they are
        read from one.""",
    ),
    file_name(
        "FileName",
        """File with control points: markups of 3D Slicer (.fcsv, .mrk.json) and other landmarks,
        which are p; or pairs, as of px,py,pz,qx,qy,qz[,weight] (.csv, .txt) and of BigWarp. The
        list of deformed positions goes first, if it is not empty.""",
    ),
    file_name(
        "DeformedFileName",
        """File with the places q that control points were moved to, such as markups; or none. They
        find their p by their labels, or else by their order.""",
    ),
    choice(
        "Space",
        ("lps", "ras"),
        "lps",
        """Frame of files that do not say theirs: markups do. What comes out is in LPS (x to the
        patient's left, y to the back, z to the head), as from MLS Image Reader.""",
        xml("Hints", shown_when("Mode", "file")),
    ),
    xml(
        "PropertyGroup",
        *(xml("Property", name=name) for name in ("FileName", "DeformedFileName", "Space")),
        xml("Hints", shown_when("Mode", "file")),
        label="Files, Taken to LPS",
    ),
    *draggable(
        table(
            "DeformedPoints",
            "SetDeformedPoint",
            "",
            ("x", "y", "z"),
            """Positions q to which the control points are dragged, with the mouse in the view or
            here, one for each; none: they stay at rest.""",
        ),
        table(
            "RestPoints",
            "SetRestPoint",
            "-1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1  -1 1 1  1 1 1  1 -1 1  -1 -1 1",
            ("x", "y", "z"),
            "Positions p of the control points in the undeformed space.",
        ),
    ),
    vector(
        "Int",
        "LatticeDimensions",
        "3 3 3",
        "Number of control points in each direction of the lattice.",
        xml("Hints", shown_when("Mode", "lattice")),
    ),
    vector(
        "Double",
        "Bounds",
        "-1 1 -1 1 -1 1",
        "Box of the lattice: xmin, xmax, ymin, ymax, zmin, zmax.",
        xml("Hints", shown_when("Mode", "lattice")),
    ),
    table(
        "Weights",
        "SetWeight",
        "",
        ("weight",),
        "A positive factor for each control point; empty: all count alike.",
        panel_visibility="advanced",
    ),
]


# Where several readers serve, ParaView asks in its GUI, and takes the first by the alphabet in
# scripts: this one's name is before those of its own.
READER = [
    documentation(
        """Reads medical images as vtk-mls deform does: NIfTI, NRRD and MetaImage, all of them into
        one world, LPS (x to the patient's left, y to the back, z to the head), as markups are, with
        the orientation and the scaling that the file has. ParaView's own readers leave these
        out."""
    ),
    vector("String", "FileName", "", "The file.", xml("FileListDomain", name="files")),
    xml(
        "Hints",
        xml(
            "ReaderFactory",
            extensions="nii nii.gz nrrd nhdr seg.nrrd mha mhd",
            file_description="MLS Image Reader: medical images in LPS",
        ),
    ),
]


@smproxy.filter(name="MLSDeform", label="MLS Deform")
@MENU
@smproperty.xml("".join(DEFORM))
class MLSDeform(filters.MLSDeform):
    """`vtk_mls.filters.MLSDeform` as a ParaView filter."""

    def SetGradientArray(self, name):
        """The list says "none" for no array."""
        super().SetGradientArray("" if name == "none" else name)

    def RequestData(self, request, inInfo, outInfo):
        """Not without a word if handles are on the wrong side of the head."""
        if sentence := frame_check.mixed(self, inInfo):
            self._warn(sentence)
        return super().RequestData(request, inInfo, outInfo)


@smproxy.filter(name="MLSDisplacementField", label="MLS Displacement Field")
@MENU
@smproperty.xml("".join(FIELD))
class MLSDisplacementField(filters.MLSDisplacementField):
    """`vtk_mls.filters.MLSDisplacementField` as a ParaView filter."""

    def RequestData(self, request, inInfo, outInfo):
        """Not without a word if handles are on the wrong side of the head."""
        if sentence := frame_check.mixed(self, inInfo):
            self._warn(sentence)
        return super().RequestData(request, inInfo, outInfo)


@smproxy.source(name="MLSControlPoints", label="MLS Control Points")
@MENU
@smproperty.xml("".join(SOURCE))
class MLSControlPoints(filters.MLSControlPoints):
    """`vtk_mls.filters.MLSControlPoints` as a ParaView source."""


@smproxy.source(name="MLSImageReader", label="MLS Image Reader")
@smproperty.xml("".join(READER))
class MLSImageReader(Algorithm):
    """A reader that knows where images lie, which ParaView's own do not.

    ParaView's outlines leave out an image's directions, and NIfTI's are backwards in LPS as a rule:
    so voxels are stored along the axes of the world, as far as these are not oblique.
    """

    def __init__(self):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkImageData")
        self._file_name, self._read = "", None

    def SetFileName(self, name):
        """An image, as of `io.read_dataset`."""
        self._read = None
        self._set("_file_name", name or "")

    def GetFileName(self):
        """For ParaView, which names the data after it."""
        return self._file_name

    def RequestInformation(self, request, inInfo, outInfo):
        with suppress(ValueError):  # RequestData says it
            ImageGeometry.of_image(self._image()).announce(outInfo.GetInformationObject(0))
        return 1

    def RequestData(self, request, inInfo, outInfo):
        vtkImageData.GetData(outInfo).ShallowCopy(self._image())
        return 1

    def _image(self):
        if self._read is None:
            try:
                self._read = along_world(io.read_dataset(self._file_name))
            except OSError as error:
                raise ValueError(f"`FileName`: {error}") from error
        return self._read
