"""Markers of handles, and drags along a surface, in ParaView's GUI."""

from __future__ import annotations

import pytest
from gui_scenes import AS_VOLUME, BALL, HANDLE, PULL


@pytest.mark.matrix
def test_markers_show_drags_selection_and_numbers(gui):
    gui.add_deform()
    assert gui.value("[[len(group) for group in marker_groups()], large_markers()]") == [[27], []]
    for place in (HANDLE, (10, -10, 0)):
        with gui.dragging(place, PULL):
            gui.until("dragged()")
    gui.until("len(dragged()) == 2")
    assert gui.value("sorted(sum(marker_groups()[:-1], [])) == dragged()")
    last = "(np.reshape(deform.RestPoints, (-1, 3)) == [10, -10, 0]).all(axis=1)"
    assert gui.value(f"large_markers() == np.flatnonzero({last}).tolist()")
    assert gui.value("label_count()") == 0
    gui.run("edit('NumberHandles', [1])")
    gui.until("label_count() == 27")
    gui.screenshot("1_numbers")
    gui.run("edit('NumberHandles', [0])")
    gui.until("label_count() == 0")
    gui.press("ctrl+z", "ctrl+z")
    gui.until("dragged() == []")
    assert gui.value("len(marker_groups()[-1])") >= 26


def test_a_drag_along_a_mesh(gui):
    gui.run(BALL)
    gui.add_deform()
    front = (0, 0, 10)
    with gui.dragging(front, PULL, key="ctrl"):
        gui.until("dragged()")
        gui.screenshot("1_dragging")
        assert gui.value("np.linalg.norm(held_handle())") == pytest.approx(10, abs=0.02)
        assert gui.value("held_handle()[2]") < 9.8
        assert gui.value("distance_to_mouse()") < 8  # it was picked beside its center
    gui.press("ctrl+z")
    gui.until("dragged() == []")
    with gui.dragging(front, PULL):
        gui.until("dragged()")
        assert gui.value("held_handle()[2]") == pytest.approx(
            10, abs=0.05
        )  # in the plane of the view


@pytest.mark.matrix
def test_a_drag_along_a_volume(gui):
    """Also along a volume that is drawn deformed before Apply."""
    gui.run(AS_VOLUME)
    gui.add_deform(apply=False)
    for place, count in (((0, 0, 10), 1), ((10, 0, 10), 2)):
        with gui.dragging(place, (-60, 50), key="ctrl"):
            gui.until(f"len(dragged()) == {count}")
            gui.screenshot(f"{count}_dragging")
            assert gui.value("distance_to_mouse()") < 8
            assert 0 < gui.value("held_handle()[2]") < 9.9


MANY = """
places = np.array(np.meshgrid(*[np.linspace(-10, 10, 6)] * 3)).reshape(3, -1).T
for name in ("RestPoints", "DeformedPoints"):
    setattr(deform, name, places.ravel().tolist())
deform.UpdatePipeline()
simple.Render(view)
events, prop = [], deform.SMProxy.GetProperty("DeformedPoints")
prop.AddObserver("UncheckedPropertyModifiedEvent", lambda *_: events.append(1), -1.0)

def is_shown_by_widget():  # whether ParaView's widget has the pending positions
    lists = [proxy.GetProperty("HandlePositions") for proxy in widget_proxies("PolyLineWidget")]
    lists = [[item.GetElement(i) for i in range(item.GetNumberOfElements())] for item in lists]
    return pending("DeformedPoints") in lists
"""


@pytest.mark.matrix
def test_paraview_gets_a_drag_of_many_handles_once(gui):
    """It sets handles one by one, which took seconds with 500."""
    gui.add_deform()
    gui.run(MANY)
    with gui.dragging((10, 10, 10), PULL):
        gui.until("dragged()")
        gui.shake(0.5)
        assert gui.value("len(events)") == 0
        assert gui.value("len(marker_groups()[0])") == 1
        gui.screenshot("1_dragging")
    gui.until("events")
    assert gui.value("len(dragged())") == 1
    assert gui.value("is_shown_by_widget()")
    gui.press("ctrl+z")
    gui.until("dragged() == []")
    assert gui.value("is_shown_by_widget()")
    gui.press("ctrl+y", "alt+a")
    gui.until("len(applied_drags()) == 1")
    gui.until("is_bent()")


@pytest.mark.matrix
def test_an_announcement_is_no_error(gui):
    gui.run("""
import sys
from vtkmodules.vtkCommonCore import vtkOutputWindow
from vtk_mls.base.messages import inform
events = []
for event in ("ErrorEvent", "WarningEvent"):
    vtkOutputWindow.GetInstance().AddObserver(event, lambda window, event: events.append(event))
inform("A device is tested ...")
""")
    assert gui.value("events") == []
    assert "A device is tested ..." in gui.printed
    gui.run("sys.stderr.write('text in red\\\\n')")
    gui.until("events")
