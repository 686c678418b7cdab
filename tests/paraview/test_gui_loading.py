"""Handles are watched, no matter how ParaView's GUI loads the plugin."""

from __future__ import annotations

import shutil

import pytest
from gui import LISTENER
from gui_fixtures import require_qt
from gui_scenes import PICTURES, PROJECT, noise

pytestmark = pytest.mark.matrix

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
        assert gui.run(WATCHED) == COUNTS
        gui.run("simple.LoadPlugin('paraview_plugin/vtk_mls_plugin.py', ns=vars(simple))")
        assert gui.run(WATCHED) == COUNTS
        assert noise(gui) == []


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
        load_new(gui)
        gui.find_in_tree("vtk_mls_plugin", clicks=2)  # opens it
        gui.find_in_tree("Auto Load", column=1)
        gui.screenshot("1_ticked")
        gui.click("button('Close')")
        gui.end()
    with start(command=command) as gui:
        assert gui.run(WATCHED) == COUNTS
        assert noise(gui) == []
