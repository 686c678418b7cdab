"""The panels of ParaView show the properties of the filters; no ParaView is needed to see it."""

from xml.etree import ElementTree

import pytest

from vtk_mls.filters import properties, property_tables
from vtk_mls.paraview import panels

OF_EVERY_PANEL = {"Drag", "NumberHandles"}
OF_PANEL = OF_EVERY_PANEL | {"DisplacementArray", "WeightArray", "LatticeDimensions"}
INPUTS = {"Input", "ControlPoints", "Cuts"}


def seen(table):
    """A table with the defaults of what people look at."""
    others = {each.name: each for each in property_tables.INTERACTIVE_COMPUTING}
    return [others.get(each.name, each) for each in table]


EACH = [
    pytest.param(
        panels.DEFORM, seen(property_tables.DEFORM), OF_PANEL | INPUTS | {"Live"}, id="deform"
    ),
    pytest.param(
        panels.DISPLACEMENT_FIELD,
        seen(property_tables.DISPLACEMENT_FIELD),
        OF_PANEL | INPUTS,
        id="field",
    ),
    pytest.param(
        panels.CONTROL_POINTS, property_tables.CONTROL_POINTS, OF_EVERY_PANEL, id="points"
    ),
]


def shown(panel):
    """The elements of the properties of a panel by their names."""
    root = ElementTree.fromstring(f"<Proxy>{''.join(panel)}</Proxy>")
    found = [each for each in root if each.tag.endswith("Property")]
    assert len({each.get("name") for each in found}) == len(found)
    return {each.get("name"): each for each in found}


@pytest.mark.parametrize(("panel", "table", "others"), EACH)
def test_all_properties_are_shown_and_no_others(panel, table, others):
    in_python_alone = {each.name for each in table if isinstance(each, properties.Cuts)}
    assert {*shown(panel)} == {each.name for each in table} - in_python_alone | others


@pytest.mark.parametrize(("panel", "table", "others"), EACH)
def test_help_default_and_level_are_those_of_the_table(panel, table, others):
    found = shown(panel)
    for each in table:
        if isinstance(each, properties.Cuts):
            continue
        element = found[each.name]
        assert element.findtext("Documentation") == " ".join(each.help.split())
        assert (element.get("panel_visibility") == "advanced") == each.is_advanced
        default = element.get("default_values")
        if isinstance(each, properties.Choice):
            assert [option.get("value") for option in element.find("StringListDomain")] == [
                *each.choices
            ]
            assert default == each.default
        elif isinstance(each, (properties.Number, properties.Flag)):
            assert float(default) == each.default
        elif isinstance(each, properties.Vector):
            assert tuple(map(float, default.split())) == each.default
        elif isinstance(each, (properties.Text, properties.Items)):
            assert default in ("", "none")


@pytest.mark.parametrize(("panel", "table", "others"), EACH)
def test_lists_are_told_how_long_they_are(panel, table, others):
    """Or ParaView can make them longer only."""
    lists = {
        name: element.get("set_number_command")
        for name, element in shown(panel).items()
        if element.get("use_index") == "1"
    }
    assert lists == {name: f"SetNumberOf{name}" for name in lists}
    assert {"RestPoints", "DeformedPoints", "Weights"} <= {*lists}


def test_a_property_is_shown_while_it_counts():
    found = shown(panels.DEFORM)
    (hint,) = found["Degree"].iter("PropertyWidgetDecorator")
    assert (hint.get("property"), hint.get("value")) == ("Kind", "polynomial")
    (hint,) = found["CutOrigin"].iter("PropertyWidgetDecorator")
    assert (hint.get("property"), hint.get("inverse")) == ("CutType", "1")


@pytest.mark.parametrize(
    "panel", [panels.DEFORM, panels.DISPLACEMENT_FIELD], ids=["deform", "field"]
)
@pytest.mark.parametrize("name", ["Nu", "CutFrame"])
def test_properties_of_cuts_are_shown_with_any_cut(panel, name):
    (composite,) = shown(panel)[name].find("Hints")
    (any_of,) = composite
    assert (composite.get("type"), any_of.get("type")) == ("CompositeDecorator", "or")
    conditions = [[hint.get(key) for key in ("property", "value", "inverse")] for hint in any_of]
    assert conditions == [["CutType", "none", "1"], ["Cuts", "null", "1"]]


def test_a_kind_that_no_panel_knows_is_an_error():
    with pytest.raises(TypeError, match="`Cuts` must be of a kind that ParaView can show"):
        panels.element(property_tables.CUTS)
