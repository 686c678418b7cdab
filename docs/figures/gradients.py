"""Gradients of a deformed image: carried along only, and transformed by the Jacobian."""

import matplotlib.pyplot as plt
import numpy as np
from figures.drawing import MOVED, STILL, deformation, frame

rest = [(-1.6, -1.6), (1.6, -1.6), (-1.6, 1.6), (1.6, 1.6), (-0.7, 0), (0.7, 0)]
deformed = [*rest[:4], (-0.4, 0.6), (0.4, -0.6)]
d = deformation(rest, deformed)

u = np.linspace(-1.9, 1.9, 241)
x, y = np.meshgrid(u, u)


def origins(x, y):
    return d.backward(np.column_stack([np.ravel(x), np.ravel(y), np.zeros(np.size(x))]))


layers = np.sin(5 * origins(x, y)[:, 1]).reshape(x.shape)
s, t = np.meshgrid(np.linspace(-1.4, 1.4, 9), np.linspace(-1.4, 1.4, 9))
slope = np.zeros((s.size, 3))
slope[:, 1] = np.cos(5 * origins(s, t)[:, 1])  # of the undeformed image
jacobian = d.jacobian(np.column_stack([s.ravel(), t.ravel(), 0 * s.ravel()]))
right = np.einsum("nij,ni->nj", jacobian, slope)

_, panels = plt.subplots(1, 2, figsize=(7.4, 3.5))
titles = ("carried along: wrong", "times the Jacobian, Eq. 29")
for axes, arrows, color, title in zip(panels, (slope, right), (STILL, MOVED), titles):
    axes.pcolormesh(x, y, layers, cmap="gray", vmin=-2, vmax=1.5, rasterized=True)
    axes.quiver(s, t, arrows[:, 0], arrows[:, 1], color=color, scale=16, width=0.008)
    frame(axes, title, 1.9)
