"""Handles and the cut plane in ParaView's views: their visibility, first positions and clicks."""

from __future__ import annotations

import shutil
import time

import numpy as np
import pytest
from gui import LISTENER
from gui_scenes import BALL, HANDLE, PICTURES, PROJECT, PULL, SETUP, noise, require_qt


def test_handles_and_plane_come_back(gui):
    """When the filter is selected again; not if the user hid them."""
    gui.add_deform()
    gui.run("edit('CutType', ['plane'])")
    gui.until("shown() == [1, 1]")
    for _ in range(2):
        gui.run("simple.SetActiveSource(wavelet)")
        gui.until("shown() == [0, 0]")
        gui.run("simple.SetActiveSource(deform)")
        gui.until("shown() == [1, 1]")
    with gui.dragging(HANDLE, PULL):
        gui.until("dragged()")
    gui.screenshot("1_again")
    gui.run("simple.HideInteractiveWidgets(proxy=deform)")
    gui.until("shown() == [0, 0]")
    gui.run("simple.SetActiveSource(wavelet)")
    gui.run("simple.SetActiveSource(deform)")
    time.sleep(1)
    assert gui.value("shown()") == [0, 0]


def test_a_handle_wins_where_the_plane_is_hit_too(gui):
    """The arrow of the plane, which is enabled first when the filter is selected again."""
    gui.add_deform()
    gui.run("edit('CutType', ['plane'])")
    gui.until("shown() == [1, 1]")
    gui.run("simple.SetActiveSource(wavelet)")
    gui.until("shown() == [0, 0]")
    gui.run("simple.SetActiveSource(deform)")
    gui.until("shown() == [1, 1]")
    gui.run("simple.Render(view)")
    places = [(0, 0, 10), (10, 0, 0), (-10, 0, 10)]
    for count, place in enumerate(places, 1):
        with gui.dragging(place, PULL):
            gui.until(f"len(dragged()) == {count}")
    gui.screenshot("1_dragged")
    rest = gui.value("[rest_of(number) for number in dragged()]")
    assert sorted(map(tuple, rest)) == sorted(places)
    assert gui.value("[pending('CutOrigin'), pending('CutNormal')]") == [[0, 0, 0], [1, 0, 0]]


@pytest.mark.matrix
def test_the_plane_is_drawn_when_it_is_chosen(gui):
    """As thin lines, which do not hide the gap."""
    gui.add_deform()
    gui.run("""
view.GetRenderer().AddObserver("EndEvent", lambda *_: frames.append(shown()[1]))
edit("CutType", ["plane"])""")
    gui.until("frames and frames[-1] == 1")
    gui.screenshot("1_plane")
    algorithms = gui.run("""
from vtkmodules.vtkRenderingCore import vtkPropCollection
actors = vtkPropCollection()
widgets("ImplicitPlane")[0].GetRepresentation().GetActors(actors)
algorithms = [actor.GetMapper().GetInputAlgorithm() for actor in items(actors)]
answer = [algorithm.GetClassName() for algorithm in algorithms]""")
    assert "vtkLineSource" in algorithms  # of the normal
    assert "vtkTubeFilter" not in algorithms


@pytest.mark.matrix
def test_removed_handles_leave_nothing(start):
    with start() as gui:
        gui.run(SETUP)
        gui.add_deform()
        gui.until("marker_count() == 27")
        gui.run("edit('DeformedPoints', []); simple.Render(view)")
        gui.until("counts() == [0, 0, 0]")
        gui.run("simple.Render(view)")
        gui.run("camera = view.GetActiveCamera(); place = camera.GetPosition()")
        assert gui.value("label_count() == marker_count() == 0")
        with gui.dragging(HANDLE, PULL):
            gui.until("camera.GetPosition() != place")
        assert gui.value("counts()") == [0, 0, 0]
        gui.press("ctrl+z")
        gui.until("counts() == [27, 27, 0] and marker_count()")


def test_clicks_with_ctrl_and_shift(gui):
    """Add a handle on the surface, and remove it: both lists are in step."""
    gui.run(BALL)
    gui.add_deform()
    before = gui.value("counts()[0]")
    place = (3, 3, 82**0.5)
    gui.click_at(place, key="ctrl")
    gui.until(f"counts()[:2] == [{before + 1}] * 2")
    gui.screenshot("1_added")
    np.testing.assert_allclose(
        gui.value(f"rest_of({before})"), place, atol=0.3
    )  # of pixels, and flat faces of the ball
    gui.press("ctrl+z")
    gui.until(f"counts()[:2] == [{before}] * 2")
    gui.press("ctrl+y")
    gui.until(f"counts()[:2] == [{before + 1}] * 2")
    gui.click_at(place, key="shift")
    gui.until(f"counts()[:2] == [{before}] * 2")
    gui.click_at((0, 0, 30), key="ctrl")  # beside the ball
    with gui.dragging((-3, 3, 82**0.5), PULL, key="ctrl"):
        gui.shake(0.5)
    assert gui.value("counts()[:2]") == [before] * 2


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
        assert {tuple(corner) for corner in corners} == expected
        assert gui.value("list(source.DeformedPoints) == list(source.RestPoints)")
        gui.run(f"simple.SaveState('{gui.folder}/state.pvsm')")
        gui.press("alt+a")
        gui.until("source.GetDataInformation().GetNumberOfPoints() == 8")

        # Without a file there is one error.
        gui.run("source.Mode = 'file'; simple.Render(view)")
        lines = [line for line in noise(gui) if "MLSControlPoints" in line]
        assert {line.partition("ERROR: ")[2] for line in lines} == {
            "MLSControlPoints: `FileName` must name a file with control points: choose one"
        }

        # A state has its own positions.
        gui.run("simple.Delete(source); simple.SetActiveSource(None); del source")
        gui.run("wavelet.WholeExtent = [0, 1, 0, 1, 0, 1]; simple.SetActiveSource(wavelet)")
        gui.run(f"simple.LoadState('{gui.folder}/state.pvsm')")
        gui.run("source = simple.FindSource('MLSControlPoints1')")
        assert gui.value("list(source.Bounds)") == box


@pytest.mark.matrix
def test_no_welcome_dialog(start, paraview, request):
    """With the variables of `vtk-mls paraview`, in a new home."""
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


WATCHED = """
wavelet = simple.Wavelet()
wavelet.UpdatePipeline()
deform = simple.MLSDeform(Input=wavelet)
answer = []
for name, elements in (
    ("LatticeDimensions", [2] * 3),
    ("DeformedPoints", [1.0] * 27),
    ("DeformedPoints", [1.0] * 24),
):
    edit(name, elements)
    answer.append(len(pending_rows("RestPoints")))
"""
COUNTS = [8, 9, 8]


@pytest.mark.matrix
def test_handles_are_watched_when_loaded_by_path(start, paraview):
    folder = "/project" if paraview.prefix else str(PROJECT)
    with start(PV_PLUGIN_PATH=f"{folder}/paraview_plugin") as gui:
        assert gui.run(WATCHED) == COUNTS
        gui.run("simple.LoadPlugin('paraview_plugin/vtk_mls_plugin.py', ns=vars(simple))")
        assert gui.run(WATCHED) == COUNTS
        assert noise(gui) == []


@pytest.mark.matrix
def test_handles_are_watched_when_loaded_by_themselves(start, paraview, request):
    """Auto Load is ticked by mouse, and ParaView started again."""
    folder = PICTURES / request.node.callspec.id / "auto_load/home"
    shutil.rmtree(PROJECT / folder, ignore_errors=True)
    (PROJECT / folder / ".config").mkdir(parents=True)
    welcome = "[General]\nGeneralSettings.ShowWelcomeDialog=false\n"
    (PROJECT / folder / ".config/ParaView.ini").write_text(welcome)  # for every version
    home = f"HOME={'/project' if paraview.prefix else PROJECT}/{folder}"
    command = ("env", home, "paraview", f"--script={LISTENER}")
    with start(command=command) as gui:
        require_qt(gui)
        gui.click("menu_item('Tools')")
        gui.click("menu_item('Manage Plugins')")
        gui.click("button('Load New')")
        gui.hover("button('Cancel')")
        gui.type("paraview_plugin/vtk_mls_plugin.py")
        gui.until("hasattr(servermanager.filters, 'MLSDeform')")
        gui.find_in_tree("vtk_mls_plugin", clicks=2)  # opens it
        gui.find_in_tree("Auto Load", column=1)
        gui.screenshot("1_ticked")
        gui.click("button('Close')")
        gui.end()
    with start(command=command) as gui:
        assert gui.run(WATCHED) == COUNTS
        assert noise(gui) == []
