"""Commands of properties in ParaView's panels. Runs without ParaView."""

from xml.etree import ElementTree

import pytest

from vtk_mls.paraview import panels

PANELS = [panels.DEFORM, panels.DISPLACEMENT_FIELD, panels.CONTROL_POINTS]


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
