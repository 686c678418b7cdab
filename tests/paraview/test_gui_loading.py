"""Handles are watched however ParaView's GUI has loaded the plugin, in each ParaView there is."""

from __future__ import annotations

import shutil

import pytest
from gui import LISTENER
from gui_fixtures import (  # noqa: F401  fixtures
    HAS_QT,
    PICTURES,
    PROJECT,
    display,
    noise,
    paraview,
    start,
    unavailable,
)

pytestmark = pytest.mark.matrix

WATCHED = """
wavelet = simple.Wavelet()
wavelet.UpdatePipeline()
deform = simple.MLSDeform(Input=wavelet)
names = ("LatticeDimensions", "DeformedPoints", "RestPoints")
lattice, moved, rest = (deform.SMProxy.GetProperty(name) for name in names)
answer = []
for edited, values in ((lattice, [2] * 3), (moved, [1.0] * 27), (moved, [1.0] * 24)):
    edited.SetUncheckedElements(values, len(values))
    answer.append(rest.GetNumberOfUncheckedElements())
"""
LAID_ADDED_REMOVED = [24, 27, 24]


def load_new(gui):
    """Load the plugin in the dialog for plugins, which stays open."""
    gui.click("menu_item('Tools')")
    gui.click("menu_item('Manage Plugins')")
    gui.click("button('Load New')")
    gui.hover("button('Cancel')")
    gui.type("paraview_plugin/vtk_mls_plugin.py")
    gui.until("hasattr(servermanager.filters, 'MLSDeform')")


def test_handles_are_watched_when_loaded_by_path(start, paraview):
    folder = "/project" if paraview.prefix else str(PROJECT)
    with start(PV_PLUGIN_PATH=f"{folder}/paraview_plugin") as gui:
        assert gui.run(WATCHED) == LAID_ADDED_REMOVED
        gui.run("simple.LoadPlugin('paraview_plugin/vtk_mls_plugin.py', ns=vars(simple))")
        assert gui.run(WATCHED) == LAID_ADDED_REMOVED
        assert noise(gui) == []


def test_handles_are_watched_when_loaded_by_mouse(start):
    with start() as gui:
        if not gui.run(HAS_QT):
            unavailable("no Qt for Python beside this ParaView")
        load_new(gui)
        gui.click("button('Close')")
        gui.run("simple.LoadPlugin('paraview_plugin/vtk_mls_plugin.py', ns=vars(simple))")
        assert gui.run(WATCHED) == LAID_ADDED_REMOVED
        assert noise(gui) == []


def test_handles_are_watched_when_loaded_by_themselves(start, paraview, request):
    """Auto Load is ticked by mouse, ParaView left and started again."""
    folder = PICTURES / request.node.callspec.id / "auto_load/home"
    shutil.rmtree(PROJECT / folder, ignore_errors=True)
    (PROJECT / folder / ".config").mkdir(parents=True)
    welcome = "[General]\nGeneralSettings.ShowWelcomeDialog=false\n"
    (PROJECT / folder / ".config/ParaView.ini").write_text(welcome)  # for every version
    home = f"HOME={'/project' if paraview.prefix else PROJECT}/{folder}"
    command = ("env", home, "paraview", f"--script={LISTENER}")
    with start(command=command) as gui:
        if not gui.run(HAS_QT):
            unavailable("no Qt for Python beside this ParaView")
        load_new(gui)
        gui.find_in_tree("vtk_mls_plugin", clicks=2)  # which opens it
        gui.find_in_tree("Auto Load", column=1)
        gui.screenshot("1_ticked")
        gui.click("button('Close')")
        gui.end()
    with start(command=command) as gui:
        assert gui.run(WATCHED) == LAID_ADDED_REMOVED
        assert noise(gui) == []
