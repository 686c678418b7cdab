"""Properties of ParaView's proxies, as XML."""

from __future__ import annotations

from xml.sax.saxutils import escape, quoteattr


def xml(tag, *children, **attributes):
    """An XML element; `children` are XML already."""
    pairs = "".join(f" {name}={quoteattr(str(value))}" for name, value in attributes.items())
    return f"<{tag}{pairs}>{''.join(children)}</{tag}>"


def documentation(text, **helps):
    """The tooltip of a property or the help page of a proxy; `helps` are shorter texts of these."""
    helps = {name: " ".join(help.split()) for name, help in helps.items()}
    return xml("Documentation", escape(" ".join(text.split())), **helps)


def vector(kind, name, default, text, *children, **attributes):
    """A property with the setter Set<name>; `kind` is "Int", "Double" or "String"."""
    default = str(default)
    settings = {
        "name": name,
        "command": f"Set{name}",
        "number_of_elements": 1 if kind == "String" else len(default.split()),
        "default_values": default,
    }
    settings.update(attributes)
    if not settings["command"]:  # for the panel only
        del settings["command"]
    return xml(f"{kind}VectorProperty", documentation(text), *children, **settings)


def choice(name, options, default, text, *children, **attributes):
    """A string property shown as a drop-down list."""
    strings = (xml("String", value=option) for option in options)
    domain = xml("StringListDomain", *strings, name="options")
    return vector("String", name, default, text, domain, *children, **attributes)


def limits(kind, **bounds):
    """The range of a number, for the slider."""
    return xml(f"{kind}RangeDomain", name="range", **bounds)


def bounds(modes):
    """The domain of positions that begin at minima, centres or maxima of the input's bounds."""
    return xml(
        "BoundsDomain",
        xml("RequiredProperties", xml("Property", name="Input", function="Input")),
        name="bounds",
        mode="normal",
        default_mode=modes,
    )


def shown_when(name, value, **options):
    """A hint: show a property only while the property `name` has that value."""
    decorator = {"type": "GenericDecorator", "mode": "visibility", "property": name, "value": value}
    return xml("PropertyWidgetDecorator", **decorator, **options)


def either(*hints):
    """A hint: show a property while one of some hints says so."""
    any_of = xml("Expression", *hints, type="or")
    return xml("PropertyWidgetDecorator", any_of, type="CompositeDecorator")


def check_box(name, text, *children, default=0, **attributes):
    """A property that is on or off."""
    domain = xml("BooleanDomain", name="bool")
    return vector("Int", name, default, text, domain, *children, **attributes)


def names(name, setter, text, domain):
    """A list of array names; methods <setter>(one) and Clear<name>()."""
    return vector(
        "String",
        name,
        "none",
        text,
        domain,
        xml("Hints", xml("NoDefault")),
        command=setter,
        clean_command=f"Clear{name}",
        repeat_command=1,
        number_of_elements=0,
        number_of_elements_per_command=1,
    )


def data_input(name, port, data_type, text, *children, **attributes):
    """An input port for one dataset, whatever arrays it has; a vtkDataSet may come in blocks."""
    settings = {"command": "SetInputConnection", **attributes}
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


def arrays_of(name, input_name, **attributes):
    """The domain of a property that chooses among such a set of arrays."""
    source = xml("Property", name=input_name, function="Input")
    return xml(
        "ArrayListDomain",
        xml("RequiredProperties", source),
        name="arrays",
        input_domain_name=name,
        **attributes,
    )
