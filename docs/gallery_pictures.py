"""What the gallery shows: pictures that an example writes, in an order that is worth reading."""

from __future__ import annotations

import shutil
from pathlib import Path

from sphinx_gallery.scrapers import figure_rst

# first what one comes for; what is not named here follows
ORDER = (
    "four_kinds",
    "cut_and_opened",
    "cube_in_columns",
    "brain",
    "tetrahedra",
    "mesh_and_image",
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
    folder = Path(variables["src_file"]).parent
    shown = []
    for file in sorted([*folder.glob("*.png"), *folder.glob("*.gif")]):
        target = Path(next(variables["image_path_iterator"])).with_suffix(file.suffix)
        shutil.move(file, target)
        shown.append(str(target))
    return figure_rst(shown, configuration["src_dir"])
