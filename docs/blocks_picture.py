"""Draws docs/blocks.png: a brain in blocks, deformed, and the part of the input that a block reads.

Run: `python docs/blocks_picture.py`, with `.[docs]`.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Rectangle
from PIL import Image
from vtkmodules.util.numpy_support import vtk_to_numpy

from vtk_mls import Deformation, Grid, Sampling, io
from vtk_mls.commands import demo
from vtk_mls.dask import resample

CHUNK = 64
BLOCK = (2, 2, 1)  # z, y, x: the block whose input is shown
COLUMN = 98  # x of the slice
BACKGROUND, LINES, SHOWN = "#12161f", "#5f7391", "#ff9d3c"
# y and z of the handles in the slice at rest, and their displacements; those that rest hold
REST = ((205, 110), (20, 90), (110, 20), (110, 155), (60, 150))
DRAGS = ((-12, 48), (0, 0), (0, 0), (-8, 0), (0, 0))


class Recorder:
    """An array of an image that records the part that is read."""

    def __init__(self, values):
        self._values, self.part = values, None
        self.shape, self.dtype, self.ndim = values.shape, values.dtype, values.ndim

    def __getitem__(self, part):
        self.part = part
        return self._values[part]


def brain():
    """The brain (nz, ny, nx), in voxels of 1 mm."""
    image = io.read_dataset(demo.brain_file())
    shape = image.GetDimensions()[::-1]
    values = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(shape)
    return np.ascontiguousarray(values[:, ::-1]).astype(np.float32)  # y to the front


def panel(axes, image, title):
    """Draw a slice, its blocks and a title."""
    axes.imshow(image, cmap="gray", origin="lower", vmin=0, vmax=np.percentile(image, 99.5))
    for place in np.arange(CHUNK, image.shape[1], CHUNK):
        axes.axvline(place - 0.5, color=LINES, linewidth=0.8)
    for place in np.arange(CHUNK, image.shape[0], CHUNK):
        axes.axhline(place - 0.5, color=LINES, linewidth=0.8)
    axes.set_title(title, color="white", fontsize=13)
    axes.axis("off")


def outline(axes, part):
    """Draw a part of the slice: slices along z and y."""
    rows, columns = part[:2]
    size = columns.stop - columns.start, rows.stop - rows.start
    corner = columns.start - 0.5, rows.start - 0.5
    axes.add_patch(Rectangle(corner, *size, edgecolor=SHOWN, facecolor="none", linewidth=2.2))


def draw(file):
    """Draw the picture."""
    image = Recorder(brain())
    grid = Grid(image.shape[::-1])
    rest = np.array([(COLUMN + x, y, z) for x in (-30, 0, 30) for y, z in REST], float)
    deformed = rest + np.array([(0, *drag) for _ in range(3) for drag in DRAGS])
    bent = resample(image, Deformation(rest, deformed), Sampling(grid), chunks=CHUNK)
    bent.blocks[BLOCK].compute()
    part = image.part
    whole = bent.compute()
    figure, panels = plt.subplots(1, 2, figsize=(12, 5.4), facecolor=BACKGROUND)
    panel(panels[0], image[:][:, :, COLUMN], "the brain: the part that one block needs")
    outline(panels[0], part)
    panel(panels[1], whole[:, :, COLUMN], "deformed, block by block")
    block = [slice(i * CHUNK, min((i + 1) * CHUNK, n)) for i, n in zip(BLOCK, image.shape)]
    outline(panels[1], block)
    figure.subplots_adjust(0.01, 0.02, 0.99, 0.93, 0.03)
    figure.savefig(file, dpi=100, facecolor=BACKGROUND)
    plt.close(figure)
    # the method keeps colors that few pixels have
    picture = Image.open(file).convert("RGB").quantize(64, method=Image.Quantize.MAXCOVERAGE)
    picture.save(file, optimize=True)


if __name__ == "__main__":
    draw(Path(__file__).with_name("blocks.png"))
