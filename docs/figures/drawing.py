"""What the figures share: the plane z = 0 of a deformation, as a grid of lines that it moves."""

from __future__ import annotations

import numpy as np

import vtk_mls

MOVED, STILL, LINE = "#e07b16", "#2b6cb0", "#5f6b7a"


def plane(points):
    """Points (x, y) of the plane, doubled above and below so that the map there stays in it."""
    points = np.asarray(points, float)
    layers = [np.column_stack([points, np.full(len(points), z)]) for z in (-1, 0, 1)]
    return np.vstack(layers)


def deformation(rest, deformed, **options):
    """The deformation of control points in the plane."""
    return vtk_mls.Deformation(plane(rest), plane(deformed), **options)


def moved(d, points):
    """Where the material at (x, y) goes."""
    flat = np.column_stack([*np.asarray(points, float).T, np.zeros(len(points))])
    return d.forward(flat)[:, :2]


def grid(axes, d, extent=2.0, count=17):
    """Draw lines of the material as they are moved."""
    along = np.linspace(-extent, extent, 161)
    for level in np.linspace(-extent, extent, count):
        for line in ((along, np.full_like(along, level)), (np.full_like(along, level), along)):
            x, y = moved(d, np.stack(line, axis=1)).T.copy()
            torn = np.hypot(np.diff(x), np.diff(y)) > 0.2
            x[1:][torn] = np.nan
            axes.plot(x, y, color=LINE, linewidth=0.7)


def handles(axes, rest, deformed):
    """Draw control points, and from where those that were dragged come."""
    for (x, y), (u, v) in zip(np.asarray(rest, float), np.asarray(deformed, float)):
        dragged = (x, y) != (u, v)
        if dragged:
            axes.plot([x, u], [y, v], color=MOVED, linewidth=1.5)
            axes.plot(x, y, "o", color="white", markeredgecolor=MOVED, markersize=5)
        axes.plot(u, v, "o", color=MOVED if dragged else STILL, markersize=7, zorder=3)


def frame(axes, title, extent=2.4):
    axes.set_title(title)
    axes.set_aspect("equal")
    axes.set_xlim(-extent, extent)
    axes.set_ylim(-extent, extent)
    axes.axis("off")
