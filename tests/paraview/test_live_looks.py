"""What is drawn before Apply is what Apply shows, whatever ParaView shows data as."""

from __future__ import annotations

import pytest
from gui_fixtures import SETUP, display, gui, noise, paraview, start  # noqa: F401
from test_live import LIVE

LOOKS = """
from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter
rest = np.reshape(deform.RestPoints, (-1, 3))
size = np.ptp(rest, axis=0).max()
turn = 1

def seen():
    simple.Render(view)
    grab = vtkWindowToImageFilter()
    grab.SetInput(view.GetRenderWindow())
    grab.ReadFrontBufferOff()
    grab.Update()
    return vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars()).astype(int)

def share(first, second):  # of pixels that differ, in thousandths
    return 1000 * float((abs(first - second).max(axis=1) > 16).mean())

def compare():  # how much is changed by an edit of two handles, and what by Apply
    global turn
    turn = -turn
    moved = rest.copy()
    moved[[-1, 8]] += np.multiply([[-0.2, 0.15, 0.1], [0.1, 0.2, -0.2]], turn * size)
    before, changed = seen(), deform.SMProxy.GetProperty("DeformedPoints")
    changed.SetUncheckedElements(moved.ravel().tolist(), moved.size)
    pending = seen()
    deform.DeformedPoints = moved.ravel().tolist()
    simple.UpdatePipeline(proxy=deform)
    return share(before, pending), share(pending, seen())
"""

LOOK_AT = """
simple.ColorBy(simple.GetDisplayProperties(shown, view), by)
simple.HideScalarBarIfNotNeeded(simple.GetColorTransferFunction(by[1]), view)
view.CameraPosition = [4, 3, 6]
view.CameraFocalPoint = [0, 0, 0]
view.ResetCamera()
simple.SetActiveSource(shown)
simple.Render(view)
"""


def begin(gui, shown, by):
    """Make a filter of what is shown."""
    gui.run(f"shown, by = {shown}, {by}\n{LOOK_AT}")
    gui.launch("MLS Deform")
    gui.run("deform = simple.GetActiveSource()")
    gui.press("alt+a")
    gui.until("deform.GetDataInformation().GetNumberOfPoints() > 0")
    gui.run("display = simple.GetDisplayProperties(deform, view)")
    gui.run(LOOKS)


# Its thin lines lie in the slice, where rounding decides what is drawn first.
HIDE_PLANE = """
widgets = view.SMProxy.GetProperty("HiddenRepresentations")
for number in range(widgets.GetNumberOfProxies()):
    if "ImplicitPlane" in widgets.GetProxy(number).GetXMLName():
        widgets.GetProxy(number).GetProperty("Visibility").SetElement(0, 0)
        widgets.GetProxy(number).UpdateVTKObjects()
"""


def check(gui, *looks, name=""):
    """The edit is to be seen, and Apply changes nothing more."""
    for look in looks:
        gui.run(f"display.SetRepresentationType({look!r}); simple.Render(view)")
        edited, applied = gui.value("compare()")
        gui.screenshot(f"{name}{look}".replace(" ", "_"))
        assert edited > 5, look
        assert applied < 0.1, look


def test_images_follow_whatever_they_are_shown_as(gui):
    begin(gui, "wavelet", ("POINTS", "RTData"))
    check(gui, "Surface", "Surface With Edges", "Wireframe", "Points", "Slice", "Outline")
    gui.run("deform.CutType = 'plane'; deform.CutNormal = [1, 0, 0]; simple.Render(view)")
    gui.run(HIDE_PLANE)
    check(gui, "Surface", "Slice", "Points", name="cut_")
    gui.run("deform.Live = 0; display.SetRepresentationType('Surface')")
    assert gui.value("compare()[1]") > 5


@pytest.mark.matrix
def test_cells_edges_and_boxes_of_images_follow(gui):
    gui.run("cells = simple.PointDatatoCellData(Input=wavelet)")
    gui.run("simple.Hide(wavelet, view); simple.Show(cells, view)")
    begin(gui, "cells", ("CELLS", "RTData"))
    check(gui, "Surface", "Slice", "Feature Edges", name="cells_")
    for number in (0, 20):
        gui.run(f"display.Slice = {number}; display.SliceMode = 'YZ Plane'")
        check(gui, "Slice", name=f"cells_{number}_")
    gui.run("deform.OutputGrid = 'fitted'; simple.Hide(cells, view)")
    gui.run("simple.HideInteractiveWidgets(proxy=deform)")  # just what is deformed is seen
    check(gui, "Outline", "Surface", "Slice", name="fitted_")


INPUT_CHANGES = {
    "Surface": "Center = [4, 0, 0]",
    "Slice": "Center = [8, 0, 0]",
    "Outline": "WholeExtent = [-10, 6, -10, 10, -10, 10]",
}


def test_changes_of_the_input_are_followed(gui):
    begin(gui, "wavelet", ("POINTS", "RTData"))
    gui.run("simple.HideInteractiveWidgets(proxy=deform)")
    gui.run("changed = deform.SMProxy.GetProperty('DeformedPoints')")
    gui.run("moved = rest.copy(); moved[-1] += [-4, 3, 2]")
    for look, change in INPUT_CHANGES.items():
        gui.run(f"display.SetRepresentationType({look!r}); simple.Render(view)")
        gui.run("changed.SetUncheckedElements(moved.ravel().tolist(), moved.size)")
        gui.run(f"before = seen(); wavelet.{change}; pending = seen()")
        gui.screenshot(look)
        gui.run("deform.DeformedPoints = moved.ravel().tolist()")
        gui.run("simple.UpdatePipeline(proxy=deform); applied = seen()")
        gui.run("deform.DeformedPoints = rest.ravel().tolist()")
        assert gui.value("share(before, pending)") > 5, look
        assert gui.value("share(pending, applied)") < 0.1, look


VOLUME_CHANGES = (
    "wavelet.Center = [6, 0, 0]",
    "wavelet.WholeExtent = [-10, 10, -10, 10, -10, 2]",
    "wavelet.WholeExtent = [-10, 10, -14, 10, -10, 10]; wavelet.SubsampleRate = 4",
    "wavelet.SubsampleRate = 1",
    "deform.Input = other",
)


def test_changes_of_the_input_of_a_volume_are_followed(gui):
    """Values, extent, spacing, another source: with an edit pending, and after Apply alike."""
    gui.run(f"{LIVE}\nfrom vtk_mls.rendering.pace import usual_step")
    gui.run("step_of = lambda each: each._mapper.GetSampleDistance()")
    gui.run("other = simple.Wavelet(WholeExtent=[-12, 8, -10, 10, -10, 10], Maximum=200)")
    begin(gui, "wavelet", ("POINTS", "RTData"))
    gui.run("simple.HideInteractiveWidgets(proxy=deform)")
    gui.run("display.SetRepresentationType('Volume'); simple.Render(view)")
    gui.run("changed = deform.SMProxy.GetProperty('DeformedPoints'); own = volumes()")
    gui.run("moved = rest.copy(); moved[-1] += [-4, 3, 2]")
    for number, change in enumerate(VOLUME_CHANGES):
        gui.run("changed.SetUncheckedElements(moved.ravel().tolist(), moved.size)")
        gui.run(f"before = seen(); {change}; pending = seen()")
        gui.screenshot(f"{number}_pending")
        assert gui.value("volumes()") == ["vtkVolume"], change
        assert gui.value("bool(np.isclose(step_of(drawn[0]), usual_step(drawn[0]._source)))"), (
            change
        )
        gui.run("deform.DeformedPoints = moved.ravel().tolist()")
        gui.run("simple.UpdatePipeline(proxy=deform); applied = seen()")
        gui.screenshot(f"{number}_applied")
        assert gui.value("volumes() == own"), change
        gui.run("deform.DeformedPoints = rest.ravel().tolist()")
        assert gui.value("share(before, pending)") > 5, change
        difference = gui.value("float(abs(pending - applied).mean())")
        print(f"{change}: {difference:.2f} of 255")
        assert difference < 1, change


@pytest.mark.matrix
def test_a_volume_steps_unseen_from_drag_to_apply(gui):
    """A map of 64 nodes while it is dragged, of 128 or so when it is let go, then as by Apply."""
    gui.run("wavelet.WholeExtent = [-32, 31, -32, 31, -32, 31]; wavelet.UpdatePipeline()")
    gui.run("volume = rtdata(wavelet).copy()")
    gui.run(LIVE)
    begin(gui, "wavelet", ("POINTS", "RTData"))
    gui.run("display.SetRepresentationType('Volume'); pictures = [seen()]")
    with gui.dragging((31, 31, -0.5), (160, 120)):
        gui.until("dragged(pending=True) and drawn and drawn[2] == 64")
        gui.run("pictures.append(seen())")
    gui.until("drawn[2] > 100")  # fewer than 128 if the first map has waited for kernels
    gui.run("pictures.append(seen())")
    gui.press("alt+a")
    gui.until("is_bent()")
    gui.run("pictures.append(seen())")
    gui.screenshot("applied")
    changes = gui.run("""
changes = [abs(a - b) for a, b in zip(pictures, pictures[1:])]
answer = [[float(each.mean()), float(np.percentile(each, 99))] for each in changes]""")
    print(*(f"mean {mean:.2f}, p99 {most:.0f} of 255" for mean, most in changes), sep="; ")
    edited, let_go, applied = changes
    assert edited[0] > 1
    for mean, most in (let_go, applied):
        assert mean < edited[0] / 2
        assert mean <= 1
        assert most <= 8


def test_blocks_and_outlines_of_meshes_follow(gui):
    gui.run("parts = [simple.Sphere(Radius=5), simple.Box(Center=[9, 0, 0], YLength=5)]")
    gui.run(
        "blocks = simple.Elevation(Input=simple.GroupDatasets(Input=parts), LowPoint=[-5, 0, 0])"
    )
    gui.run("simple.Hide(wavelet, view); blocks.HighPoint = [12, 0, 0]; simple.Show(blocks, view)")
    begin(gui, "blocks", ("POINTS", "Elevation"))
    check(gui, "Surface", "Wireframe", "Outline", "Feature Edges")
    gui.run("simple.ColorBy(display, ('FIELD', 'vtkBlockColors'))")
    check(gui, "Surface", name="by_block_")


def test_a_structured_mesh_follows(gui):
    gui.run("wavelet.WholeExtent = [-5, 5, -6, 6, -7, 7]")
    gui.run("grid = simple.Transform(Input=wavelet); simple.Hide(wavelet, view)")
    gui.run("grid.UpdatePipeline(); simple.Show(grid, view)")
    begin(gui, "grid", ("POINTS", "RTData"))
    check(gui, "Surface", "Outline", "Feature Edges")
