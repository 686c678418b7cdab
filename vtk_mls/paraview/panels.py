"""Panels of the proxies: their properties as XML, in the order of the user's work.

They are declared as XML on the class: ParaView's method decorators do not see inherited setters,
and before ParaView 5.12 the panel would list their properties in alphabetical order.
"""

from dataclasses import replace
from itertools import product

from vtk_mls.files import formats
from vtk_mls.filters import property_tables as tables
from vtk_mls.filters.properties import ArrayNames, Value, Values
from vtk_mls.model import options
from vtk_mls.paraview.property_xml import (
    array_choice,
    bounds,
    check_box,
    choice,
    data_input,
    documentation,
    element,
    input_arrays,
    joined,
    only_for,
    shown_when,
    vector,
    visibility,
    xml,
)
from vtk_mls.vtk.control_point_polydata import DISPLACEMENT, WEIGHT

MOUSE_HELP = """Drag a handle in the view; with Ctrl it follows the surface under the mouse.
Ctrl+Click beside the handles adds a handle on that surface, Shift+Click removes a handle, and the
key P puts the selected handle on the mesh under the mouse. The switch Show Spline below shows the
handles."""

_DEFORMED, _REST, _WEIGHTS = tables.OWN_CONTROL_POINTS
_OWN = visibility(_WEIGHTS)


def _draggable(deformed, rest, *hints):
    """The two lists of handles, and the choice of the one that the mouse edits.

    Drag and NumberHandles exist in the panel only.
    """
    return [
        choice(
            "Drag",
            ("deformed", "rest"),
            "deformed",
            """What dragging a handle does: deformed bends the data; rest moves the handle to
            another point of the material. Use rest to add handles, too.""",
            xml("Hints", *hints),
            command="",
        ),
        deformed,
        _widget("Handles", "DeformedPoints", shown_when("Drag", "deformed"), *hints),
        rest,
        _widget("Handles at Rest", "RestPoints", shown_when("Drag", "rest"), *hints),
        check_box(
            "NumberHandles",
            "Whether to show beside each handle the number of its row in the tables.",
            xml("Hints", *hints),
            command="",
            panel_visibility="advanced",
        ),
    ]


def _widget(label, name, *hints):
    """The handles of a list in the view."""
    return xml(
        "PropertyGroup",
        xml("Property", function="HandlePositions", name=name),
        xml("Hints", *hints),
        label=label,
        panel_widget="InteractivePolyLine",
    )


def _lattice_over_input(prop):
    """A list of handles that starts as a lattice over the bounds of the input.

    The handles go back and forth along the axes, since the widget draws a line through them.
    ParaView's bounds domain gives minima, centers and maxima of x, y, z in turn to a list that has
    as many elements as the domain has modes.
    """
    steps = []
    for x, y, z in product(range(3), repeat=3):
        steps += [x, y if x % 2 == 0 else 2 - y, z if (x + y) % 2 == 0 else 2 - z]
    domain = bounds(",".join(("min", "mid", "max")[step] for step in steps))
    return element(prop, domain, " ".join(str(step - 1) for step in steps))


_LISTS = (prop.name for prop in tables.DEFORM if isinstance(prop, ArrayNames))
ARRAYS = "DisplacementArray", "WeightArray", *_LISTS  # ParaView guesses their defaults
# `watch` sets it to 0. Restore Defaults sets it to 1, after all others, in their order.
RESTORED = "restored"
_RESTORED = check_box(
    RESTORED,
    "Whether default values were restored.",
    default=1,
    command="",
    panel_visibility="never",
)


def _arrays_of(source):
    """The choices of the point arrays of control points on an input, without ParaView's guess."""
    displacement = "Point vector array of the control points with their displacement q - p."
    weight = """Point array of the control points with a positive factor for each; without it all
        factors are 1."""
    return [
        vector(
            "String",
            name,
            f"{index};1;0;0;{array}",  # of SetInputArrayToProcess
            text,
            array_choice(domain, source),
            xml("Hints", xml("NoDefault"), shown_when(source, "null", inverse=1)),
            default_values_delimiter=";",
            command="SetInputArrayToProcess",
            number_of_elements=5,
            element_types="0 0 0 0 2",
            animateable=0,
            no_custom_default=1,
            panel_visibility="advanced",
        )
        for index, (name, array, domain, text) in enumerate(
            (
                ("DisplacementArray", DISPLACEMENT, "vectors", displacement),
                ("WeightArray", WEIGHT, "factors", weight),
            )
        )
    ]


# A property that names another property creates it, here ControlPoints, and ParaView's menu
# connects the selection to the input that was created first: so these stand after Input.
_HANDLES = [
    *_draggable(_lattice_over_input(_DEFORMED), _lattice_over_input(_REST), *_OWN),
    vector(
        "Int",
        "LatticeDimensions",
        joined(tables.LATTICE_DIMENSIONS.default),
        """Number of handles along each axis. A change replaces the handles by a lattice over the
        bounds of the input, at rest.""",
        xml("Hints", *_OWN),
        command="",
        panel_visibility="advanced",
    ),
    element(_WEIGHTS),
    *_arrays_of("ControlPoints"),
    _RESTORED,
]

_CONTROL_POINTS = data_input(
    "ControlPoints",
    1,
    "vtkPointSet",
    """Control points (optional), used instead of the handles below: any dataset with points, for
    example an Extract Selection. Its positions are p, where the material is at rest; a point vector
    array holds the displacement q - p to where they were dragged.""",
    input_arrays("vectors", "point", components=3),
    input_arrays("factors", "point", components=1),
    hints=[],
)

_DEFORMED_CONTROL_POINTS = data_input(
    "DeformedControlPoints",
    4,
    "vtkPointSet",
    """The dataset of the input ControlPoints, moved (optional), for example by a Transform: its
    points, paired with those by their numbers, are q, instead of a displacement array. With
    HandleShapes cells, a closed surface and its Transform, which must not scale (untick Scaling in
    its panel), are a rigid region.""",
    hints=[shown_when("ControlPoints", None, inverse=1)],
)

_CUTS = data_input(
    "Cuts",
    2,
    "vtkPolyData",
    """Surfaces to cut along (optional): the polygons of each input, for example of the sources
    Plane and Disk. Each input and each connected part of it is a cut. Change Input (right click on
    the filter) connects several: the list shows the first, and a choice in it replaces that;
    Connected Cuts names all.""",
    hints=[],
    command="AddInputConnection",
    multiple_input=1,
    panel_visibility="advanced",
)

# `OptionalInputs` sets it: the list, and ParaView's hints, know of one input.
_CONNECTED_CUTS = vector(
    "String",
    "ConnectedCuts",
    "unknown",
    "The names of all inputs Cuts.",
    xml(
        "Hints",
        shown_when("ConnectedCuts", "none", inverse=1),
        shown_when("ConnectedCuts", mode="enabled_state"),  # with no value: it is for reading
    ),
    command="",
    panel_visibility="advanced",
)

_MASK = data_input(
    "Mask",
    3,
    "vtkImageData",
    """Mask (optional): an image in the deformed space whose active scalars multiply displacements,
    from 0 to 1; of integers, as of labels, what is not 0 counts as 1. Outside of it nothing moves.
    """,
    hints=[],
    panel_visibility="advanced",
)

_REFERENCE = data_input(
    "Reference",
    5,
    "vtkImageData",
    """Image whose grid the output has (optional), with its directions, for an input that is an
    image: the target of a registration.""",
    hints=only_for("images"),
    panel_visibility="advanced",
)


def _group(props, label, *hints, **attributes):
    names = (xml("Property", name=prop.name) for prop in props)
    return xml("PropertyGroup", *names, *hints, label=label, **attributes)


_TITLED, _TITLED_OF_CUTS = ("alpha", "steps"), ("nu",)


def names_in_errors(table, has_control_points):
    """Labels of the properties of a table, by the names of properties and arguments.

    `has_control_points` is whether the input ControlPoints is connected.
    """
    names = {"DeformedControlPoints": "`Deformed Control Points`"}
    for prop in table:
        option = prop.option.removesuffix("_points")  # rest, deformed
        label = prop.option.replace("_", " ").title()
        if option in _TITLED + _TITLED_OF_CUTS:
            label = options.named(option).label
        names |= dict.fromkeys((prop.name, option), f"`{label}`")
    points = ("ControlPoints", *("rest", "deformed", "weights") * bool(has_control_points))
    return names | dict.fromkeys(points, "`Control Points`")


def _titled(name):
    """The property of an option under the label of the option.

    A label of the property itself would change its name in Python.
    """
    option = options.named(name)
    return xml("PropertyGroup", xml("Property", name=option.property_name), label=option.label)


_LIMITS = [prop for prop in tables.LIMITS if not isinstance(prop, (Value, Values))]
_WHERE_IT_ACTS = [
    *map(element, _LIMITS),
    _group(_LIMITS, "Where It Acts", panel_visibility="advanced"),
]

# ParaView shows the widget of the plane where the first property of its group stands: Input, which
# comes between CutType and these properties.
_ORIGIN, _NORMAL, *_MORE = tables.CUT_FIELDS.values()
_CUT = [
    element(_ORIGIN, bounds("mid")),
    element(_NORMAL),
    xml(
        "PropertyGroup",
        xml("Property", function="Origin", name="CutOrigin"),
        xml("Property", function="Normal", name="CutNormal"),
        xml("Property", function="Input", name="Input"),
        xml("Hints", *visibility(_NORMAL)),
        label="Cut Plane",
        panel_widget="InteractivePlane",
    ),
    *map(element, (*_MORE, *tables.CUT_OPTIONS)),
    *map(_titled, _TITLED_OF_CUTS),
]

_LIVE = check_box(
    "Live",
    """Whether the views follow while a handle or the cut is dragged, before Apply. It is off when
    the data are on another machine: Apply shows the result. If only the server has the plugin, it
    stays on without effect. Point Gaussian, 3D Glyphs, Surface LIC, volumes of colors (RGB), and
    slices, clips and contours of the output follow at Apply; with an InitialTransform all do.""",
    default=1,
    command="",
    panel_visibility="advanced",
)


def _filter_panel(description, inputs, middle, *properties):
    """The panel of a filter.

    The short properties, of map and cut, come first; the long tables of the handles follow.
    `inputs` are the input Input, and others of its own.
    """
    input_property, *others = inputs
    return [
        documentation(description, short_help=MOUSE_HELP),
        *map(element, tables.MAP),
        *map(_titled, _TITLED),
        element(tables.CUT_TYPE),
        input_property,
        _CONTROL_POINTS,
        _DEFORMED_CONTROL_POINTS,
        _CUTS,
        _CONNECTED_CUTS,
        _MASK,
        *others,
        element(tables.HANDLE_SHAPES_CHOICE),
        *_CUT,
        *middle,
        *_HANDLES,
        *_WHERE_IT_ACTS,
        element(tables.INITIAL_TRANSFORM),
        *map(element, properties),
        *map(element, tables.INTERACTIVE_COMPUTING),
    ]


DEFORM = _filter_panel(
    """Deforms an image (a volume) or a mesh by control points that are dragged from p to q, with
    moving least squares. Arrays of an image are resampled; points of a mesh are moved by the exact
    inverse, so that both stay together. Cuts open the data: the array Void marks the void in an
    image, and cells of a mesh are split along the cuts.""",
    [
        data_input(
            "Input",
            0,
            "vtkDataSet",
            "The image or mesh to deform.",
            input_arrays("arrays", "any"),
            input_arrays("scalars", "point", components=1),
            input_arrays("gradients", "any", components=3),
        ),
        _REFERENCE,
    ],
    [_LIVE],
    *(prop for prop in tables.SAMPLING if prop is not tables.REFERENCE),
    *tables.VOID,
    tables.OVERLAP,
    *tables.VECTORS,
    *tables.JACOBIAN,
    *tables.CELL_QUALITY,
)

DISPLACEMENT_FIELD = _filter_panel(
    """Makes an image with the displacement G(v) - v of each of its points v, where G(v) is the
    point that the material now at v came from.""",
    [
        data_input(
            "Input",
            0,
            "vtkDataSet",
            "Gives the grid of the field: its own if it is an image, else a grid over its bounds.",
        )
    ],
    [],
    tables.INVERSE,
    tables.SAMPLE_DIMENSIONS,
    replace(tables.OVERLAP, only_for=""),  # the field is an image
    *tables.JACOBIAN,
)

LANDMARK_REPORT = [
    xml("OutputPort", name="Pairs", index=0),
    xml("OutputPort", name="Settings", index=1),
    documentation(
        """Predicts each pair of landmarks, p and q, from all others. The table Pairs has the error
        of each, outliers, and pairs whose labels look swapped; the table Settings the median error
        of each kind, alpha and smoothing that was tried, the best first.""",
        short_help="""Pairs: the error of each when it is left out, outliers, swapped labels.
        Settings: what was tried, the best first. Show the tables in a SpreadSheet View.""",
    ),
    data_input(
        "Input",
        0,
        "vtkPointSet",
        """Pairs of landmarks: control points, as of MLS Control Points. Points are p, and a point
        vector array holds q - p.""",
        input_arrays("vectors", "point", components=3),
        input_arrays("factors", "point", components=1),
    ),
    data_input(
        "DeformedControlPoints",
        1,
        "vtkPointSet",
        """The points of the input, moved (optional): paired with those by their numbers, they are
        q, instead of a displacement array.""",
        hints=[],
    ),
    *_arrays_of("Input"),
    _RESTORED,
    *map(element, tables.LANDMARK_REPORT),
]

_CUBE = "-1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1  -1 1 1  1 1 1  1 -1 1  -1 -1 1"

# The time steps of a source, for the timeline.
_TIMES = xml(
    "DoubleVectorProperty",
    xml("TimeStepsInformationHelper"),
    documentation("The times of the files."),
    name="TimestepValues",
    repeatable=1,
    information_only=1,
)

CONTROL_POINTS = [
    _TIMES,
    xml("OutputPort", name="Handles", index=0),
    xml("OutputPort", name="Arrows", index=1),
    documentation(
        "Control points for the MLS filters, from lists, as a lattice over a box, or from files.",
        short_help=MOUSE_HELP,
    ),
    element(tables.MODE),
    *map(element, tables.FILES),
    _group(tables.FILES, "Files, Converted to LPS", xml("Hints", *visibility(tables.SPACE))),
    *_draggable(element(tables.LISTS[0]), element(tables.LISTS[1], default=_CUBE)),
    *map(element, tables.LATTICE),
    element(tables.WEIGHTS),
]

# In scripts ParaView takes the first of several readers by name: this name precedes its own.
IMAGE_READER = [
    documentation(
        """Reads medical images as vtk-mls deform does: NIfTI, NRRD and MetaImage, all converted to
        LPS (x to the patient's left, y to the back, z to the head), the frame of markups, with the
        orientation and the scaling of the file, and its time steps. ParaView's own readers ignore
        these."""
    ),
    _TIMES,
    vector(
        "String",
        "FileName",
        "",
        "The file. Several files are the time steps of a series.",
        xml("FileListDomain", name="files"),
        command="AddFileName",
        clean_command="ClearFileNames",
        repeat_command=1,
    ),
    xml(
        "Hints",
        xml(
            "ReaderFactory",
            extensions=formats.extensions(formats.MEDICAL),
            file_description="MLS Image Reader: medical images in LPS",
        ),
    ),
]
