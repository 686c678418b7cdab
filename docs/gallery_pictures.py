"""What the gallery shows: pictures that an example writes, in an order that is worth reading."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
from PIL import Image
from sphinx_gallery.scrapers import figure_rst
from vtkmodules.util.numpy_support import vtk_to_numpy

# first what one comes for; what is not named here follows
ORDER = (
    "posed_bones",
    "straightened",
    "landmark_match",
    "whole_turn",
    "four_kinds",
    "cut_and_opened",
    "cube_in_columns",
    "brain",
    "tetrahedra",
    "mesh_and_image",
    "local_drag",
    "animation",
    "label_volume",
    "many_handles",
    "field_for_itk",
    "vtk_live",
    "pyvista_deform",
    "vtk_deform",
    "cut_open",
    "numpy_deform",
)


def _layers(made):
    """Of `cut_open`: at rest, and deformed with the void left white."""
    shape = made["array"]("Void").shape
    layers = vtk_to_numpy(made["layers"].GetOutput().GetPointData().GetScalars())
    deformed = np.where(made["array"]("Void"), np.nan, made["array"]("ImageScalars"))
    return layers.reshape(shape), deformed


# Volumes that examples without a picture have made, from their variables.
VOLUMES = {
    "cut_open": _layers,
    "numpy_deform": lambda made: (made["volume"], made["bent"]),
    "vtk_deform": lambda made: (made["before"], made["after"]),
}


class Order:
    """Sorts the files of the gallery."""

    def __init__(self, folder):
        pass

    def __repr__(self):
        return "Order"

    def __call__(self, name):
        stem = Path(name).stem
        return ORDER.index(stem) if stem in ORDER else len(ORDER)


def written(block, variables, configuration):
    """Take the pictures that a block of an example has left, and show them."""
    source = Path(variables["src_file"])
    folder, shown = source.parent, []
    if source.stem in VOLUMES and block[0] == "code":
        volumes = VOLUMES[source.stem](variables["example_globals"])
        _slices(volumes).save(folder / f"{source.stem}.png")
    for file in sorted([*folder.glob("*.png"), *folder.glob("*.gif")]):
        target = Path(next(variables["image_path_iterator"])).with_suffix(file.suffix)
        shutil.move(file, target)
        shown.append(str(target))
    return figure_rst(shown, configuration["src_dir"])


def _slices(volumes, height=420, gap=40):
    """The middles of volumes (nz, ny, nx), seen along y, beside each other; NaN is white."""
    slices = [volume[::-1, volume.shape[1] // 2].astype(float) for volume in volumes]
    low, high = min(map(np.nanmin, slices)), max(map(np.nanmax, slices))
    tiles = []
    for values in slices:
        levels = ((values - low) / (high - low))[..., None]
        blue, orange = np.array([24, 43, 73]), np.array([247, 178, 91])
        colors = np.where(np.isnan(levels), 255, (1 - levels) * blue + levels * orange)
        tile = Image.fromarray(colors.round().astype(np.uint8))
        width = height * values.shape[1] // values.shape[0]
        tiles.append(tile.resize((width, height), Image.Resampling.BICUBIC))
    starts = np.cumsum([0, *(tile.width + gap for tile in tiles)])
    picture = Image.new("RGB", (int(starts[-1]) - gap, height), "white")
    for tile, start in zip(tiles, starts.tolist()):
        picture.paste(tile, (start, 0))
    return picture
