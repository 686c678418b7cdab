"""A surface and its Transform as a rigid region, in ParaView's GUI."""

from __future__ import annotations

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
        gui.find_and_click("drop_down", name)
        gui.click(f"option({name!r}, {choice!r})")
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
