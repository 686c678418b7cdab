"""Panels for lists of control points, which have handles in the view."""

from __future__ import annotations

from vtk_mls.filters import property_tables
from vtk_mls.paraview.property_xml import element, joined, visibility
from vtk_mls.paraview.xml import (
    arrays_of,
    bounds,
    check_box,
    choice,
    shown_when,
    vector,
    xml,
)
from vtk_mls.vtk.control_point_polydata import DISPLACEMENT, WEIGHT

# What the mouse does, as the panel says it above all properties.
MOUSE_HELP = """Drag a handle in the view: with Ctrl it goes along the surface under the mouse.
Ctrl+Click beside the handles adds one on that surface, Shift+Click removes one, and the key P puts
the selected one on the mesh under the mouse. The switch Show Spline below shows the handles."""

# The handles of a new filter, in steps along a box: the widget draws a line through them.
_LATTICE = [
    (x, y if x % 2 == 0 else 2 - y, z if (x + y) % 2 == 0 else 2 - z)
    for x in range(3)
    for y in range(3)
    for z in range(3)
]

_DEFORMED, _REST, _WEIGHTS = property_tables.OWN_CONTROL_POINTS
_OWN = visibility(_WEIGHTS)


def draggable(deformed, rest, *hints):
    """The two lists of handles, and which of them the mouse edits: the panel alone knows that."""
    return [
        choice(
            "Drag",
            ("deformed", "rest"),
            "deformed",
            """What dragging a handle does: deformed bends; rest moves the handle itself to another
            point of the material. It is also the one to add handles with.""",
            xml("Hints", *hints),
            command="",
        ),
        deformed,
        _widget("Handles", "DeformedPoints", shown_when("Drag", "deformed"), *hints),
        rest,
        _widget("Handles at Rest", "RestPoints", shown_when("Drag", "rest"), *hints),
        check_box(
            "NumberHandles",
            "Whether each handle has its number beside it, that of its row in the tables.",
            xml("Hints", *hints),
            command="",
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


def _over_input(each):
    """A list of handles that begins as a lattice over the bounds of the input.

    ParaView's bounds domain gives minima, centres and maxima of x, y, z in turn to a list that has
    as many elements as the domain has modes.
    """
    steps = [step for handle in _LATTICE for step in handle]
    domain = bounds(",".join(("min", "mid", "max")[step] for step in steps))
    return element(each, domain, " ".join(str(step - 1) for step in steps))


def _array(name, index, default, domain, text):
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


# Handles of a filter's own, and which arrays say the same of connected ones. These come after
# Input: a property that names another one makes it, here ControlPoints, and the menu connects what
# is selected to the input that was made first.
HANDLES = [
    *draggable(_over_input(_DEFORMED), _over_input(_REST), *_OWN),
    vector(
        "Int",
        "LatticeDimensions",
        joined(property_tables.LATTICE_DIMENSIONS.default),
        """Number of handles in each direction: a change lays them anew, at rest, as a lattice over
        the bounds of the input.""",
        xml("Hints", *_OWN),
        command="",
        panel_visibility="advanced",
    ),
    element(_WEIGHTS),
    _array(
        "DisplacementArray",
        0,
        DISPLACEMENT,
        arrays_of("vectors", "ControlPoints"),
        "Point vector array of the control points with their displacement q - p.",
    ),
    _array(
        "WeightArray",
        1,
        WEIGHT,
        arrays_of("factors", "ControlPoints"),
        """Point array of the control points with a positive factor for each; without it all count
        alike.""",
    ),
]
