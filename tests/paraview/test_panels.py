"""Hints and commands of properties in ParaView's panels. Runs without ParaView."""

from xml.etree import ElementTree

import pytest

from vtk_mls.paraview import panels

PANELS = [panels.DEFORM, panels.DISPLACEMENT_FIELD, panels.CONTROL_POINTS]
FILTERS = PANELS[:2]


def elements_of(panel):
    """The elements of the properties of a panel by their names."""
    root = ElementTree.fromstring(f"<Proxy>{''.join(panel)}</Proxy>")
    found = [child for child in root if child.tag.endswith("Property")]
    assert len({child.get("name") for child in found}) == len(found)
    return {child.get("name"): child for child in found}


@pytest.mark.parametrize("panel", PANELS, ids=["deform", "field", "points"])
def test_lists_have_a_command_for_their_length(panel):
    """Otherwise ParaView can only make them longer."""
    lists = {
        name: element.get("set_number_command")
        for name, element in elements_of(panel).items()
        if element.get("use_index") == "1"
    }
    assert lists == {name: f"SetNumberOf{name}" for name in lists}
    assert {"RestPoints", "DeformedPoints", "Weights"} <= {*lists}


def test_arrays_have_no_reset_of_their_own():
    """ParaView would choose arrays by it."""
    found = elements_of(panels.DEFORM)
    assert all(found[name].get("no_custom_default") == "1" for name in panels.ARRAYS)


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


@pytest.mark.parametrize("panel", FILTERS, ids=["deform", "field"])
@pytest.mark.parametrize("name", ["Nu", "CutFrame"])
def test_properties_of_cuts_are_shown_with_any_cut(panel, name):
    (composite,) = elements_of(panel)[name].find("Hints")
    (any_of,) = composite
    assert (composite.get("type"), any_of.get("type")) == ("CompositeDecorator", "or")
    conditions = [[hint.get(key) for key in ("property", "values", "inverse")] for hint in any_of]
    assert conditions == [["CutType", "none", "1"], ["ConnectedCuts", "none", "1"]]
