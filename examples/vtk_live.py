"""Drawn while it moves
====================

Draw a volume and a mesh as they are opened along a cut, without resampling.

You will see a block and the shells in it, pulled apart: the last of eight pictures that a dragged
handle would draw. The end checks that each of them sent only a map to the graphics card, and the
volume went there once.

Run: python examples/vtk_live.py [picture.png]
"""

import sys

import numpy as np
import pyvista as pv

from vtk_mls import Deformation, HalfPlane
from vtk_mls.rendering import DeformedMesh, DeformedVolume

picture = sys.argv[1] if len(sys.argv) > 1 else "live.png"
if not picture.endswith(".png"):
    sys.exit(f"the picture must be a .png file, got `{picture}`")

block = pv.Wavelet(extent=(-32, 32) * 3, std=0.4)
plotter = pv.Plotter(off_screen=True, window_size=(600, 600))
plotter.background_color = "#1a1f29"
# a vtkVolume and a vtkActor, as any program of VTK has
volume = plotter.add_volume(
    block, cmap="coolwarm", opacity=[0, 0.4, 0.6, 0.7], opacity_unit_distance=1, mapper="gpu"
)
volume.mapper.SetAutoAdjustSampleDistances(False)
volume.mapper.SetSampleDistance(2)  # coarse while it moves
volume.prop.SetShade(True)
volume.prop.SetAmbient(0.4)
actor = plotter.add_mesh(block.contour([200]), color="tan")
plotter.remove_scalar_bar()
plotter.camera_position = [(85, -170, 145), (0, 0, 0), (0, 0, 1)]

# the corners of a box, of which the right ones are pulled away from the left ones
rest = np.array([(x, y, z) for x in (-28, 28) for y in (-28, 28) for z in (-28, 28)], float)
cut = HalfPlane((0, 0, -10), (1, 0, 0), (0, 0, 1))
shown = [DeformedVolume(volume, plotter.renderer), DeformedMesh(actor)]
for distance in np.linspace(0, 14, 8):  # what an observer of a dragged handle would do
    deformed = rest + (rest[:, :1] > 0) * [distance, 0, 0]
    deformation = Deformation(rest, deformed, cuts=cut)
    for drawn in shown:
        drawn.update(deformation)
    plotter.render_window.Render()

volume.mapper.SetSampleDistance(0.4)
plotter.screenshot(picture)
print(f"{shown[0].uploads} moves, as many maps on the graphics card, the volume once")
assert shown[0].failure is None
assert shown[0].uploads == 8
