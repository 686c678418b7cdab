"""Where *Live* cannot draw, it warns and restores ParaView's own props."""

from __future__ import annotations

import os
import signal
import subprocess

import pytest
from gui_scenes import HANDLE, LIVE, LOAD, PROJECT, PULL, SETUP, WAVELET
from paraviews import free_port

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
