"""Drags, Undo, states and traces in ParaView's GUI, by real keys and mouse events."""

from __future__ import annotations

import pytest
from gui_scenes import BALL, HANDLE, PROJECT, PULL, SETUP, noise, require_qt

REPLAY = """
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
deform = FindSource("MLSDeform1")
UpdatePipeline(proxy=deform)
output = deform.SMProxy.GetClientSideObject().GetOutputDataObject(0)
bent = np.load("{folder}/bent.npy")
np.testing.assert_array_equal(vtk_to_numpy(output.GetPointData().GetArray("RTData")), bent)
"""

PLACED = """
import numpy as np
from paraview import simple
from vtkmodules.util.numpy_support import vtk_to_numpy

def placed():
    deform, handles = (simple.FindSource(name) for name in ("MLSDeform1", "MLSControlPoints1"))
    deform.UpdatePipeline()
    points = deform.SMProxy.GetClientSideObject().GetOutputDataObject(0).GetPoints()
    lists = [[source.RestPoints, source.DeformedPoints] for source in (deform, handles)]
    return *map(np.array, (*lists, handles.Bounds)), vtk_to_numpy(points.GetData())

def check(folder):
    for value, expected in zip(placed(), np.load(f"{folder}/placed.npz").values()):
        np.testing.assert_array_equal(value, expected)
    display = simple.GetDisplayProperties(simple.FindSource("MLSDeform1"))
    assert (display.Opacity, display.Representation) == (0.5, "Surface With Edges")

"""
LOAD_PLUGIN = """
from paraview import simple
simple.LoadPlugin("paraview_plugin/vtk_mls_plugin.py", ns=vars(simple))
"""
TRACE = f"""{LOAD_PLUGIN}
ball = simple.OpenDataFile(folder + "/ball.vtp")
display = simple.Show(ball, view)
display.SetRepresentationType("Surface With Edges")
display.Opacity = 0.5
simple.SetActiveSource(ball)
view.ResetCamera()
simple.Render(view)
"""


def test_harness_can_fail(start):
    with start() as gui:
        with pytest.raises(AssertionError, match="no_such_name"):
            gui.run("no_such_name")
        gui.run(SETUP)
        assert noise(gui) == []
        gui.run("simple.MLSDeform(Input=wavelet, Alpha=-1.0).UpdatePipeline()")
        assert any("`Locality (alpha)`" in line for line in noise(gui))


def test_drag_apply_undo_and_save(gui, paraview, display):
    gui.add_deform()
    gui.screenshot("1_applied")

    with gui.dragging(HANDLE, PULL):
        gui.until("dragged()")
        gui.screenshot("2_dragging")
        assert gui.value("applied_drags()") == []
    gui.press("ctrl+z")  # a drag that waits for Apply
    gui.until("dragged() == []")
    gui.press("ctrl+y")
    gui.until("dragged()")
    gui.press("alt+a")
    gui.until("is_bent()")
    (number,) = gui.value("applied_drags()")
    assert gui.value(f"deform.RestPoints[{3 * number}:{3 * number + 3}]") == list(HANDLE)
    deformed = gui.value(f"deform.DeformedPoints[{3 * number}:{3 * number + 3}]")
    assert deformed[0] > HANDLE[0] + 2
    assert deformed[1] > HANDLE[1] + 2
    gui.screenshot("3_bent")

    gui.press("ctrl+z")
    gui.until("applied_drags() == []")
    gui.until("is_straight()")
    gui.press("ctrl+y")
    gui.until(f"applied_drags() == [{number}]")
    gui.until("is_bent()")

    gui.run(f"simple.SaveState('{gui.folder}/state.pvsm')")
    gui.run(f"np.save('{gui.folder}/bent.npy', values(deform))")
    trace = PROJECT / gui.folder / "trace.py"
    trace.write_text(gui.value("smtrace.stop_trace()") + REPLAY.format(folder=gui.folder))
    paraview.check(gui.folder / trace.name, display=display)

    gui.run("simple.Delete(deform); simple.Delete(wavelet); del deform, wavelet")
    gui.until("not simple.GetSources()")
    gui.run(f"simple.LoadState('{gui.folder}/state.pvsm')")
    gui.run("deform = simple.FindSource('MLSDeform1'); deform.UpdatePipeline()")
    assert gui.value("is_bent()")
    assert gui.value(f"np.array_equal(values(deform), np.load('{gui.folder}/bent.npy'))")
    assert gui.value("applied_drags()") == [number]
    gui.run("simple.SetActiveSource(deform)")
    with gui.dragging(deformed, (0, 80)):
        gui.until("len(dragged()) == 1")


def test_traces_and_states_have_what_the_plugin_sets(gui, paraview, display):
    """The first handles on a ball, a kind, and the display; with each option of a trace."""
    gui.run(f"smtrace.stop_trace(); folder = '{gui.folder}'\n{BALL}\n{PLACED}")
    gui.run("simple.SaveData(f'{folder}/ball.vtp', ball); simple.Delete(ball)")
    for option in ("ALL", "MODIFIED", "USER_MODIFIED"):
        gui.run("tracer = smtrace.start_trace()")
        gui.run(f"tracer.SetPropertiesToTraceOnCreate(tracer.RECORD_{option}_PROPERTIES)")
        gui.run(TRACE)
        gui.launch("MLS Control Points")
        gui.press("alt+a")
        gui.run("simple.SetActiveSource(ball)")
        gui.add_deform()
        number, place = gui.value("handles_in_sight()")[0]
        with gui.dragging(place, PULL):
            gui.until("dragged()")
        gui.run("edit('Kind', ['spline']); edit('Smoothing', [0.5])")
        gui.press("alt+a")
        gui.until(f"applied_drags() == [{number}]")
        gui.until("deform.Kind == 'spline' and deform.Smoothing == 0.5")
        gui.run("np.savez(f'{folder}/placed.npz', *placed())")
        replay(gui, paraview, display, gui.value("smtrace.stop_trace()"))
        if option == "USER_MODIFIED":
            gui.run("from paraview import smstate; simple.SaveState(f'{folder}/state.pvsm')")
            state = gui.value("smstate.get_state()")
            replay(gui, paraview, display, f"{LOAD_PLUGIN}{state}")
        gui.run("while sources := simple.GetSources(): simple.Delete([*sources.values()][-1])")
    gui.run("simple.LoadState(f'{folder}/state.pvsm'); check(folder)")


def replay(gui, paraview, display, text):
    """Run a trace or a state, which must have the same result to the bit."""
    script = PROJECT / gui.folder / "replay.py"
    script.write_text(f"{text}\n{PLACED}check('{gui.folder}')\n")
    paraview.check(gui.folder / script.name, display=display)


def test_restore_defaults(gui):
    """Handles go back on the material, and no array is chosen that a new filter has not."""
    require_qt(gui)
    gui.run(f"{BALL}\nimport gui_places; gui_places.widen('propertiesDock', 560)")
    gui.add_deform()
    lists = "LabelArrays", "GradientVectorArrays", "PushForwardArrays"
    gui.run("first = pending('RestPoints')")
    with gui.dragging(gui.value("handles_in_sight()")[0][1], PULL):
        gui.until("dragged()")
    gui.press("alt+a")
    gui.until("applied_drags()")
    gui.run("deform.LabelArrays = ['Normals']; deform.WeightArray = ['POINTS', 'Other']")
    gui.click("tool('PropertiesRestoreDefaults')")
    gui.until("np.allclose(pending('DeformedPoints'), first, atol=1e-12)")
    gui.press("alt+a")
    gui.until("applied_drags() == []")
    assert gui.value("np.allclose(deform.RestPoints, first, atol=1e-12)")
    assert gui.value(f"[list(getattr(deform, name)) for name in {lists}]") == [[]] * 3
    assert gui.value("deform.WeightArray[1]") == "Weight"

    gui.run("points = simple.MLSControlPoints()")
    gui.run("pairs = simple.Calculator(Input=points, Function='1', ResultArrayName='Other')")
    gui.run("simple.UpdatePipeline(proxy=pairs); simple.SetActiveSource(pairs)")
    gui.launch("MLS Landmark Report")
    gui.press("alt+a")
    gui.run("report = simple.GetActiveSource(); simple.UpdatePipeline(proxy=report)")
    gui.run("report.WeightArray = ['POINTS', 'Other']")
    gui.find_and_click("tool", "PropertiesRestoreDefaults")
    gui.until("report.WeightArray[1] == 'Weight'")


@pytest.mark.matrix
def test_arrows_show_drags(gui):
    gui.add_deform()
    gui.until("widgets('PolyLineWidget')")
    assert gui.value("[arrows(), arrow_pixels()]") == [[], 0]

    # During a drag, after it, and after Undo, Redo and Apply.
    with gui.dragging(HANDLE, PULL):
        gui.until("dragged() and arrows()")
        gui.screenshot("1_dragging")
        assert gui.value("applied_drags()") == []
    end = gui.value("pending_rows('DeformedPoints')[dragged()[0]].tolist()")
    (bounds,) = gui.value("arrows()")
    for axis in (0, 1):
        assert bounds[2 * axis] < HANDLE[axis] + 0.1
        assert bounds[2 * axis + 1] == pytest.approx(end[axis], abs=0.2)
    assert gui.value("arrow_pixels()") > 20
    flags = "[[actor.GetPickable(), actor.GetUseBounds()] for actor in arrow_actors()]"
    assert gui.value(flags) == [[0, 0]]
    gui.press("ctrl+z")
    gui.until("not arrows() and not arrow_pixels()")
    gui.press("ctrl+y")
    gui.until("arrows() and arrow_pixels() > 20")
    gui.press("alt+a")
    gui.until("is_bent()")
    assert gui.value("arrows()") == [bounds]
    gui.screenshot("2_applied")

    # Only in the view that shows the widget.
    gui.run("""
other = simple.CreateView("RenderView")
simple.AssignViewToLayout(view=other)
simple.Show(deform, other)
simple.ResetCamera(other)""")
    gui.until("widgets('PolyLineWidget', other) and not widgets('PolyLineWidget')")
    assert gui.value("arrows(other)") == [bounds]
    assert gui.value("arrows()") == []
    gui.run("simple.Render(other)")
    gui.screenshot("3_two_views")
    gui.run("simple.Delete(other); del other; simple.SetActiveView(view)")
    gui.until("widgets('PolyLineWidget') and arrows()")
    gui.run("simple.SetActiveSource(wavelet)")
    gui.until("not widgets('PolyLineWidget')")
    assert gui.value("[arrows(), arrow_pixels()]") == [[], 0]
    gui.run("simple.SetActiveSource(deform)")
    gui.screenshot("4_selected_again")
    gui.run("simple.Delete(deform); del deform")
    gui.until("len(simple.GetSources()) == 1")
    assert gui.value("[arrows(), arrow_pixels()]") == [[], 0]


@pytest.mark.matrix
def test_line_between_handles_cannot_be_dragged(gui):
    gui.add_deform()
    gui.run("camera = view.GetActiveCamera()")
    for place in ((10, 10, 5), (-10, 0, 5), (10, -5, 10)):  # on the widget's line
        gui.run("before = camera.GetPosition()")
        with gui.dragging(place, (40, 0)):
            gui.until("camera.GetPosition() != before")
        assert gui.value("dragged()") == []


@pytest.mark.matrix
def test_weights_that_are_not_used_stay_so(start):
    """Also when all handles are removed and others added."""
    with start() as gui:
        gui.run(SETUP)
        gui.run("""
deform = servermanager.filters.MLSDeform(Input=wavelet)  # no panel: its widget needs a handle
servermanager.ProxyManager().RegisterProxy("sources", "alone", deform)
found = []
for elements in ([], [1.0, 2.0, 3.0], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]):
    edit("DeformedPoints", elements)
    found.append(counts())""")
        assert gui.value("found") == [[0, 0, 0], [1, 1, 0], [2, 2, 0]]


@pytest.mark.matrix
def test_auto_apply_follows_the_drag(gui):
    gui.run("settings.SetAutoApply(True)")
    gui.add_deform(apply=False)
    gui.until("is_straight()")
    with gui.dragging(HANDLE, PULL):
        gui.until("is_bent()")
        gui.screenshot("1_dragging")
    assert len(gui.value("applied_drags()")) == 1


def test_lists_keep_in_step(gui):
    gui.run("""
def are_equal():
    return pending("RestPoints") == pending("DeformedPoints")

new = [1.0, 2.0, 3.0]""")
    gui.add_deform()
    gui.run("before = pending('DeformedPoints')")

    # An added handle is at rest; a handle that is removed from one list leaves the others.
    gui.run("edit('Weights', [2.0] * 27)")
    gui.run("edit('DeformedPoints', before[:15] + new + before[15:])")
    assert gui.value("are_equal()")
    assert gui.value("pending('Weights')") == [2] * 5 + [1] + [2] * 22
    gui.run("edit('RestPoints', before[3:15] + new + before[15:])")
    assert gui.value("are_equal()")
    assert gui.value("pending('Weights')") == [2] * 4 + [1] + [2] * 22

    # A handle moves along with its rest position.
    gui.run("edit('DeformedPoints', [7.0, *pending('DeformedPoints')[1:]])")
    gui.run("rest = pending('RestPoints'); edit('RestPoints', [rest[0] + 2, *rest[1:]])")
    assert gui.value("pending('DeformedPoints')[0]") == 9
    assert gui.value("pending('DeformedPoints')[1:] == pending('RestPoints')[1:]")

    # A lattice replaces all lists; a drag and Apply include it.
    gui.run("edit('LatticeDimensions', [2, 2, 4])")
    assert gui.value("are_equal()")
    assert gui.value("pending('RestPoints')[:6]") == [-10, -10, -10, 10, -10, -10]
    assert gui.value("pending('Weights')") == []
    assert gui.value("len(deform.RestPoints)") == 81
    with gui.dragging((10, 10, 10), PULL):
        gui.until("not are_equal()")
    gui.press("alt+a")
    gui.until("is_bent()")
    assert gui.value("[len(deform.RestPoints), len(deform.DeformedPoints)]") == [48, 48]
    gui.press("ctrl+z")
    gui.until("len(deform.RestPoints) == len(deform.DeformedPoints) == 81 and is_straight()")

    # Reset takes an edit back in all lists.
    gui.run("edit('DeformedPoints', pending('DeformedPoints')[3:])")
    assert gui.value("counts()[0]") == 26
    gui.run("""
for name in ("DeformedPoints", "RestPoints"):
    deform.SMProxy.GetProperty(name).ClearUncheckedElements()
edit("DeformedPoints", pending("DeformedPoints")[:-3])""")
    assert gui.value("are_equal()")


@pytest.mark.matrix
def test_a_source_two_filters_and_a_reload(gui):
    gui.launch("MLS Control Points")
    gui.run("handles = simple.GetActiveSource()")
    assert gui.value("len(handles.DeformedPoints)") == 24
    # A table with times: the handles of each time are those of the file.
    timed = PROJECT / gui.folder / "timed.csv"
    rows = [f"{time},1,2,3,{4 + time},5,6" for time in (0, 1)]
    timed.write_text("\n".join(["time,px,py,pz,qx,qy,qz", *rows]))
    gui.run("edit('Mode', ['file'], handles)")
    gui.run(f"edit('FileName', ['{gui.folder}/{timed.name}'], handles)")
    gui.press("alt+a")
    gui.until("len(handles.DeformedPoints) == 0")
    for time in (0, 1):
        gui.run(f"handles.UpdatePipeline({time})")
        assert gui.value("output(handles).GetPointData().GetArray(0).GetTuple(0)[0]") == 3 + time
    table = PROJECT / gui.folder / "handles.csv"
    table.write_text("1,2,3,4,5,6,2\n0,0,0,0,0,0,1\n")
    gui.run(f"edit('FileName', ['{gui.folder}/{table.name}'], handles)")
    assert gui.value("pending('RestPoints', handles)") == [1, 2, 3, 0, 0, 0]
    assert gui.value("pending('DeformedPoints', handles)") == [4, 5, 6, 0, 0, 0]
    assert gui.value("pending('Weights', handles)") == [2, 1]
    gui.press("alt+a")
    gui.run("simple.LoadPlugin('paraview_plugin/vtk_mls_plugin.py', ns=vars(simple))")
    gui.run("simple.SetActiveSource(wavelet)")
    gui.launch("MLS Deform")
    gui.press("alt+a")
    gui.add_deform()
    with gui.dragging(HANDLE, PULL):
        gui.until("dragged()")
    gui.press("alt+a")
    gui.until("is_bent()")
    gui.run("own = values(deform).copy()")
    gui.run("deform.ControlPoints = handles; deform.UpdatePipeline()")
    assert gui.value("is_bent() and not np.array_equal(values(deform), own)")
    gui.run("deform.ControlPoints = None; deform.UpdatePipeline()")
    assert gui.value("np.array_equal(values(deform), own)")
    gui.screenshot("1_two")
    gui.run("simple.Delete(deform); simple.Delete(handles); del deform, handles")
    gui.until("len(simple.GetSources()) == 2")
