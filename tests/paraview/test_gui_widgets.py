"""Handles and the cut plane in ParaView's views: when they are there, what clicks do to them."""

from __future__ import annotations

import time

import numpy as np
import pytest
from gui import LISTENER
from gui_fixtures import (  # noqa: F401  fixtures
    HANDLE,
    HAS_QT,
    PICTURES,
    PROJECT,
    PULL,
    SETUP,
    display,
    gui,
    noise,
    paraview,
    start,
    unavailable,
)
from test_handles import BALL, MARKS
from vtkmodules.vtkCommonCore import VTK_FLOAT
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

from vtk_mls.vtk.arrays import from_numpy

WIDGETS = """
def shown(kind):  # how many widgets of a kind are shown
    widgets = view.SMProxy.GetProperty("HiddenRepresentations")
    widgets = [widgets.GetProxy(i) for i in range(widgets.GetNumberOfProxies())]
    widgets = [each for each in widgets if kind in each.GetXMLName()]
    return sum(each.GetClientSideObject().GetWidget().GetEnabled() for each in widgets)

def both():
    return [shown("PolyLine"), shown("ImplicitPlane")]

def counts():
    names = ("RestPoints", "DeformedPoints")
    return [deform.SMProxy.GetProperty(n).GetNumberOfUncheckedElements() // 3 for n in names]

def choose_cut(kind):
    deform.SMProxy.GetProperty("CutType").SetUncheckedElement(0, kind)
"""


def begin(gui, more=""):
    gui.run(WIDGETS + more)
    gui.launch("MLS Deform")
    gui.run("deform = simple.GetActiveSource()")
    gui.press("alt+a")
    gui.until("deform.GetDataInformation().GetNumberOfPoints() > 0")


def test_handles_and_plane_come_back(gui):
    """When something else is selected and the filter again; not if they were hidden by hand."""
    begin(gui)
    gui.run("choose_cut('plane')")
    gui.until("both() == [1, 1]")
    for _ in range(2):
        gui.run("simple.SetActiveSource(wavelet)")
        gui.until("both() == [0, 0]")
        gui.run("simple.SetActiveSource(deform)")
        gui.until("both() == [1, 1]")
    with gui.dragging(HANDLE, PULL):
        gui.until("dragged(pending=True)")
    gui.screenshot("1_again")
    gui.run("simple.HideInteractiveWidgets(proxy=deform)")
    gui.until("both() == [0, 0]")
    gui.run("simple.SetActiveSource(wavelet)")
    gui.run("simple.SetActiveSource(deform)")
    time.sleep(1)
    assert gui.value("both()") == [0, 0]


@pytest.mark.matrix
def test_handles_of_a_filter_whose_slice_is_shown(gui):
    begin(gui)
    gui.run("""
cut = simple.Slice(Input=deform)
simple.Show(cut, view)
simple.Hide(deform, view)
simple.SetActiveSource(cut)""")
    gui.until("both()[0] == 0")
    gui.run("simple.SetActiveSource(deform)")
    gui.until("both()[0] == 1")
    with gui.dragging(HANDLE, PULL):
        gui.until("dragged(pending=True)")
        gui.screenshot("1_dragging")
    gui.press("alt+a")
    gui.until("dragged() and is_bent()")


@pytest.mark.matrix
def test_the_plane_is_drawn_when_it_is_chosen(gui):
    """As thin lines, which do not hide the gap of the cut."""
    begin(gui)
    gui.run("""
frames = []
view.GetRenderer().AddObserver("EndEvent", lambda *_: frames.append(both()[1]))
choose_cut("plane")""")
    gui.until("frames and frames[-1] == 1")
    gui.screenshot("1_plane")
    drawn = gui.run("""
from vtkmodules.vtkRenderingCore import vtkPropCollection
widgets = view.SMProxy.GetProperty("HiddenRepresentations")
widgets = [widgets.GetProxy(i) for i in range(widgets.GetNumberOfProxies())]
(widget,) = [each.GetClientSideObject().GetWidget() for each in widgets
             if "ImplicitPlane" in each.GetXMLName()
             and each.GetClientSideObject().GetWidget().GetEnabled()]
actors = vtkPropCollection()
widget.GetRepresentation().GetActors(actors)
actors = [actors.GetItemAsObject(i) for i in range(actors.GetNumberOfItems())]
drawn = [each.GetMapper().GetInputAlgorithm().GetClassName() for each in actors]
answer = drawn""")
    assert "vtkLineSource" in drawn  # of the normal
    assert "vtkTubeFilter" not in drawn


@pytest.mark.matrix
def test_nothing_is_left_of_handles_that_were_removed(start):
    with start() as gui:
        gui.run(SETUP)
        begin(gui, MARKS)
        gui.until("spheres() and len(spheres()[0]) == 27")
        gui.run(
            "before = [deform.SMProxy.GetProperty(n) for n in ('DeformedPoints', 'RestPoints')]"
        )
        gui.run("before[0].SetUncheckedElements([], 0); simple.Render(view)")
        gui.until("counts() == [0, 0]")
        gui.run(
            "simple.Render(view); camera = view.GetActiveCamera(); place = camera.GetPosition()"
        )
        assert gui.value("labels() == 0 and not drawn_handles()")
        with gui.dragging(HANDLE, PULL):
            gui.until("camera.GetPosition() != place")
        assert gui.value("counts()") == [0, 0]
        gui.press("ctrl+z")
        gui.until("counts() == [27, 27] and drawn_handles()")


def test_clicks_with_ctrl_and_shift(gui):
    """Add a handle on the surface, and remove it: both lists are in step."""
    gui.run(BALL)
    begin(gui)
    before = gui.value("counts()[0]")
    place = (3, 3, 82**0.5)
    gui.click_at(place, key="ctrl")
    gui.until(f"counts() == [{before + 1}] * 2")
    gui.screenshot("1_added")
    ends = gui.value(
        "[deform.SMProxy.GetProperty('RestPoints').GetUncheckedElement(i) "
        f"for i in range({3 * before}, {3 * before + 3})]"
    )
    np.testing.assert_allclose(ends, place, atol=0.3)  # of pixels, and flat faces of the ball
    gui.press("ctrl+z")
    gui.until(f"counts() == [{before}] * 2")
    gui.press("ctrl+y")
    gui.until(f"counts() == [{before + 1}] * 2")
    gui.click_at(place, key="shift")
    gui.until(f"counts() == [{before}] * 2")
    gui.click_at((0, 0, 30), key="ctrl")  # beside the ball
    with gui.dragging((-3, 3, 82**0.5), PULL, key="ctrl"):
        gui.shake(0.5)
    assert gui.value("counts()") == [before] * 2


@pytest.mark.matrix
def test_first_handles_lie_on_the_material(gui):
    """Of an image in an empty box, and of a mesh; a box that is full keeps its corners."""
    image, radius = vtkImageData(), 6
    image.SetDimensions(41, 41, 41)
    image.SetOrigin(-20, -20, -20)
    z, y, x = np.mgrid[-20:21, -20:21, -20:21]
    ball = (x**2 + y**2 + z**2 <= radius**2).astype(np.float32)
    scalars = from_numpy(ball.ravel(), VTK_FLOAT)
    scalars.SetName("ball")
    image.GetPointData().SetScalars(scalars)
    writer = vtkXMLImageDataWriter()
    writer.SetFileName(str(PROJECT / gui.folder / "ball.vti"))
    writer.SetInputData(image)
    assert writer.Write()
    begin(gui)
    assert gui.value("counts()") == [27, 27]
    assert gui.value("np.abs(np.reshape(deform.RestPoints, (-1, 3))).max()") == 10
    gui.run(BALL.replace("simple.Delete(wavelet)", "simple.Hide(wavelet, view)"))
    gui.run(f"disk = simple.OpenDataFile('{gui.folder}/ball.vti'); disk.UpdatePipeline()")
    for source, reach in (("ball", 10), ("disk", radius)):
        gui.run(f"simple.Show({source}, view); simple.SetActiveSource({source})")
        gui.launch("MLS Deform")
        gui.run("deform = simple.GetActiveSource()")
        rest = np.reshape(gui.value("list(deform.RestPoints)"), (-1, 3))
        distances = np.linalg.norm(rest, axis=1)
        assert 7 < len(rest) <= 27
        assert distances.max() <= reach + 1.01  # a voxel
        assert np.sum(distances > 0.7 * reach) > 6
        assert gui.value("list(deform.DeformedPoints) == list(deform.RestPoints)")
        gui.screenshot(source)


@pytest.mark.matrix
def test_control_points_begin_where_the_selection_is(start):
    with start() as gui:
        gui.run(SETUP + "wavelet.WholeExtent = [-3, 4, -5, 6, 7, 8]; wavelet.UpdatePipeline()")
        gui.launch("MLS Control Points")
        gui.run("source = simple.GetActiveSource()")
        box = [-3, 4, -5, 6, 7, 8]
        assert gui.value("list(source.Bounds)") == box
        corners = gui.value("np.reshape(source.RestPoints, (-1, 3)).tolist()")
        expected = {(x, y, z) for x in box[:2] for y in box[2:4] for z in box[4:]}
        assert {tuple(each) for each in corners} == expected
        assert gui.value("list(source.DeformedPoints) == list(source.RestPoints)")
        gui.run(f"simple.SaveState('{gui.folder}/state.pvsm')")
        gui.press("alt+a")
        gui.until("source.GetDataInformation().GetNumberOfPoints() == 8")

        # A file must be chosen: one sentence says so.
        gui.run("source.Mode = 'file'; simple.Render(view)")
        lines = [line for line in noise(gui) if "MLSControlPoints" in line]
        assert {line.partition("ERROR: ")[2] for line in lines} == {
            "MLSControlPoints: `FileName` must name a file with control points: choose one"
        }

        # A state has its own.
        gui.run("simple.Delete(source); simple.SetActiveSource(None); del source")
        gui.run("wavelet.WholeExtent = [0, 1, 0, 1, 0, 1]; simple.SetActiveSource(wavelet)")
        gui.run(f"simple.LoadState('{gui.folder}/state.pvsm')")
        gui.run("source = simple.FindSource('MLSControlPoints1')")
        assert gui.value("list(source.Bounds)") == box


@pytest.mark.matrix
def test_no_welcome_dialog(start, paraview, request):
    """With what `vtk-mls paraview` sets, in a home of its own."""
    project = "/project" if paraview.prefix else PROJECT
    folder = PICTURES / request.node.callspec.id / "welcome/home"
    (PROJECT / folder).mkdir(parents=True, exist_ok=True)
    command = (
        *("env", f"HOME={project}/{folder}"),
        f"XDG_CONFIG_DIRS=/etc/xdg:{project}/paraview_plugin/settings",
        *("paraview", f"--script={LISTENER}"),
    )
    with start(command=command) as gui:
        time.sleep(5)
        gui.screenshot("1_begun")
        assert len(gui.windows()) == 1
