"""How local a control point is, and how exactly it is met: values of alpha and smoothing."""

import matplotlib.pyplot as plt
from figures.drawing import deformation, frame, grid, handles

rest = [(-1.5, -1.5), (1.5, -1.5), (-1.5, 1.5), (1.5, 1.5), (0, 0)]
deformed = [*rest[:4], (0.5, 0.25)]
_, panels = plt.subplots(1, 4, figsize=(8.4, 2.4))
for axes, alpha, smoothing in zip(panels, (1, 2, 3, 2), (0, 0, 0, 0.8)):
    grid(axes, deformation(rest, deformed, alpha=alpha, smoothing=smoothing))
    handles(axes, rest, deformed)
    frame(axes, f"alpha {alpha}, s = {smoothing}" if smoothing else f"alpha {alpha}")
