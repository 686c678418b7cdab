"""Live props look as the result of Apply, in all representations."""

from __future__ import annotations

import pytest
from gui_scenes import LIVE

COMPARE = """
rest = np.reshape(deform.RestPoints, (-1, 3))
size = np.ptp(rest, axis=0).max()
sign = 1

def compare():  # shares of the pixels that an edit of two handles changes, and Apply
    global sign
    sign = -sign
    moved = rest.copy()
    moved[[-1, 8]] += np.multiply([[-0.2, 0.15, 0.1], [0.1, 0.2, -0.2]], sign * size)
    before = rendered_picture()
    edit("DeformedPoints", moved.ravel().tolist())
    edited = rendered_picture()
    deform.DeformedPoints = moved.ravel().tolist()
    simple.UpdatePipeline(proxy=deform)
    return changed_share(before, edited), changed_share(edited, rendered_picture())
"""

SHOW = """
simple.ColorBy(simple.GetDisplayProperties(source, view), by)
simple.HideScalarBarIfNotNeeded(simple.GetColorTransferFunction(by[1]), view)
view.CameraPosition = [4, 3, 6]
view.CameraFocalPoint = [0, 0, 0]
view.ResetCamera()
simple.SetActiveSource(source)
simple.Render(view)
"""


def begin(gui, source, by):
    gui.run(f"source, by = {source}, {by}\n{SHOW}")
    gui.add_deform()
    gui.run("display = simple.GetDisplayProperties(deform, view)")
    gui.run(COMPARE)


# Its lines lie in the slice, where rounding decides which is in front.
HIDE_PLANE = """
for proxy in widget_proxies("ImplicitPlane"):
    proxy.GetProperty("Visibility").SetElement(0, 0)
    proxy.UpdateVTKObjects()
"""


def check(gui, *representations, name=""):
    """An edit changes the picture, and Apply does not change it further."""
    for representation in representations:
        gui.run(f"display.SetRepresentationType({representation!r}); simple.Render(view)")
        edited, applied = gui.value("compare()")
        gui.screenshot(f"{name}{representation}".replace(" ", "_"))
        assert edited > 5, representation
        assert applied < 0.1, representation


def test_images_follow_in_every_representation(gui):
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
    gui.run("simple.HideInteractiveWidgets(proxy=deform)")
    check(gui, "Outline", "Surface", "Slice", name="fitted_")


VOLUME_CHANGES = (
    "wavelet.Center = [6, 0, 0]",
    "wavelet.WholeExtent = [-10, 10, -10, 10, -10, 2]",
    "wavelet.WholeExtent = [-10, 10, -14, 10, -10, 10]; wavelet.SubsampleRate = 4",
    "wavelet.SubsampleRate = 1",
    "deform.Input = other",
)


@pytest.mark.matrix
def test_changes_of_the_input_of_a_volume_are_followed(gui):
    """Values, extent, spacing, another source: with an edit pending, and after Apply alike."""
    gui.run(f"{LIVE}\nfrom vtk_mls.rendering.pace import usual_step")
    gui.run("step_of = lambda prop: prop._mapper.GetSampleDistance()")
    gui.run("other = simple.Wavelet(WholeExtent=[-12, 8, -10, 10, -10, 10], Maximum=200)")
    begin(gui, "wavelet", ("POINTS", "RTData"))
    gui.run("simple.HideInteractiveWidgets(proxy=deform)")
    gui.run("display.SetRepresentationType('Volume'); simple.Render(view)")
    gui.run("own = volumes()")
    gui.run("moved = rest.copy(); moved[-1] += [-4, 3, 2]")
    for number, change in enumerate(VOLUME_CHANGES):
        gui.run("edit('DeformedPoints', moved.ravel().tolist())")
        gui.run(f"before = rendered_picture(); {change}; edited = rendered_picture()")
        gui.screenshot(f"{number}_pending")
        assert gui.value("volumes()") == ["vtkVolume"], change
        assert gui.value("bool(np.isclose(step_of(drawn[0]), usual_step(drawn[0]._source)))"), (
            change
        )
        gui.run("deform.DeformedPoints = moved.ravel().tolist()")
        gui.run("simple.UpdatePipeline(proxy=deform); applied = rendered_picture()")
        gui.screenshot(f"{number}_applied")
        assert gui.value("volumes() == own"), change
        gui.run("deform.DeformedPoints = rest.ravel().tolist()")
        assert gui.value("changed_share(before, edited)") > 5, change
        difference = gui.value("float(abs(edited - applied).mean())")
        print(f"{change}: {difference:.2f} of 255")
        assert difference < 1, change


@pytest.mark.matrix
def test_a_volume_steps_unseen_from_drag_to_apply(gui):
    """A map of 64 nodes during the drag, of about 128 after it, then the result of Apply."""
    gui.run("wavelet.WholeExtent = [-32, 31, -32, 31, -32, 31]; wavelet.UpdatePipeline()")
    gui.run("volume = values(wavelet).copy()")
    gui.run(LIVE)
    begin(gui, "wavelet", ("POINTS", "RTData"))
    # Apply brings background into the corner, whose 0 would widen the range of colors
    gui.run("simple.GetColorTransferFunction('RTData').AutomaticRescaleRangeMode = 'Never'")
    gui.run("display.SetRepresentationType('Volume'); pictures = [rendered_picture()]")
    with gui.dragging((31, 31, -0.5), (160, 120)):
        gui.until("dragged() and drawn and drawn[2] == 64")
        gui.run("pictures.append(rendered_picture())")
    gui.until("drawn[2] > 100")  # fewer than 128 if the first map waited for kernels
    gui.run("pictures.append(rendered_picture())")
    gui.press("alt+a")
    gui.until("is_bent()")
    gui.run("pictures.append(rendered_picture())")
    gui.screenshot("applied")
    changes = gui.run("""
changes = [abs(a - b) for a, b in zip(pictures, pictures[1:])]
answer = [[float(c.mean()), float(np.percentile(c, 99))] for c in changes]""")
    print(*(f"mean {mean:.2f}, p99 {p99:.0f} of 255" for mean, p99 in changes), sep="; ")
    edited, let_go, applied = changes
    assert edited[0] > 1
    for mean, p99 in (let_go, applied):
        assert mean < edited[0] / 2
        assert mean <= 1
        assert p99 <= 8


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
