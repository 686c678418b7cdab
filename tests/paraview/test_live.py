"""The result of a drag is drawn before Apply; where it cannot be, a warning says so."""

from __future__ import annotations

import os
import signal
import subprocess

import pytest
from gui_scenes import HANDLE, LIVE, LOAD, PROJECT, PULL, SETUP, WAVELET
from paraviews import free_port


def test_a_volume_follows_before_apply(gui):
    gui.run(LIVE)
    gui.add_deform(apply=False)
    gui.run("view.GetRenderer().AddObserver('EndEvent', record_frame)")
    with gui.dragging(HANDLE, PULL):  # before the first Apply the input is shown
        gui.until("dragged() and drawn")
        gui.screenshot("1_before_the_first_apply")
        assert gui.value("volumes()") == ["vtkVolume"]
    gui.press("alt+a")
    gui.until("is_bent()")
    gui.screenshot("2_applied")
    assert gui.value("volumes()") != ["vtkVolume"]

    gui.run("frames.clear(); drawn.clear()")
    other = [10, -10, 0]
    with gui.dragging(other, PULL):
        gui.until("len(dragged()) == 2 and drawn")
        gui.run("frames.clear(); before = drawn[0].uploads")
        gui.shake_until("len(frames) >= 10")
        frames, uploads = gui.value("[frames, drawn[0].uploads - before]")
        assert sum(frames) >= 0.9 * len(frames)
        assert uploads <= len(frames)
        gui.run("frames.clear()")
        gui.shake(1, rate=1000)
        frames = gui.value("frames")
        assert len(frames) > 0
        assert sum(frames) >= 0.9 * len(frames)
        gui.screenshot("3_dragging")
        assert gui.value("len(applied_drags())") == 1
        assert 24 <= gui.value("drawn[2]") <= 64  # fewer than 64 nodes on a busy machine
    gui.until("drawn[2] > 100")  # likewise fewer than 128
    gui.screenshot("4_let_go")
    gui.press("ctrl+z")
    gui.until("len(dragged()) == 1")
    gui.screenshot("5_undone")
    gui.press("alt+a")
    gui.screenshot("6_end")


MESH = """
simple.Delete(wavelet)
cone = simple.Cone(Resolution=60, Height=20, Radius=10)
elevation = simple.Elevation(Input=cone, LowPoint=[-10, 0, 0], HighPoint=[10, 0, 0])
elevation.UpdatePipeline()
simple.Show(elevation, view)
simple.ColorBy(simple.GetDisplayProperties(elevation, view), ("POINTS", "Elevation"))
view.ResetCamera()
simple.SetActiveSource(elevation)
simple.Render(view)
from vtk_mls.rendering import DeformedMesh
record_updates(DeformedMesh)
"""


def test_a_mesh_follows_before_apply(gui):
    gui.run(MESH)
    gui.add_deform()
    with gui.dragging((10, 0, 0), PULL):  # the tip
        gui.until("dragged() and drawn")
        gui.screenshot("1_dragging")
        assert gui.value("drawn[2]") is False
    gui.until("drawn[2]")
    gui.screenshot("2_let_go")
    gui.run("bounds = drawn[0]._actor.GetMapper().GetInput().GetBounds()")
    gui.press("alt+a")
    gui.until("len(applied_drags()) == 1")
    gui.until("np.allclose(deform.GetDataInformation().GetBounds(), bounds, atol=1e-4)")
    gui.screenshot("3_applied")


def test_live_props_follow_the_display(gui):
    gui.run(LIVE)
    gui.add_deform()
    own = gui.value("volumes()")
    assert own != ["vtkVolume"]
    with gui.dragging(HANDLE, PULL):
        gui.until("dragged() and drawn")
    gui.run("display = simple.GetDisplayProperties(deform, view)")
    live = ["vtkVolume"]
    for change, expected in (
        ("simple.Hide(deform, view)", []),
        ("simple.Show(deform, view)", live),
        ("display.SetRepresentationType('Surface')", []),
        ("display.SetRepresentationType('Volume')", live),
        ("simple.GetColorTransferFunction('RTData').ApplyPreset('Grayscale', True)", live),
        ("deform.Live = 0", own),
        ("deform.Live = 1", live),
    ):
        gui.run(f"{change}; simple.Render(view)")
        assert gui.value("volumes()") == expected, change
    gui.screenshot("1_gray")
    gui.run("other = simple.CreateRenderView(); simple.Show(deform, other)")
    gui.run("simple.GetDisplayProperties(deform, other).SetRepresentationType('Volume')")
    gui.run("simple.Render(other)")
    gui.run("simple.SetActiveView(view); simple.SetActiveSource(deform)")
    gui.run("simple.Delete(deform); del deform; simple.Render(view); simple.Render(other)")
    assert gui.value("volumes() + volumes(other)") == []


OTHER = """
other, layout = simple.CreateView("RenderView"), simple.GetLayout(view)
layout.SplitVertical(0, 0.5)
layout.AssignView(2, other)
simple.Show(deform, other)
simple.GetDisplayProperties(deform, other).SetRepresentationType("Volume")
simple.ColorBy(simple.GetDisplayProperties(deform, other), ("POINTS", "RTData"))
simple.SetActiveView(view)
simple.SetActiveSource(deform)
simple.Render(view)
simple.Render(other)
rendered = []
other.GetRenderWindow().AddObserver("EndEvent", lambda *_: rendered.append(volumes(other)))
"""


@pytest.mark.matrix
def test_another_view_follows_when_the_mouse_lets_go(gui):
    gui.run(LIVE)
    gui.add_deform()
    gui.run(OTHER)
    own = gui.value("volumes(other)")
    with gui.dragging(HANDLE, PULL):
        gui.until("dragged() and drawn")
        gui.shake(0.5)
        gui.run("rendered.clear()")
    gui.until("rendered")
    gui.shake(0.5)
    assert gui.value("rendered") == [["vtkVolume"]]  # once
    gui.screenshot("1_let_go")
    gui.run("rendered.clear(); edit('Live', [0])")
    gui.until("rendered")
    assert gui.value("rendered") == [own]
    gui.run("rendered.clear(); edit('Live', [1])")
    gui.until("rendered")
    assert gui.value("rendered") == [["vtkVolume"]]
    gui.press("alt+r")
    gui.until("rendered[-1] != ['vtkVolume']")
    gui.screenshot("2_reset")


CUT = """
deform.CutType, deform.CutOrigin, deform.CutNormal = "plane", [0, 0, 0], [1, 0, 0]
moved = np.reshape(deform.DeformedPoints, (-1, 3))
moved = moved + np.sign(moved[:, :1]) * [2, 0, 0]
deform.DeformedPoints = moved.ravel().tolist()
camera = view.GetActiveCamera()
camera.Azimuth(45)
simple.Render(view)

def record_cut(*_):
    frames.append(bool(drawn) and drawn[1].cuts[0].point.tolist() == pending("CutOrigin"))

view.GetRenderer().AddObserver("EndEvent", record_cut)
"""


def test_a_cut_is_drawn_where_the_mouse_moves_it(gui):
    gui.run(LIVE)
    gui.add_deform()
    gui.run(CUT)
    gui.until("is_bent()")
    with gui.dragging((0, 5, 3), (90, 0)):
        gui.until("pending('CutOrigin')[0] > 2 and drawn")
        gui.run("frames.clear()")
        gui.shake_until("len(frames) >= 5")
        frames = gui.value("frames")
        gui.screenshot("1_dragging")
        assert sum(frames) >= 0.9 * len(frames)
        assert gui.value("list(deform.CutOrigin)") == [0, 0, 0]
        assert gui.value("drawn[2]") <= 64
    gui.until("drawn[2] > 64")
    gui.press("alt+a")
    gui.until("deform.CutOrigin[0] > 2")
    gui.screenshot("2_applied")


NO_GLSL = """
from vtk_mls.rendering import shader
shader._REPLACEMENTS["//VTK::Cropping::Impl"] = "not GLSL;\\n{tag}"
"""
FAILS = """
from vtk_mls.rendering import DeformedMesh
def update(self, deformation, exact=True, has_distortion=False):
    raise MemoryError
DeformedMesh.update = update
simple.Hide(wavelet, view)
cone = simple.Cone(Height=20, Radius=10)
simple.Show(cone, view)
view.ResetCamera()
simple.SetActiveSource(cone)
simple.Render(view)
"""


def test_a_shader_that_does_not_build(start):
    with start() as gui:
        gui.run(SETUP + LIVE + NO_GLSL)
        gui.add_deform()
        gui.run("simple.Render(view); own = volumes()")
        with gui.dragging(HANDLE, PULL):
            gui.until("dragged() and drawn and not deform.Live")
            gui.shake(0.5)
        assert gui.value("volumes() == own")
        gui.screenshot("1_not_followed")
        gui.press("alt+a")
        gui.until("is_bent()")
        assert gui.printed.count("does not build the shader") == 1


@pytest.mark.matrix
def test_a_volume_drawn_without_the_graphics_card(start):
    with start() as gui:
        gui.run(SETUP + LIVE + "display = simple.GetDisplayProperties(wavelet, view)")
        gui.run("display.VolumeRenderingMode = 'Ray Cast Only'; simple.Render(view)")
        gui.add_deform(apply=False)
        gui.run("own = volumes()")
        with gui.dragging(HANDLE, PULL):
            gui.until("dragged() and not deform.Live")
            gui.shake(0.5)
        assert gui.value("volumes() == own and not drawn")
        gui.press("alt+a")
        gui.until("is_bent()")
        assert gui.printed.count("is neither Smart nor GPU Based. Apply shows the result") == 1


@pytest.mark.matrix
def test_a_failed_update_is_reported_once(start):
    with start() as gui:
        gui.run(SETUP + FAILS)
        gui.add_deform(apply=False)
        handles = gui.value("[*zip(*[iter(deform.RestPoints)] * 3)]")
        with gui.dragging(max(handles, key=lambda position: position[2]), PULL):
            gui.until("dragged() and not deform.Live")
            gui.shake(0.5)
        gui.press("alt+a")
        gui.until("deform.GetDataInformation().GetNumberOfPoints() > 0")
        assert gui.printed.count("there is not enough memory. Apply shows the result") == 1


@pytest.mark.matrix
def test_on_a_server_it_is_off_and_warns(start, paraview, display):
    port = free_port()
    server = subprocess.Popen(
        [*paraview.prefix, "pvserver", f"--server-port={port}"],
        cwd=PROJECT,
        env=paraview.environment(DISPLAY=display),
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        while "Accepting" not in server.stdout.readline():
            assert server.poll() is None
        with start(PARAVIEW_GUI_SERVER=str(port), PV_PLUGIN_PATH="paraview_plugin") as gui:
            gui.run("import gc; gc.collect()")  # observers must survive
            gui.run(LOAD.replace("ns=vars(simple))", "True, vars(simple))") + WAVELET)
            gui.add_deform(apply=False)
            gui.press("alt+a")
            assert gui.value("deform.Live") == 0
            gui.until("deform.GetDataInformation().GetNumberOfPoints() > 0")
            with gui.dragging(HANDLE, PULL):
                gui.until("dragged()")
            gui.screenshot("1_dragged")
            gui.run("deform.Live = 1; simple.Render(view)")
            assert gui.value("deform.Live") == 0
            assert gui.printed.count("on another machine. Apply shows the result") == 1
            gui.press("alt+a")
            gui.until("applied_drags()")
            gui.screenshot("2_applied")
    finally:
        os.killpg(server.pid, signal.SIGKILL)
        server.communicate()
