"""XML of the properties of ParaView's proxies, from the tables of the filters."""

from __future__ import annotations

from functools import singledispatch

from vtk_mls.files import formats
from vtk_mls.filters import properties
from vtk_mls.paraview.xml import (
    arrays_of,
    check_box,
    choice,
    either,
    limits,
    names,
    shown_when,
    vector,
    xml,
)


def elements(table_of_properties):
    """The XML of all properties of a table, in its order."""
    return [element(each) for each in table_of_properties]


@singledispatch
def element(each, domain=""):
    """The XML of a property.

    Parameters
    ----------
    each : Property
        Of a kind that is registered below.
    domain : str
        XML of a domain that only ParaView knows.
    """
    raise TypeError(f"`{each.name}` must be of a kind that ParaView can show, got {each!r}")


def visibility(each):
    """Hints that say when a property is shown."""
    if each.shown_when:
        name, value = each.shown_when
        return [shown_when(name, "null" if value is None else value)]
    if each.hidden_when:
        hint = shown_when(*each.hidden_when, inverse=1)
        if each.shown_with:
            hint = either(hint, shown_when(each.shown_with, "null", inverse=1))
        return [hint]
    return []


@element.register
def _(each: properties.Number, domain=""):
    kind = _kind(each.default)
    return vector(kind, each.name, each.default, each.help, domain, _hints(each), **_level(each))


@element.register
def _(each: properties.Slider, domain=""):
    kind = _kind(each.default)
    ends = limits(kind, min=each.low, max=each.high)
    return vector(kind, each.name, each.default, each.help, ends, _hints(each), **_level(each))


@element.register
def _(each: properties.Vector, domain=""):
    kind, default = _kind(each.default[0]), joined(each.default)
    return vector(kind, each.name, default, each.help, domain, _hints(each), **_level(each))


@element.register
def _(each: properties.Choice, domain=""):
    return choice(each.name, each.choices, each.default, each.help, _hints(each), **_level(each))


@element.register
def _(each: properties.Flag, domain=""):
    return check_box(each.name, each.help, default=int(each.default))


@element.register
def _(each: properties.Text, domain=""):
    return vector("String", each.name, each.default, each.help, _hints(each), **_level(each))


@element.register
def _(each: properties.FileName, domain=""):
    extensions = formats.extensions(formats.POINTS)
    chooser = xml("FileChooser", extensions=extensions, file_description="Handles")
    files = xml("FileListDomain", name="files")
    return vector("String", each.name, "", each.help, files, _hints(each, chooser))


@element.register
def _(each: properties.ArrayName, domain=""):
    arrays = arrays_of("scalars", "Input", none_string="none")
    return vector("String", each.name, "none", each.help, arrays, _hints(each, xml("NoDefault")))


@element.register
def _(each: properties.ArrayNames, domain=""):
    arrays = arrays_of("gradients" if each.components == 3 else "arrays", "Input")
    return names(each.name, f"Add{each.singular}", each.help, arrays)


@element.register
def _(each: properties.Rows, domain="", default=""):
    labels = [
        xml("ComponentLabel", component=i, label=label) for i, label in enumerate(each.columns)
    ]
    return vector(
        "Double",
        each.name,
        default or "none",
        each.help,
        domain,
        xml("Hints", xml("ShowComponentLabels", *labels), *visibility(each)),
        command=f"Set{each.singular}",
        use_index=1,
        repeat_command=1,
        set_number_command=f"SetNumberOf{each.name}",
        number_of_elements=len(default.split()),
        number_of_elements_per_command=len(each.columns),
        **_level(each),
    )


def joined(numbers):
    """Numbers as XML has them."""
    return " ".join(f"{each:g}" for each in numbers)


def _kind(default):
    return "Int" if isinstance(default, int) else "Double"


def _level(each):
    return {"panel_visibility": "advanced"} if each.is_advanced else {}


def _hints(each, *hints):
    hints = [*hints, *visibility(each)]
    return xml("Hints", *hints) if hints else ""
