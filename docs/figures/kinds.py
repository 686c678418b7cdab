"""Four control points, two of them dragged apart: each kind of map."""

import matplotlib.pyplot as plt
from figures.drawing import deformation, frame, grid, handles

rest = [(-1.3, -1.3), (-1.3, 1.3), (0.7, -0.7), (0.7, 0.7)]
deformed = [*rest[:2], (0.9, -0.95), (0.9, 0.95)]
_, panels = plt.subplots(1, 4, figsize=(8.4, 2.3))
for axes, kind in zip(panels, ("affine", "similarity", "rigid", "polynomial")):
    grid(axes, deformation(rest, deformed, kind=kind))
    handles(axes, rest, deformed)
    frame(axes, kind)
