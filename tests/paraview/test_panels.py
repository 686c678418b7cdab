"""ParaView's panels have the properties of the filters. Runs without ParaView."""

from xml.etree import ElementTree

import pytest

from vtk_mls.filters import properties, property_tables
from vtk_mls.paraview import panels

IN_EVERY_PANEL = {"Drag", "NumberHandles"}
IN_FILTER_PANELS = IN_EVERY_PANEL | {
    *("DisplacementArray", "WeightArray", "LatticeDimensions"),
    "HasCuts",
    panels.RESTORED,
}
INPUTS = {"Input", "ControlPoints", "DeformedControlPoints", "Cuts", "Mask"}


def interactive(table):
    """A table with the defaults for interactive use."""
    others = {prop.name: prop for prop in property_tables.INTERACTIVE_COMPUTING}
    return [others.get(prop.name, prop) for prop in table]


PANELS = [
    pytest.param(
        panels.DEFORM,
        interactive(property_tables.DEFORM),
        IN_FILTER_PANELS | INPUTS | {"Live", "Reference"},
        id="deform",
    ),
    pytest.param(
        panels.DISPLACEMENT_FIELD,
        interactive(property_tables.DISPLACEMENT_FIELD),
        IN_FILTER_PANELS | INPUTS,
        id="field",
    ),
    pytest.param(
        panels.CONTROL_POINTS,
        property_tables.CONTROL_POINTS,
        IN_EVERY_PANEL | {"TimestepValues"},
        id="points",
    ),
]


def elements_of(panel):
    """The elements of the properties of a panel by their names."""
    root = ElementTree.fromstring(f"<Proxy>{''.join(panel)}</Proxy>")
    found = [child for child in root if child.tag.endswith("Property")]
    assert len({child.get("name") for child in found}) == len(found)
    return {child.get("name"): child for child in found}


@pytest.mark.parametrize(("panel", "table", "others"), PANELS)
def test_all_properties_are_shown_and_no_others(panel, table, others):
    only_in_python = {
        prop.name for prop in table if isinstance(prop, (properties.Value, properties.Values))
    }
    assert {*elements_of(panel)} == {prop.name for prop in table} - only_in_python | others


@pytest.mark.parametrize(("panel", "table", "others"), PANELS)
def test_help_default_and_level_are_those_of_the_table(panel, table, others):
    found = elements_of(panel)
    for prop in table:
        if isinstance(prop, (properties.Value, properties.Values)):
            continue
        element = found[prop.name]
        assert element.findtext("Documentation") == " ".join(prop.help.split())
        assert (element.get("panel_visibility") == "advanced") == prop.is_advanced
        default = element.get("default_values")
        if isinstance(prop, properties.Choice):
            assert [option.get("value") for option in element.find("StringListDomain")] == [
                *prop.choices
            ]
            assert default == prop.default
        elif isinstance(prop, properties.Flag):
            assert int(default) == (prop.default or prop.is_on_in_paraview)
        elif isinstance(prop, properties.Number):
            assert float(default) == prop.default
        elif isinstance(prop, properties.Vector):
            assert tuple(map(float, default.split())) == prop.default
        elif isinstance(prop, (properties.Text, properties.Items)):
            assert default in ("", "none")


@pytest.mark.parametrize(("panel", "table", "others"), PANELS)
def test_lists_have_a_command_for_their_length(panel, table, others):
    """Otherwise ParaView can only make them longer."""
    lists = {
        name: element.get("set_number_command")
        for name, element in elements_of(panel).items()
        if element.get("use_index") == "1"
    }
    assert lists == {name: f"SetNumberOf{name}" for name in lists}
    assert {"RestPoints", "DeformedPoints", "Weights"} <= {*lists}


def test_a_property_is_shown_while_it_has_an_effect():
    found = elements_of(panels.DEFORM)
    (hint,) = found["Degree"].iter("PropertyWidgetDecorator")
    assert (hint.get("property"), hint.get("values")) == ("Kind", "polynomial")
    (hint,) = found["CutOrigin"].iter("PropertyWidgetDecorator")
    assert (hint.get("property"), hint.get("inverse")) == ("CutType", "1")
    for name, is_excluded in (
        ("Background", "0"),
        ("Reference", "0"),
        ("GenerateCellQuality", "1"),
    ):
        (hint,) = found[name].iter("PropertyWidgetDecorator")
        assert (hint.get("type"), hint.get("exclude")) == ("InputDataTypeDecorator", is_excluded)


@pytest.mark.parametrize(
    "panel", [panels.DEFORM, panels.DISPLACEMENT_FIELD], ids=["deform", "field"]
)
@pytest.mark.parametrize("name", ["Nu", "CutFrame"])
def test_properties_of_cuts_are_shown_with_any_cut(panel, name):
    (composite,) = elements_of(panel)[name].find("Hints")
    (any_of,) = composite
    assert (composite.get("type"), any_of.get("type")) == ("CompositeDecorator", "or")
    conditions = [[hint.get(key) for key in ("property", "values", "inverse")] for hint in any_of]
    assert conditions == [["CutType", "none", "1"], ["HasCuts", "1", None]]
