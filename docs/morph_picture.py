"""Draws docs/morphed.png: the mesh of the page docs/morph.md, before and after.

Run: python docs/morph_picture.py, with `.[docs,cpu]` installed.
"""

import os
import re
import tempfile
from pathlib import Path

import numpy as np
import pyvista as pv

DOCS = Path(__file__).parent
page = (DOCS / "morph.md").read_text(encoding="utf-8")
variables = {}
with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)  # the code saves files
    exec(re.search(r"```python\n(.*?)```", page, re.DOTALL)[1], variables)
    os.chdir(DOCS)
boundary, box, moved = (variables[name] for name in ("boundary", "box", "moved"))
box["volume"], moved["volume"] = np.ones(box.n_cells), variables["quality"]

before = boundary.points
plotter = pv.Plotter(shape=(1, 2), border=False, window_size=(1500, 640), off_screen=True)
colors = {
    "cmap": "PuOr_r",
    "clim": (0.4, 1.6),
    "scalars": "volume",
    "show_edges": True,
    "lighting": False,
}
after = before + boundary["Displacement"]
shown = (("before", box, before), ("after: volume of the cells, before = 1", moved, after))
for column, (title, mesh, points) in enumerate(shown):
    plotter.subplot(0, column)
    plotter.set_background("#12161f")
    middle = np.array(box.center)
    part = mesh.extract_cells(np.flatnonzero(box.cell_centers().points[:, 1] > middle[1]))
    bar = {"title": "", "color": "white", "n_labels": 3, "fmt": "%.1f"}
    plotter.add_mesh(part, show_scalar_bar=column == 1, scalar_bar_args=bar, **colors)
    plotter.add_points(
        points[points[:, 1] >= middle[1]],
        color="orange",
        point_size=11,
        render_points_as_spheres=True,
    )
    plotter.add_text(title, font_size=15, color="white", position="upper_edge")
    plotter.camera_position = [middle + (15, -36, 19), middle + (0, 0, 0.8), (0, 0, 1)]
plotter.screenshot(str(DOCS / "morphed.png"))
