"""Backward and forward: one map and its inverse, and what swapping p and q would do."""

import matplotlib.pyplot as plt
import numpy as np
from figures.drawing import deformation, frame, handles, moved

rest = [(-1.5, -1.5), (1.5, -1.5), (-1.5, 1.5), (1.5, 1.5), (0, 0)]
deformed = [*rest[:4], (0.9, 0.5)]
d, swapped = deformation(rest, deformed), deformation(deformed, rest)

angle = np.linspace(0, 2 * np.pi, 400)
circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
_, panels = plt.subplots(1, 3, figsize=(8.4, 2.9))
u = np.linspace(-2.2, 2.2, 301)
x, y = np.meshgrid(u, u)
origin = d.backward(np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]))
image = np.hypot(*origin.T[:2]).reshape(x.shape) < 1  # a disc, resampled backward
curves = (
    ("a disc, and its outline at rest", np.hypot(x, y) < 1, circle),
    ("image backward, outline forward", image, moved(d, circle)),
    ("outline by swapping p and q", image, swapped.backward(np.c_[circle, 0 * angle])[:, :2]),
)
for axes, (title, disc, (*line,)) in zip(panels, curves):
    axes.contourf(x, y, disc, [0.5, 1.5], colors=["#bcd4ea"])
    axes.plot(*np.transpose(line), color="crimson", linewidth=1.6)
    handles(axes, rest, rest if title.startswith("a disc") else deformed)
    frame(axes, title, 2.2)
