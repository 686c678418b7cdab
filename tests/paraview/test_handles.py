"""How handles look in ParaView, and how they are dragged along a surface, in each there is."""

from __future__ import annotations

import pytest
from gui_fixtures import HANDLE, PULL, display, gui, noise, paraview, start  # noqa: F401  fixtures

MARKS = """
from vtkmodules.vtkRenderingCore import vtkGlyph3DMapper

def spheres():  # colors and diameters of handles
    for prop in (props.GetItemAsObject(i) for i in range(props.GetNumberOfItems())):
        mapper = prop.IsA("vtkActor") and prop.GetMapper()
        if mapper and mapper.IsA("vtkGlyph3DMapper") and prop.GetVisibility():
            data = mapper.GetInput().GetPointData()
            if data.GetScalars() is None:
                return None
            return vtk_to_numpy(data.GetScalars()), vtk_to_numpy(data.GetArray("Diameter"))

props = view.GetRenderer().GetViewProps()

def looks():  # numbers of handles in each color
    found = {}
    for number, color in enumerate(spheres()[0].tolist()):
        found.setdefault(tuple(color), []).append(number)
    return sorted(found.values(), key=len)

def largest():
    diameters = spheres()[1]
    return np.flatnonzero(diameters > 1.4 * np.median(diameters)).tolist()

def drawn_handles():
    return bool(spheres()) and len(spheres()[0]) > 0

def labels():  # how many are shown
    for prop in (props.GetItemAsObject(i) for i in range(props.GetNumberOfItems())):
        mapper = prop.IsA("vtkActor2D") and prop.GetMapper()
        if mapper and mapper.IsA("vtkLabeledDataMapper"):
            return mapper.GetNumberOfLabels() if prop.GetVisibility() else 0
"""
BALL = """
simple.Delete(wavelet)
ball = simple.Sphere(Radius=10, ThetaResolution=90, PhiResolution=90)
ball.UpdatePipeline()
simple.Show(ball, view)
view.ResetCamera()
simple.SetActiveSource(ball)
simple.Render(view)
"""
PENDING = """
from vtkmodules.vtkRenderingCore import vtkCoordinate

def held():  # where the handle is that was dragged last
    widgets = view.SMProxy.GetProperty("HiddenRepresentations")
    widgets = [widgets.GetProxy(i) for i in range(widgets.GetNumberOfProxies())]
    (widget,) = [each.GetClientSideObject().GetWidget() for each in widgets
                 if each.GetXMLName() == "PolyLineWidgetRepresentation"
                 and each.GetClientSideObject().GetWidget().GetEnabled()]
    shown = widget.GetRepresentation()
    number = shown.GetCurrentHandleIndex()
    moved = deform.SMProxy.GetProperty("DeformedPoints")
    place = [moved.GetUncheckedElement(3 * number + i) for i in range(3)]
    assert np.allclose(place, shown.GetHandlePositions().GetTuple(number))
    return np.array(place)

def off_the_mouse():  # pixels
    coordinate = vtkCoordinate()
    coordinate.SetCoordinateSystemToWorld()
    coordinate.SetValue(*held())
    seen = coordinate.GetComputedDisplayValue(view.GetRenderer())
    return float(np.abs(np.array(seen) - view.GetInteractor().GetEventPosition()).max())
"""


@pytest.mark.matrix
def test_what_was_dragged_is_seen(gui):
    gui.run(MARKS)
    gui.launch("MLS Deform")
    gui.run("deform = simple.GetActiveSource()")
    gui.press("alt+a")
    gui.until("is_straight()")
    assert gui.value("[[len(each) for each in looks()], largest()]") == [[27], []]
    for place in (HANDLE, (10, -10, 0)):
        with gui.dragging(place, PULL):
            gui.until("dragged(pending=True)")
    gui.until("len(dragged(pending=True)) == 2")
    assert gui.value("sorted(sum(looks()[:-1], [])) == dragged(pending=True)")
    last = "(np.reshape(deform.RestPoints, (-1, 3)) == [10, -10, 0]).all(axis=1)"
    assert gui.value(f"largest() == np.flatnonzero({last}).tolist()")
    assert gui.value("labels()") == 0
    gui.run("deform.SMProxy.GetProperty('NumberHandles').SetUncheckedElement(0, 1)")
    gui.until("labels() == 27")
    gui.screenshot("1_numbers")
    gui.run("deform.SMProxy.GetProperty('NumberHandles').SetUncheckedElement(0, 0)")
    gui.until("labels() == 0")
    gui.press("ctrl+z", "ctrl+z")
    gui.until("dragged(pending=True) == []")
    assert gui.value("len(looks()[-1])") >= 26


def test_a_drag_along_a_mesh(gui):
    gui.run(BALL + PENDING)
    gui.launch("MLS Deform")
    gui.run("deform = simple.GetActiveSource()")
    gui.press("alt+a")
    gui.until("deform.GetDataInformation().GetNumberOfPoints() > 0")
    front = (0, 0, 10)
    with gui.dragging(front, PULL, key="ctrl"):
        gui.until("dragged(pending=True)")
        gui.screenshot("1_dragging")
        assert gui.value("np.linalg.norm(held())") == pytest.approx(10, abs=0.02)
        assert gui.value("held()[2]") < 9.8
        assert gui.value("off_the_mouse()") < 8  # it was taken hold of beside its middle
    gui.press("ctrl+z")
    gui.until("dragged(pending=True) == []")
    with gui.dragging(front, PULL):
        gui.until("dragged(pending=True)")
        assert gui.value("held()[2]") == pytest.approx(10, abs=0.05)  # in the plane of the view


@pytest.mark.matrix
def test_a_drag_along_a_volume(gui):
    """Also along one that is drawn bent before Apply."""
    gui.run(PENDING)
    gui.run("""
simple.ColorBy(simple.GetDisplayProperties(wavelet, view), ("POINTS", "RTData"))
simple.GetDisplayProperties(wavelet, view).SetRepresentationType("Volume")
simple.Render(view)
""")
    gui.launch("MLS Deform")
    gui.run("deform = simple.GetActiveSource()")
    for place, count in (((0, 0, 10), 1), ((10, 0, 10), 2)):
        with gui.dragging(place, (-60, 50), key="ctrl"):
            gui.until(f"len(dragged(pending=True)) == {count}")
            gui.screenshot(f"{count}_dragging")
            assert gui.value("off_the_mouse()") < 8
            assert 0 < gui.value("held()[2]") < 9.9


MANY = """
places = np.array(np.meshgrid(*[np.linspace(-10, 10, 6)] * 3)).reshape(3, -1).T
for name in ("RestPoints", "DeformedPoints"):
    setattr(deform, name, places.ravel().tolist())
deform.UpdatePipeline()
simple.Render(view)
pushes, told = [], deform.SMProxy.GetProperty("DeformedPoints")
told.AddObserver("UncheckedPropertyModifiedEvent", lambda *_: pushes.append(1), -1.0)

def widget():  # what ParaView knows of the handles
    shown = view.SMProxy.GetProperty("HiddenRepresentations")
    shown = [shown.GetProxy(i) for i in range(shown.GetNumberOfProxies())]
    lists = [each.GetProperty("HandlePositions") for each in shown
             if each.GetXMLName() == "PolyLineWidgetRepresentation"]
    return [[each.GetElement(i) for i in range(each.GetNumberOfElements())] for each in lists]

def unchecked():
    return [told.GetUncheckedElement(i) for i in range(told.GetNumberOfUncheckedElements())]
"""


@pytest.mark.matrix
def test_many_handles_are_told_to_paraview_once_a_drag(gui):
    """As it sets each of them by itself, a move of one of 500 took it seconds."""
    gui.run(MARKS)
    gui.launch("MLS Deform")
    gui.run("deform = simple.GetActiveSource()")
    gui.press("alt+a")
    gui.until("is_straight()")
    gui.run(MANY)
    with gui.dragging((10, 10, 10), PULL):
        gui.until("dragged(pending=True)")
        gui.shake(0.5)
        assert gui.value("len(pushes)") == 0
        assert gui.value("len(looks()[0])") == 1
        gui.screenshot("1_dragging")
    gui.until("pushes")
    assert gui.value("len(dragged(pending=True))") == 1
    assert gui.value("unchecked() in widget()")
    gui.press("ctrl+z")
    gui.until("dragged(pending=True) == []")
    assert gui.value("unchecked() in widget()")
    gui.press("ctrl+y", "alt+a")
    gui.until("len(dragged()) == 1")
    gui.until("is_bent()")


@pytest.mark.matrix
def test_an_announcement_is_no_error(gui):
    gui.run("""
import sys
from vtkmodules.vtkCommonCore import vtkOutputWindow
from vtk_mls.base.messages import inform
heard = []
for event in ("ErrorEvent", "WarningEvent"):
    vtkOutputWindow.GetInstance().AddObserver(event, lambda window, event: heard.append(event))
inform("A device is tested ...")
""")
    assert gui.value("heard") == []
    assert "A device is tested ..." in gui.printed
    gui.run("sys.stderr.write('what the window shows in red\\\\n')")
    gui.until("heard")
