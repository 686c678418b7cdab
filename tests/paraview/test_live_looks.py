"""What is drawn before Apply is what Apply shows, whatever ParaView shows data as."""

from __future__ import annotations

from gui_fixtures import SETUP, display, gui, noise, paraview, start  # noqa: F401

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
    check(gui, "Surface", "Slice", "Points", name="cut_")
    gui.run("deform.Live = 0; display.SetRepresentationType('Surface')")
    assert gui.value("compare()[1]") > 5


def test_blocks_and_outlines_of_meshes_follow(gui):
    gui.run("parts = [simple.Sphere(Radius=5), simple.Box(Center=[9, 0, 0], YLength=5)]")
    gui.run(
        "blocks = simple.Elevation(Input=simple.GroupDatasets(Input=parts), LowPoint=[-5, 0, 0])"
    )
    gui.run("simple.Hide(wavelet, view); blocks.HighPoint = [12, 0, 0]; simple.Show(blocks, view)")
    begin(gui, "blocks", ("POINTS", "Elevation"))
    check(gui, "Surface", "Wireframe", "Outline")
    gui.run("simple.ColorBy(display, ('FIELD', 'vtkBlockColors'))")
    check(gui, "Surface", name="by_block_")


def test_a_structured_mesh_follows(gui):
    gui.run("wavelet.WholeExtent = [-5, 5, -6, 6, -7, 7]")
    gui.run("grid = simple.Transform(Input=wavelet); simple.Hide(wavelet, view)")
    gui.run("grid.UpdatePipeline(); simple.Show(grid, view)")
    begin(gui, "grid", ("POINTS", "RTData"))
    check(gui, "Surface", "Outline")
