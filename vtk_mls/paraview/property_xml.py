"""XML of the properties of ParaView's proxies, from the property tables of the filters."""

from functools import singledispatch
from xml.sax.saxutils import escape, quoteattr

from vtk_mls.files import formats
from vtk_mls.filters import properties


def xml(tag, *children, **attributes):
    """An XML element; `children` are XML strings."""
    pairs = "".join(f" {name}={quoteattr(str(value))}" for name, value in attributes.items())
    return f"<{tag}{pairs}>{''.join(children)}</{tag}>"


def documentation(text, **short_texts):
    """The tooltip of a property, or the help page of a proxy."""
    short_texts = {name: " ".join(short.split()) for name, short in short_texts.items()}
    return xml("Documentation", escape(" ".join(text.split())), **short_texts)


def vector(kind, name, default, text, *children, **attributes):
    """A property with the setter Set<name>; `kind` is "Int", "Double" or "String".

    With an empty `command` only the panel has the property.
    """
    default = str(default)
    settings = {
        "name": name,
        "command": f"Set{name}",
        "number_of_elements": 1 if kind == "String" else len(default.split()),
        "default_values": default,
    }
    settings.update(attributes)
    if not settings["command"]:
        del settings["command"]
        settings["animateable"] = 0
    return xml(f"{kind}VectorProperty", documentation(text), *children, **settings)


def choice(name, options, default, text, *children, **attributes):
    """A string property shown as a drop-down list."""
    return vector("String", name, default, text, _options(options), *children, **attributes)


def check_box(name, text, *children, default=0, **attributes):
    """A property that is on or off."""
    return vector("Int", name, default, text, _BOOLEAN, *children, **attributes)


def _options(options):
    strings = (xml("String", value=option) for option in options)
    return xml("StringListDomain", *strings, name="options")


_BOOLEAN = xml("BooleanDomain", name="bool")


def data_input(name, port, data_type, text, *children, hints=None, **attributes):
    """An input port for one dataset; a vtkDataSet may come in blocks.

    An optional input has a list `hints`. The panel shows a list of all datasets that it accepts,
    and the filter has a method Disconnect<name> for the entry "(none)".
    """
    settings = {"command": "SetInputConnection"}
    if hints is not None:
        settings["clean_command"] = f"Disconnect{name}"
        settings |= {"panel_widget": "input_selector", "panel_visibility": "default"}
        children = xml("Hints", xml("Optional"), *hints), *children
    settings.update(attributes)
    groups = (xml("Group", name=group) for group in ("sources", "filters"))
    return xml(
        "InputProperty",
        xml("ProxyGroupDomain", *groups, name="groups"),
        xml(
            "DataTypeDomain",
            xml("DataType", value=data_type),
            name="input_type",
            composite_data_supported=int(data_type == "vtkDataSet"),
        ),
        *children,
        documentation(text),
        name=name,
        port_index=port,
        **settings,
    )


def input_arrays(name, association, components=0):
    """A named set of arrays of an input; 0 components are any number."""
    return xml(
        "InputArrayDomain",
        name=name,
        attribute_type=association,
        number_of_components=components,
        optional=1,
    )


def array_choice(name, input_name, **attributes):
    """The domain of a property whose values are names of an `input_arrays` set."""
    return xml(
        "ArrayListDomain",
        xml("RequiredProperties", xml("Property", name=input_name, function="Input")),
        name="arrays",
        input_domain_name=name,
        **attributes,
    )


def bounds(modes):
    """The domain of positions that start at minima, centers or maxima of the input's bounds."""
    return xml(
        "BoundsDomain",
        xml("RequiredProperties", xml("Property", name="Input", function="Input")),
        name="bounds",
        mode="normal",
        default_mode=modes,
    )


def shown_when(name, *values, **options):
    """A hint: show a property only while the property `name` has one of these values.

    The value of an input that is not connected is None.
    """
    values = " ".join("null" if value is None else value for value in values)
    decorator = {"type": "GenericDecorator", "mode": "visibility", "property": name} | options
    return xml("PropertyWidgetDecorator", **decorator, values=values)


def only_for(data):
    """The hints that show a property only if the input is of this kind: "images" or "meshes"."""
    if not data:
        return []
    kind = {"type": "InputDataTypeDecorator", "mode": "visibility", "name": "vtkImageData"}
    return [xml("PropertyWidgetDecorator", **kind, exclude=int(data == "meshes"))]


def visibility(prop):
    """The hints for the conditions under which a property is shown."""
    hints = []
    if prop.shown_when:
        hints = [shown_when(*prop.shown_when)]
    elif prop.hidden_when:
        hints = [shown_when(*prop.hidden_when, inverse=1)]
        if prop.shown_with:
            hints.append(shown_when(f"Connected{prop.shown_with}", "none", inverse=1))
    if len(hints) > 1:
        any_of = xml("Expression", *hints, type="or")
        hints = [xml("PropertyWidgetDecorator", any_of, type="CompositeDecorator")]
    return [*hints, *only_for(prop.only_for)]


def joined(values):
    """Numbers as an XML attribute."""
    return " ".join(f"{value:g}" for value in values)


@singledispatch
def element(prop, domain="", default=""):
    """The XML of a property.

    `domain` is the XML of a domain that only ParaView has, `default` that of a list.
    """
    raise TypeError(f"`{prop.name}` must be of a kind that ParaView can show, got {prop!r}")


@element.register
def _(prop: properties.Number):
    return _numeric(prop, [prop.default])


@element.register
def _(prop: properties.Slider):
    limits = xml(f"{_kind(prop.default)}RangeDomain", name="range", min=prop.low, max=prop.high)
    return _numeric(prop, [prop.default], limits)


@element.register
def _(prop: properties.Vector, domain=""):
    labels = [_component_labels(prop.labels)] if len(prop.labels) > 3 else []
    return _numeric(prop, prop.default, domain, hints=labels)


@element.register
def _(prop: properties.Choice):
    return _vector("String", prop, prop.default, _options(prop.choices))


@element.register
def _(prop: properties.Flag):
    return _vector("Int", prop, int(prop.default or prop.is_on_in_paraview), _BOOLEAN)


@element.register
def _(prop: properties.Text):
    return _vector("String", prop, prop.default)


@element.register
def _(prop: properties.FileName):
    is_transform = isinstance(prop, properties.TransformFile)
    label, contents = ("Transforms", formats.FIELD) if is_transform else ("Handles", formats.POINTS)
    chooser = xml("FileChooser", extensions=formats.extensions(contents), file_description=label)
    return _vector("String", prop, "", xml("FileListDomain", name="files"), hints=[chooser])


@element.register
def _(prop: properties.ArrayName):
    arrays = array_choice("scalars", "Input", none_string="none")
    return _vector("String", prop, "none", arrays, hints=[xml("NoDefault")])


@element.register
def _(prop: properties.ArrayNames):
    return _vector(
        "String",
        prop,
        "none",
        array_choice("gradients" if prop.components == 3 else "arrays", "Input"),
        hints=[xml("NoDefault")],
        command=f"Add{prop.singular}",
        clean_command=f"Clear{prop.name}",
        animateable=0,
        no_custom_default=1,
        repeat_command=1,
        number_of_elements=0,
        number_of_elements_per_command=1,
    )


@element.register
def _(prop: properties.Rows, domain="", default=""):
    return _vector(
        "Double",
        prop,
        default or "none",
        domain,
        hints=[_component_labels(prop.columns)],
        animateable=0,  # ParaView's window would make key frames of a single number
        command=f"Set{prop.singular}",
        use_index=1,
        repeat_command=1,
        set_number_command=f"SetNumberOf{prop.name}",
        number_of_elements=len(default.split()),
        number_of_elements_per_command=len(prop.columns),
    )


def _numeric(prop, default, domain="", hints=()):
    return _vector(_kind(default[0]), prop, joined(default), domain, hints=hints)


def _vector(kind, prop, default, *children, hints=(), **attributes):
    """A property with name, help, level and visibility of `prop`."""
    hints = [*hints, *visibility(prop)]
    children = [*children, xml("Hints", *hints)] if hints else children
    level = {"panel_visibility": "advanced"} if prop.is_advanced else {}
    return vector(kind, prop.name, default, prop.help, *children, **attributes, **level)


def _component_labels(names):
    labels = (xml("ComponentLabel", component=i, label=name) for i, name in enumerate(names))
    return xml("ShowComponentLabels", *labels)


def _kind(default):
    return "Int" if isinstance(default, int) else "Double"
