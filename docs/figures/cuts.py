"""A half-plane: who acts on whom, and the void that opens."""

import matplotlib.pyplot as plt
import numpy as np
from figures.drawing import MOVED, deformation, frame, grid, handles

import vtk_mls

rest = [(-1.2, 1.2), (1.2, 1.2), (-1.2, -1.2), (1.2, -1.2)]
deformed = [(-1.6, 1.1), (1.6, 1.1), *rest[2:]]
cut = vtk_mls.HalfPlane((0, -0.6, 0), normal=(1, 0, 0), inward=(0, 1, 0))
_, panels = plt.subplots(1, 3, figsize=(8.4, 2.9))
for axes, cuts, title in zip(panels, ((), (cut,)), ("without a cut", "with a half-plane")):
    d = deformation(rest, deformed, cuts=cuts)
    grid(axes, d, count=18)
    handles(axes, rest, deformed)
    frame(axes, title, 2.8)
panels[1].plot(0, -0.6, "x", color="crimson")

# the void, and the distance whose zero level is its face
u = np.linspace(-2.8, 2.8, 221)
x, y = np.meshgrid(u, u)
distance = d.void_distance(np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()])).reshape(x.shape)
panels[2].contourf(x, y, distance, np.linspace(-1.2, 1.2, 25), cmap="RdBu", extend="both")
panels[2].contour(x, y, distance, [0], colors=MOVED, linewidths=2)
frame(panels[2], "VoidDistance; its zero level", 2.8)
