"""Draw docs/tutorial/*.png and docs/paraview.png: `python docs/paraview_tutorial.py`, where `make
test` has run.

You will see each click that bends a brain and cuts it open, by the mouse in the newest ParaView
that the tests find, with a ring where the mouse is; and before, while and after in one picture.
"""

from __future__ import annotations

import subprocess
import time

from paraview_animation import NEWEST, PROJECT

# isort: split
from gui import running
from gui_scenes import BRAIN, vtk_mls_command, write_brain
from paraviews import PICTURES, virtual_display

FOLDER = PICTURES / "tutorial"
WIDTH = 900
VIEW, HEIGHT = "914x792+358+196", 560  # where it is on the screen; of the picture of three
CLICKS = {
    "filters": "menu_item('Filters')",
    "mls_deform": "menu_item('MLS Deform')",
    "cut_type": "drop_down('CutType')",
    "plane": "option('CutType', 'plane')",
}


def draw(folder, three):
    """Draw the pictures into a folder, and the file of three."""
    folder.mkdir(exist_ok=True)
    brain, shots = write_brain(FOLDER / "brain.vti", step=1), {}
    with (
        virtual_display() as display,
        running(NEWEST, PROJECT, FOLDER, display, vtk_mls_command(brain)) as gui,
    ):

        def keep(name, marked=True):
            for _ in range(2):  # by then what the mouse did is drawn
                gui.value("1")
            shots[name] = gui.screenshot(name)
            convert(shots[name], folder / f"{name}.png", gui.pointer if marked else None)

        gui.run(BRAIN)
        gui.run("simple.GetDisplayProperties(file, view).SetScalarBarVisibility(view, False)")
        gui.run("simple.Render(view)")
        keep("opened", marked=False)
        for name, place in CLICKS.items():
            if name == "mls_deform":
                gui.hover("menu_item('MLS Deformation')")
            gui.hover(place)
            keep(name)
            gui.click(place)
        gui.run("deform = simple.GetActiveSource()")
        with gui.dragging(*gui.value("drag_of_the_tutorial()")):
            gui.until("dragged()")
            keep("drag")
        gui.hover("button('Apply')")
        keep("apply")
        gui.click("button('Apply')")
        gui.until("output(deform) and is_cut() and is_bent()")
        for _ in range(5):  # it goes on to show it
            time.sleep(1)
            gui.run("simple.Render(view)")
        keep("done", marked=False)
    put_together(*(shots[name] for name in ("opened", "drag", "done")), three)


def put_together(before, during, after, file):
    """The view before, the window during, and the view after a drag, side by side."""
    size = ["-resize", f"x{HEIGHT}"]
    of_view = ["-crop", VIEW, "+repage", *size]
    parts = ["(", before, *of_view, ")", "(", during, *size, ")", "(", after, *of_view, ")"]
    looks = ["+append", "+dither", "-colors", "128"]
    subprocess.run(["convert", *parts, *looks, file], check=True)


def convert(shot, file, pointer):
    """A screenshot as a small picture, with a ring round the mouse."""
    ring = []
    if pointer is not None:
        x, y = pointer
        circle = f"circle {x},{y} {x + 26},{y}"
        ring = ["-fill", "none", "-stroke", "#ff2060", "-strokewidth", "6", "-draw", circle]
    looks = ["-resize", f"{WIDTH}x", "+dither", "-colors", "96"]
    subprocess.run(["convert", shot, *ring, *looks, file], check=True)


if __name__ == "__main__":
    draw(PROJECT / "docs/tutorial", PROJECT / "docs/paraview.png")
