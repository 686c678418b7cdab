"""Commands of properties in ParaView's panels. Runs without ParaView."""

from xml.etree import ElementTree

import pytest

from vtk_mls.paraview import panels

PANELS = [panels.DEFORM, panels.DISPLACEMENT_FIELD, panels.CONTROL_POINTS]


@pytest.mark.parametrize("panel", PANELS, ids=["deform", "field", "points"])
def test_lists_have_a_command_for_their_length(panel):
    """Otherwise ParaView can only make them longer."""
    root = ElementTree.fromstring(f"<Proxy>{''.join(panel)}</Proxy>")
    elements = [child for child in root if child.tag.endswith("Property")]
    assert len({element.get("name") for element in elements}) == len(elements)
    lists = {
        element.get("name"): element.get("set_number_command")
        for element in elements
        if element.get("use_index") == "1"
    }
    assert lists == {name: f"SetNumberOf{name}" for name in lists}
    assert {"RestPoints", "DeformedPoints", "Weights"} <= {*lists}
