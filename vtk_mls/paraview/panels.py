"""Panels of the proxies: their properties as XML, in the order of the work.

They are declared as XML on the class: ParaView's method decorators do not see inherited setters,
and before ParaView 5.12 the panel would list their properties in alphabetical order.
"""

from __future__ import annotations

from vtk_mls.files import formats
from vtk_mls.filters import property_tables as tables
from vtk_mls.paraview.handle_panel import HANDLES, MOUSE_HELP, draggable
from vtk_mls.paraview.property_xml import element, elements, visibility
from vtk_mls.paraview.xml import (
    bounds,
    check_box,
    data_input,
    documentation,
    input_arrays,
    vector,
    xml,
)

_CONTROL_POINTS = data_input(
    "ControlPoints",
    1,
    "vtkPointSet",
    """Control points (optional), used instead of the handles below, of any dataset with points,
    such as an Extract Selection: their positions are p, where the material is at rest; a point
    vector array holds the displacement q - p to where they were dragged.""",
    xml("Hints", xml("Optional")),
    input_arrays("vectors", "point", components=3),
    input_arrays("factors", "point", components=1),
    clean_command="DisconnectControlPoints",
)

_CUTS = data_input(
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

# The long tables of the handles stand below all of which there are few: kind and cut. ParaView
# shows the plane's widget where the first property of its group stands, which is Input: that comes
# between CutType and these.
_CUT = [
    element(tables.CUT_ORIGIN, bounds("mid")),
    element(tables.CUT_NORMAL),
    xml(
        "PropertyGroup",
        xml("Property", function="Origin", name="CutOrigin"),
        xml("Property", function="Normal", name="CutNormal"),
        xml("Property", function="Input", name="Input"),
        xml("Hints", *visibility(tables.CUT_NORMAL)),
        label="Cut Plane, as Laid",
        panel_widget="InteractivePlane",
    ),
    element(tables.CUT_INWARD),
    *elements(tables.CUT_OPTIONS),
]

_LIVE = check_box(
    "Live",
    """Whether what is shown follows while a handle or the cut is dragged, before Apply. It is off
    where the data are on another machine: there Apply shows the result. If only that machine has
    the plugin it stays on, but nothing follows. Point Gaussian, 3D Glyphs, Surface LIC, volumes of
    colors (RGB), and slices, clips and contours of the output follow at Apply.""",
    default=1,
    command="",
)

DEFORM = [
    documentation(
        """Deforms an image (a volume) or a mesh by control points that are dragged from p to q, by
        moving least squares. Arrays of an image are resampled; points of a mesh are moved by the
        exact inverse, so that both stay together. Cuts open it: the void in an image is in the
        array Void, and cells of a mesh are split along them.""",
        short_help=MOUSE_HELP,
    ),
    *elements(tables.MAP),
    element(tables.CUT_TYPE),
    data_input(
        "Input",
        0,
        "vtkDataSet",
        "The image or mesh to deform.",
        input_arrays("arrays", "any"),
        input_arrays("scalars", "point", components=1),
        input_arrays("gradients", "any", components=3),
    ),
    _CONTROL_POINTS,
    _CUTS,
    *_CUT,
    _LIVE,
    *HANDLES,
    *elements((*tables.SAMPLING, *tables.VOID, tables.OVERLAP)),
    *elements((*tables.VECTORS, *tables.JACOBIAN)),
    *elements(tables.INTERACTIVE_COMPUTING),
]

DISPLACEMENT_FIELD = [
    documentation(
        """Makes an image with the displacement G(v) - v of each of its points v, where G(v) is the
        point that the material now at v came from.""",
        short_help=MOUSE_HELP,
    ),
    *elements(tables.MAP),
    element(tables.CUT_TYPE),
    data_input(
        "Input",
        0,
        "vtkDataSet",
        "Gives the grid of the field: its own if it is an image, else one over its bounds.",
    ),
    _CONTROL_POINTS,
    _CUTS,
    *_CUT,
    *HANDLES,
    *elements((tables.INVERSE, tables.SAMPLE_DIMENSIONS, tables.OVERLAP, *tables.JACOBIAN)),
    *elements(tables.INTERACTIVE_COMPUTING),
]

_DEFORMED, _REST = tables.LISTS
_CUBE = "-1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1  -1 1 1  1 1 1  1 -1 1  -1 -1 1"

CONTROL_POINTS = [
    xml("OutputPort", name="Handles", index=0),
    xml("OutputPort", name="Arrows", index=1),
    documentation(
        "Control points for the MLS filters, from lists, as a lattice over a box, or from files.",
        short_help=MOUSE_HELP,
    ),
    element(tables.MODE),
    *elements(tables.FILES),
    xml(
        "PropertyGroup",
        *(xml("Property", name=each.name) for each in tables.FILES),
        xml("Hints", *visibility(tables.SPACE)),
        label="Files, Taken to LPS",
    ),
    *draggable(element(_DEFORMED), element(_REST, default=_CUBE)),
    *elements(tables.LATTICE),
    element(tables.WEIGHTS),
]

# Where several readers serve, ParaView asks in its GUI, and takes the first by the alphabet in
# scripts: this one's name is before those of its own.
IMAGE_READER = [
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
            extensions=formats.extensions(formats.MEDICAL),
            file_description="MLS Image Reader: medical images in LPS",
        ),
    ),
]
