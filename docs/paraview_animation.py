"""Draw docs/paraview.gif: `python docs/paraview_animation.py`, where `make test` has run.

You will see a brain that is cut by a half-plane and opened by two drags, by the mouse in the
newest ParaView that the tests find; nothing is applied.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

PROJECT = Path(__file__).parents[1]
sys.path.append(str(PROJECT / "tests/paraview"))

from gui import running  # noqa: E402
from gui_scenes import BRAIN, vtk_mls_command, write_brain  # noqa: E402
from paraviews import PARAVIEWS, PICTURES, virtual_display  # noqa: E402

# the others are for `make matrix`
(NEWEST,) = (
    parameters.values[0]
    for parameters in PARAVIEWS
    if "matrix" not in [m.name for m in parameters.marks]
)
FOLDER = PICTURES / "animation"
VIEW = "868x756+358+192"  # where it is on the screen
PULLS = {(176, 116, 170): (5, -2), (20, 116, 170): (-5, -2)}  # pixels a step, of handles
STEPS = 20
LOOK = """
shown = simple.GetDisplayProperties(file, view)
colors, opacity = simple.GetColorTransferFunction("T1"), simple.GetOpacityTransferFunction("T1")
colors.RGBPoints = [0, 0.2, 0.1, 0.1, 60, 0.55, 0.25, 0.2, 110, 0.85, 0.6, 0.5, 170, 1, 0.93, 0.88]
opacity.Points = [0, 0, 0.5, 0, 65, 0, 0.5, 0, 100, 0.8, 0.5, 0, 255, 1, 0.5, 0]
shown.Shade = 1
shown.SetScalarBarVisibility(view, False)
view.OrientationAxesVisibility = 0
view.GetActiveCamera().Elevation(-25)
view.GetActiveCamera().Zoom(1.25)
simple.Render(view)
"""
CUT = """
deform = simple.GetActiveSource()
sides = [[x, y, z] for x in (20, 176) for y, z in ((116, 170), (20, 40), (212, 40))]
deform.RestPoints = deform.DeformedPoints = sum(sides, [])
deform.CutType = "half-plane"
deform.CutInward = [0, 0, 1]
deform.CutOrigin = [98, 116, 60]
"""


def draw(file):
    """Draw the animation."""
    brain = write_brain(FOLDER / "brain.vti", step=1)
    frames = []
    with (
        virtual_display() as display,
        running(NEWEST, PROJECT, FOLDER, display, vtk_mls_command(brain)) as gui,
    ):

        def keep():
            for _ in range(2):  # by then what the mouse did is drawn
                gui.value("1")
            frames.append(gui.screenshot(f"frame{len(frames)}"))

        gui.run(BRAIN + LOOK)
        gui.launch("MLS Deform")
        gui.run(CUT)
        gui.click("check_box('Show Plane')")
        gui.run("simple.Render(view)")
        keep()
        for place, step in PULLS.items():
            with gui.dragging(place, step):
                for _ in range(STEPS):
                    gui.move(step)
                    keep()
            keep()
    still, moving, end = (["-delay", delay] for delay in ("100", "6", "200"))
    looks = ["-crop", VIEW, "+repage", "-resize", "560x", "+dither", "-colors", "64"]
    shown = [*still, frames[0], *moving, *frames[1:], *end, frames[-1], *looks]
    subprocess.run(["convert", *shown, "-layers", "optimize", file], check=True)


if __name__ == "__main__":
    draw(PROJECT / "docs/paraview.gif")
