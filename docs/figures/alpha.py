"""How local a control point is: three values of alpha."""

import matplotlib.pyplot as plt
from figures.drawing import deformation, frame, grid, handles

rest = [(-1.5, -1.5), (1.5, -1.5), (-1.5, 1.5), (1.5, 1.5), (0, 0)]
deformed = [*rest[:4], (0.7, 0.35)]
_, panels = plt.subplots(1, 3, figsize=(7.4, 2.6))
for axes, alpha in zip(panels, (0.6, 1, 2)):
    grid(axes, deformation(rest, deformed, kind="rigid", alpha=alpha))
    handles(axes, rest, deformed)
    frame(axes, f"alpha = {alpha}")
