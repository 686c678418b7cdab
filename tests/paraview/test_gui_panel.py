"""The panel of MLS Deform: which properties it shows, and its inputs, by mouse.

A surface and its Transform are a rigid region.
"""

from __future__ import annotations

from gui_scenes import BALL, PROJECT, SETUP, noise, require_qt

FIRST_PAGE = sorted(
    ["ControlPoints", "Kind", "Alpha", "Smoothing", "Steps", "Blend", "CutType", "Drag"]
    + ["InteractivePolyLine"]
)
SHOWN = "__import__('gui_places').properties_beside('Kind')"
OF_IMAGES = {"Reference", "Background", "AutomaticBackground", "OutputGrid", "GradientArray"}
OF_MESHES = {"GenerateCellQuality", "GenerateLargestBlend"}
OF_CUTS = {"Nu", "CutFrame"}
SPHERE = """
ball = simple.Sphere(registrationName="Ball")
moved = simple.Transform(registrationName="Moved", Input=ball)
moved.Transform.Translate = [3.0, 0.0, 0.0]
moved.UpdatePipeline()
simple.SetActiveSource(wavelet)
"""
SHIFT = """#Insight Transform File V1.0
#Transform 0
Transform: AffineTransform_double_3_3
Parameters: 1 0 0 0 1 0 0 0 1 2 0 0
FixedParameters: 0 0 0
"""


def choose(gui, name, source):
    gui.find_and_click("drop_down", name)
    gui.click(f"option({name!r}, {source!r})")


def test_the_first_page_is_short(gui):
    """Properties of images, of meshes and of cuts are shown for these alone."""
    require_qt(gui)
    gui.add_deform()
    assert gui.value(SHOWN) == FIRST_PAGE
    gui.screenshot("1_image")
    gui.run("edit('CutType', ['half-plane'])")
    gui.until(f"{SHOWN} == {sorted([*FIRST_PAGE, 'CutInward', 'InteractivePlane'])}")
    gui.screenshot("2_cut")
    gui.click("tool('AdvancedButton')")
    gui.until(f"'Device' in {SHOWN}")
    assert {*gui.value(SHOWN)} >= OF_IMAGES | OF_CUTS | {"HideVoid", "VoidValues", "Live", "Cuts"}
    assert not {*gui.value(SHOWN)} & (OF_MESHES | {"SplitCells"})
    gui.run("edit('CutType', ['none'])")
    gui.until(f"'Nu' not in {SHOWN}")
    assert not {*gui.value(SHOWN)} & (OF_CUTS | {"HideVoid", "VoidValues"})
    gui.run("deform.Cuts = [simple.Plane(), simple.Plane()]; simple.SetActiveSource(deform)")
    gui.until(f"{ {'HideVoid', 'ConnectedCuts', *OF_CUTS} } <= {{*{SHOWN}}}")
    gui.run("simple.RenameSource('Left', deform.Cuts[0])")
    gui.until("deform.ConnectedCuts == 'Left, Plane2'")
    gui.screenshot("3_two_cuts")
    gui.run("deform.Cuts = []; simple.SetActiveSource(deform)")
    gui.until(f"not {{'Nu', 'ConnectedCuts'}} & {{*{SHOWN}}}")
    gui.click("tool('AdvancedButton')")

    gui.run(BALL.replace("simple.Delete(wavelet)", "simple.Hide(wavelet, view)"))
    gui.add_deform()
    gui.until(f"{SHOWN} == {FIRST_PAGE}")
    gui.screenshot("4_mesh")
    gui.click("tool('AdvancedButton')")
    gui.until(f"'Device' in {SHOWN}")
    assert {*gui.value(SHOWN)} >= OF_MESHES
    assert not {*gui.value(SHOWN)} & (OF_IMAGES | OF_CUTS | {"HideVoid", "SplitCells"})
    gui.click("tool('AdvancedButton')")


def test_settings_of_a_kind_are_shown_with_it(gui):
    require_qt(gui)
    gui.add_deform()
    others = {*FIRST_PAGE} - {"Alpha"}
    for kind, expected in (
        ("spline", {"Order"}),
        ("tps", set()),
        ("auto", {"Alpha", "Order"}),
        ("polynomial", {"Alpha", "Degree"}),
    ):
        choose(gui, "Kind", kind)
        gui.until(f"{SHOWN} == {sorted(others | expected - {'Order'})}")
        gui.screenshot(kind)
        gui.click("tool('AdvancedButton')")
        gui.until(f"'Device' in {SHOWN}")
        assert {*gui.value(SHOWN)} & {"Alpha", "Degree", "Order"} == expected
        gui.click("tool('AdvancedButton')")


def test_inputs_are_connected_and_disconnected_in_the_panel(gui):
    """A surface, and its Transform, which is further down in the pipeline browser."""
    require_qt(gui)
    gui.run(SPHERE)
    gui.add_deform()
    inputs = "[bool(points) for points in (deform.ControlPoints, deform.DeformedControlPoints)]"
    for _ in range(2):
        choose(gui, "ControlPoints", "Ball")
        choose(gui, "DeformedControlPoints", "Moved")
        gui.click("button('Apply')")
        gui.until("is_bent()")
        gui.screenshot("1_connected")
        assert gui.value(inputs) == [True, True]
        choose(gui, "ControlPoints", "(none)")
        gui.click("button('Apply')")
        gui.until("is_straight()")
        assert gui.value(inputs) == [False, False]
    gui.screenshot("2_disconnected")


def test_a_transform_file_moves_the_material(gui):
    require_qt(gui)
    (PROJECT / gui.folder / "shift.tfm").write_text(SHIFT)
    gui.add_deform()
    gui.click("tool('AdvancedButton')")
    gui.find_and_click("field", "InitialTransform")
    gui.type(f"{gui.folder}/shift.tfm")
    gui.screenshot("1_entered")
    gui.press("alt+a")
    gui.until("is_bent()")
    gui.run("before, after = (array.reshape(21, 21, 21) for array in (volume, values(deform)))")
    assert gui.value("np.array_equal(after[:, :, :-2], before[:, :, 2:])")
    gui.click("tool('AdvancedButton')")


def test_a_filter_does_not_take_its_own_output(start):
    with start() as gui:
        require_qt(gui)
        gui.run(SETUP)
        gui.add_deform()
        gui.run("clip = simple.Clip(Input=deform); simple.SetActiveSource(deform)")
        choose(gui, "ControlPoints", "Clip1")
        gui.click("button('Apply')")
        gui.until("deform.ControlPoints is None")
        assert "Control Points cannot be the output of this filter" in gui.printed
        assert noise(gui) == []


REGION = """
sphere = simple.Sphere(registrationName="Bone", Radius=5.0, ThetaResolution=24, PhiResolution=24)
turned = simple.Transform(registrationName="Turned", Input=sphere)
turned.Transform.Rotate = [0.0, 0.0, 40.0]
simple.Show(turned, view)
simple.SetActiveSource(wavelet)
"""
CHOICES = {"ControlPoints": "Bone", "DeformedControlPoints": "Turned", "HandleShapes": "cells"}
LIMITED = """
deform.MaskBall = [0.0, 0.0, 0.0, 6.0, 3.0]
deform.MapTolerance = 0.0
"""
INSIDE = """
from vtk_mls import Deformation, Grid, RegionHandle, Ball

def error_inside(degrees):
    \"\"\"Largest difference to the image that is turned as a whole, inside of the sphere.\"\"\"
    turn = np.eye(4)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn[:2, :2] = (c, -s), (s, c)
    image = output(deform)
    if image is None:
        return np.inf
    grid = Grid(image.GetDimensions(), image.GetPoint(0), image.GetSpacing())
    whole = Deformation(handles=[RegionHandle(Ball((0, 0, 0), 99), turn)])
    (expected,) = whole.resample([volume.reshape(grid.shape)], grid)
    distance = np.linalg.norm(grid.points(), axis=1)
    change = np.abs(values(deform) - expected.ravel())
    return float(change[distance < 4.5].max())

def is_outside_still():
    image = output(deform)
    distance = [np.linalg.norm(image.GetPoint(i)) for i in range(image.GetNumberOfPoints())]
    far = np.array(distance) > 9.01
    return bool((values(deform) == volume)[far].all())
"""


def test_a_region_turns_with_its_transform(gui):
    gui.run(REGION + INSIDE)
    gui.add_deform(apply=False)
    gui.run(LIMITED)
    for name, choice in CHOICES.items():
        choose(gui, name, choice)
    gui.press("alt+a")
    gui.until("error_inside(40) < 0.1")
    assert gui.value("deform.HandleShapes == 'cells'")
    assert gui.value("is_bent() and is_outside_still()")
    gui.screenshot("1_turned")

    gui.run("turned.Transform.Rotate = [0.0, 0.0, -25.0]; simple.Render(view)")
    gui.until("error_inside(-25) < 0.1")
    assert gui.value("error_inside(40) > 10 and is_outside_still()")
    gui.screenshot("2_turned_back")
    gui.run("simple.SetActiveSource(turned)")
    gui.screenshot("3_transform")
