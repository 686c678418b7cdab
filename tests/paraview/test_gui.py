"""What a user does in ParaView's GUI, by real keys and mouse events, in each ParaView there is.

`make test` runs what most depends on; the finer points are for `make matrix`.
"""

from __future__ import annotations

import pytest
from gui_fixtures import (  # noqa: F401  fixtures
    HANDLE,
    PROJECT,
    PULL,
    SETUP,
    display,
    gui,
    noise,
    paraview,
    start,
)

ARROWS = """
from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

def actors(seen):  # of arrows, and whether a widget shows its handles
    renderers = seen.GetRenderWindow().GetRenderers()
    for renderer in (renderers.GetItemAsObject(i) for i in range(renderers.GetNumberOfItems())):
        props = renderer.GetViewProps()
        for prop in (props.GetItemAsObject(i) for i in range(props.GetNumberOfItems())):
            data = prop.IsA("vtkActor") and prop.GetMapper() and prop.GetMapper().GetInput()
            if data and data.GetPointData().HasArray("Displacement"):
                yield prop

def arrows(seen=view):  # bounds of what they cover
    return [list(actor.GetMapper().GetInput().GetBounds()) for actor in actors(seen)]

def widgets(seen=view):  # how many of handles are shown
    shown = seen.SMProxy.GetProperty("HiddenRepresentations")
    shown = [shown.GetProxy(i) for i in range(shown.GetNumberOfProxies())]
    shown = [each for each in shown if each.GetXMLName() == "PolyLineWidgetRepresentation"]
    return sum(each.GetClientSideObject().GetWidget().GetEnabled() for each in shown)

def amber():  # pixels of their colour in the view
    shot = vtkWindowToImageFilter()
    shot.SetInput(view.GetRenderWindow())
    shot.ReadFrontBufferOff()
    shot.Update()
    red, green, blue = vtk_to_numpy(shot.GetOutput().GetPointData().GetScalars()).T.astype(int)
    return int(((red > 100) & (blue < red // 5) & (abs(3 * green - 2 * red) < red // 4)).sum())
"""

REPLAY = """
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
deform = FindSource("MLSDeform1")
UpdatePipeline(proxy=deform)
output = deform.SMProxy.GetClientSideObject().GetOutputDataObject(0)
bent = np.load("{folder}/bent.npy")
np.testing.assert_array_equal(vtk_to_numpy(output.GetPointData().GetArray("RTData")), bent)
"""


def test_harness_can_fail(start):
    with start() as gui:
        with pytest.raises(AssertionError, match="no_such_name"):
            gui.run("no_such_name")
        gui.run(SETUP)
        assert noise(gui) == []
        gui.run("simple.MLSDeform(Input=wavelet, Alpha=-1.0).UpdatePipeline()")
        assert any("`alpha`" in line for line in noise(gui))


def test_drag_apply_undo_and_keep(gui, paraview, display):
    gui.launch("MLS Deform")
    gui.run("deform = simple.GetActiveSource()")
    gui.press("alt+a")
    gui.until("is_straight()")
    gui.screenshot("1_applied")

    with gui.dragging(HANDLE, PULL):
        gui.until("dragged(pending=True)")
        gui.screenshot("2_dragging")
        assert gui.value("dragged()") == []
    gui.press("ctrl+z")  # a drag that waits for Apply
    gui.until("dragged(pending=True) == []")
    gui.press("ctrl+y")
    gui.until("dragged(pending=True)")
    gui.press("alt+a")
    gui.until("is_bent()")
    (number,) = gui.value("dragged()")
    assert gui.value(f"deform.RestPoints[{3 * number}:{3 * number + 3}]") == list(HANDLE)
    deformed = gui.value(f"deform.DeformedPoints[{3 * number}:{3 * number + 3}]")
    assert deformed[0] > HANDLE[0] + 2
    assert deformed[1] > HANDLE[1] + 2
    gui.screenshot("3_bent")

    gui.press("ctrl+z")
    gui.until("dragged() == []")
    gui.until("is_straight()")
    gui.press("ctrl+y")
    gui.until(f"dragged() == [{number}]")
    gui.until("is_bent()")

    gui.run(f"simple.SaveState('{gui.folder}/state.pvsm')")
    gui.run(f"np.save('{gui.folder}/bent.npy', rtdata(deform))")
    trace = PROJECT / gui.folder / "trace.py"
    trace.write_text(gui.value("smtrace.stop_trace()") + REPLAY.format(folder=gui.folder))
    paraview.check(gui.folder / trace.name, display=display)

    gui.run("simple.Delete(deform); simple.Delete(wavelet); del deform, wavelet")
    gui.until("not simple.GetSources()")
    gui.run(f"simple.LoadState('{gui.folder}/state.pvsm')")
    gui.run("deform = simple.FindSource('MLSDeform1'); deform.UpdatePipeline()")
    assert gui.value("is_bent()")
    assert gui.value(f"np.array_equal(rtdata(deform), np.load('{gui.folder}/bent.npy'))")
    assert gui.value("dragged()") == [number]
    gui.run("simple.SetActiveSource(deform)")
    with gui.dragging(deformed, (0, 80)):
        gui.until("len(dragged(pending=True)) == 1")


@pytest.mark.matrix
def test_arrows_show_what_was_dragged(gui):
    gui.run(ARROWS)
    gui.launch("MLS Deform")
    gui.run("deform = simple.GetActiveSource()")
    gui.press("alt+a")
    gui.until("is_straight() and widgets() == 1")
    assert gui.value("[arrows(), amber()]") == [[], 0]  # handles that rest have none

    # While a handle is dragged, when it is let go, undone, done again and applied.
    with gui.dragging(HANDLE, PULL):
        gui.until("dragged(pending=True) and arrows()")
        gui.screenshot("1_dragging")
        assert gui.value("dragged()") == []
    gui.run("moved = deform.SMProxy.GetProperty('DeformedPoints')")
    gui.run("ends = [moved.GetUncheckedElement(i) for i in range(81)]")
    gui.run("ends = np.reshape(ends, (-1, 3))[dragged(pending=True)[0]]")
    (bounds,) = gui.value("arrows()")
    for axis in (0, 1):
        assert bounds[2 * axis] < HANDLE[axis] + 0.1
        assert bounds[2 * axis + 1] == pytest.approx(gui.value(f"ends[{axis}]"), abs=0.2)
    assert gui.value("amber()") > 20
    flags = "[[each.GetPickable(), each.GetUseBounds()] for each in actors(view)]"
    assert gui.value(flags) == [[0, 0]]
    gui.press("ctrl+z")
    gui.until("not arrows() and not amber()")
    gui.press("ctrl+y")
    gui.until("arrows() and amber() > 20")
    gui.press("alt+a")
    gui.until("is_bent()")
    assert gui.value("arrows()") == [bounds]
    gui.screenshot("2_applied")

    # Only with the widget, in the view that shows it.
    gui.run("""
other = simple.CreateView("RenderView")
simple.AssignViewToLayout(view=other)
simple.Show(deform, other)
simple.ResetCamera(other)""")
    gui.until("widgets(other) == 1 and widgets() == 0")
    assert gui.value("arrows(other)") == [bounds]
    assert gui.value("arrows()") == []
    gui.run("simple.Render(other)")
    gui.screenshot("3_two_views")
    gui.run("simple.Delete(other); del other; simple.SetActiveView(view)")
    gui.until("widgets() == 1 and arrows()")
    gui.run("simple.SetActiveSource(wavelet)")
    gui.until("widgets() == 0")
    assert gui.value("[arrows(), amber()]") == [[], 0]
    gui.run("simple.SetActiveSource(deform)")
    gui.screenshot("4_selected_again")
    gui.run("simple.Delete(deform); del deform, moved")
    gui.until("len(simple.GetSources()) == 1")
    assert gui.value("[arrows(), amber()]") == [[], 0]


@pytest.mark.matrix
def test_line_between_handles_cannot_be_dragged(gui):
    gui.launch("MLS Deform")
    gui.run("deform = simple.GetActiveSource()")
    gui.press("alt+a")
    gui.until("is_straight()")
    gui.run("camera = view.GetActiveCamera()")
    for place in ((10, 10, 5), (-10, 0, 5), (10, -5, 10)):  # where the widget has its line
        gui.run("before = camera.GetPosition()")
        with gui.dragging(place, (40, 0)):
            gui.until("camera.GetPosition() != before")  # as anywhere beside the handles
        assert gui.value("dragged(pending=True)") == []


@pytest.mark.matrix
def test_weights_that_are_not_used_stay_so(start):
    """Also when all handles are removed and others added."""
    with start() as gui:
        gui.run(SETUP)
        gui.run("""
proxy = servermanager.filters.MLSDeform(Input=wavelet)  # without a panel, whose widget wants one
servermanager.ProxyManager().RegisterProxy("sources", "alone", proxy)
lists = [proxy.SMProxy.GetProperty(name) for name in ("DeformedPoints", "RestPoints", "Weights")]
counts = []
for values in ([], [1.0, 2.0, 3.0], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]):
    lists[0].SetUncheckedElements(values, len(values))
    counts.append([each.GetNumberOfUncheckedElements() for each in lists])""")
        assert gui.value("counts") == [[0, 0, 0], [3, 3, 0], [6, 6, 0]]


@pytest.mark.matrix
def test_auto_apply_follows_the_drag(gui):
    gui.run("settings.SetAutoApply(True)")
    gui.launch("MLS Deform")
    gui.run("deform = simple.GetActiveSource()")
    gui.until("is_straight()")
    with gui.dragging(HANDLE, PULL):
        gui.until("is_bent()")
        gui.screenshot("1_dragging")
    assert len(gui.value("dragged()")) == 1


def test_lists_keep_in_step(gui):
    gui.launch("MLS Deform")
    gui.run("""
deform = simple.GetActiveSource()
rest, moved, weights, lattice = (
    deform.SMProxy.GetProperty(name)
    for name in ("RestPoints", "DeformedPoints", "Weights", "LatticeDimensions")
)

def pending(changed):
    return [changed.GetUncheckedElement(i) for i in range(changed.GetNumberOfUncheckedElements())]

def edit(changed, values):
    changed.SetUncheckedElements(values, len(values))

before = pending(moved)
new = [1.0, 2.0, 3.0]""")
    gui.press("alt+a")
    gui.until("is_straight()")

    # A handle that is added rests where it appears; one that is removed does so in both lists.
    gui.run("edit(weights, [2.0] * 27); edit(moved, before[:15] + new + before[15:])")
    assert gui.value("pending(rest) == pending(moved)")
    assert gui.value("pending(weights)") == [2] * 5 + [1] + [2] * 22
    gui.run("edit(rest, before[3:15] + new + before[15:])")
    assert gui.value("pending(moved) == pending(rest)")
    assert gui.value("pending(weights)") == [2] * 4 + [1] + [2] * 22

    # A handle goes along with its place at rest, as far dragged as it is.
    gui.run("edit(moved, [7.0, *pending(moved)[1:]]); first = pending(rest)[0]")
    gui.run("edit(rest, [first + 2, *pending(rest)[1:]])")
    assert gui.value("pending(moved)[0]") == 9
    assert gui.value("pending(moved)[1:] == pending(rest)[1:]")

    # A lattice is laid in one step; a drag and Apply take all of it.
    gui.run("edit(lattice, [2, 2, 4])")
    assert gui.value("pending(moved) == pending(rest)")
    assert gui.value("pending(rest)[:6]") == [-10, -10, -10, 10, -10, -10]
    assert gui.value("pending(weights)") == []
    assert gui.value("len(deform.RestPoints)") == 81
    with gui.dragging((10, 10, 10), PULL):
        gui.until("pending(moved) != pending(rest)")
    gui.press("alt+a")
    gui.until("is_bent()")
    assert gui.value("[len(deform.RestPoints), len(deform.DeformedPoints)]") == [48, 48]
    gui.press("ctrl+z")
    gui.until("len(deform.RestPoints) == len(deform.DeformedPoints) == 81 and is_straight()")

    # Reset takes an edit back in all lists.
    gui.run("edit(moved, pending(moved)[3:])")
    assert gui.value("len(pending(rest))") == 78
    gui.run("moved.ClearUncheckedElements(); rest.ClearUncheckedElements()")
    gui.run("edit(moved, pending(moved)[:-3])")
    assert gui.value("pending(rest) == pending(moved)")


@pytest.mark.matrix
def test_a_source_two_filters_and_a_reload(gui):
    gui.launch("MLS Control Points")
    gui.run("handles = simple.GetActiveSource()")
    assert gui.value("len(handles.DeformedPoints)") == 24
    table = PROJECT / gui.folder / "handles.csv"
    table.write_text("1,2,3,4,5,6,2\n0,0,0,0,0,0,1\n")
    gui.run(f"""
def pending(name):
    changed = handles.SMProxy.GetProperty(name)
    return [changed.GetUncheckedElement(i) for i in range(changed.GetNumberOfUncheckedElements())]

handles.SMProxy.GetProperty("Mode").SetUncheckedElement(0, "file")
handles.SMProxy.GetProperty("FileName").SetUncheckedElement(0, "{gui.folder}/{table.name}")""")
    assert gui.value("pending('RestPoints')") == [1, 2, 3, 0, 0, 0]
    assert gui.value("pending('DeformedPoints')") == [4, 5, 6, 0, 0, 0]
    assert gui.value("pending('Weights')") == [2, 1]
    gui.press("alt+a")
    gui.run("simple.LoadPlugin('paraview_plugin/vtk_mls_plugin.py', ns=vars(simple))")
    gui.run("simple.SetActiveSource(wavelet)")
    gui.launch("MLS Deform")
    gui.press("alt+a")
    gui.launch("MLS Deform")
    gui.run("deform = simple.GetActiveSource()")
    gui.press("alt+a")
    gui.until("is_straight()")
    with gui.dragging(HANDLE, PULL):
        gui.until("dragged(pending=True)")
    gui.press("alt+a")
    gui.until("is_bent()")
    gui.run("own = rtdata(deform).copy()")
    gui.run("deform.ControlPoints = handles; deform.UpdatePipeline()")
    assert gui.value("is_bent() and not np.array_equal(rtdata(deform), own)")
    gui.run("deform.ControlPoints = None; deform.UpdatePipeline()")
    assert gui.value("np.array_equal(rtdata(deform), own)")
    gui.screenshot("1_two")
    gui.run("for each in (deform, handles): simple.Delete(each)")
    gui.run("del deform, handles, each")
    gui.until("len(simple.GetSources()) == 2")
