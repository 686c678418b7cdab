"""A brain in a file as users have it, where its handles are seen, and whether it was cut open."""

from __future__ import annotations

import ast
import re
import shutil

import numpy as np
from vtkmodules.vtkIOImage import vtkPNGReader
from vtkmodules.vtkRenderingCore import vtkRenderWindow

from vtk_mls import Deformation, HalfPlane, io
from vtk_mls.commands import demo
from vtk_mls.editor.distortion import Distortion
from vtk_mls.editor.scene import Scene
from vtk_mls.files import control_point_files
from vtk_mls.rendering.surfaces import handles_on
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured, output_of

NAME = "brain.nii.gz"
MOST_ACTIONS = 10  # of a new user, with the command; fewer are allowed
_EVERY = 16  # pixels
_NEAR = 3.0  # mm from the cut: the grid of what is looked at is not finer


def copy_to(folder):
    """Copy the brain into a folder."""
    shutil.copy(demo.brain_file(), folder / NAME)


class OpenedBrain:
    """What a user sees at first of the brain in a folder, and what the last picture must show.

    Parameters
    ----------
    folder : Path
        Where the file is.
    size : (width, height)
        Pixels of the view.
    """

    def __init__(self, folder, size):
        self._size, self._scene = size, scene_of(folder / NAME, size)
        handles = handles_on(self._scene.items, self._scene.bounds, 3)
        seen = self._scene.projection.pixels(handles)
        right = seen[seen[:, 0] > size[0] / 2]
        self._grabbed = right[right[:, 2].argmin(), :2]

    @property
    def grabbed(self):
        """Where the nearest handle to the right is: shares of the view, from its upper left."""
        x, y = self._grabbed / (np.array(self._size) - 1)
        return float(x), float(1 - y)

    def check(self, saved):
        """The saved picture shows faces of the cut, and around them what it showed before."""
        rest, deformed, *_ = control_point_files.read_pairs(saved / "handles.csv")
        (found,) = re.findall(
            r"AddCut\(cuts\.HalfPlane\((.*)\)\)", (saved / "deform.py").read_text()
        )
        cut = HalfPlane(*ast.literal_eval(f"({found})"))
        opened = Deformation(rest, deformed, cuts=cut)
        self._scene.show(opened, 32, Distortion(self._scene.bounds), True)
        width, height = self._size
        pixels = [(x, y) for x in range(0, width, _EVERY) for y in range(0, height, _EVERY)]
        picker = self._scene.picker()
        hits = [picker.hit(pixel) for pixel in pixels]
        is_hit = np.array([hit is not None for hit in hits])
        origins = opened.backward([hit for hit in hits if hit is not None]) - cut.point
        is_face = np.zeros(len(pixels), bool)
        on_cut = (np.abs(origins @ cut.normal) < _NEAR) & (origins @ cut.inward > _NEAR)
        is_face[is_hit] = on_cut
        assert is_face.sum() > 0.03 * is_hit.sum()
        picture = picture_in(saved / "picture.png")
        assert picture.shape[1::-1] == self._size
        red, _, blue = np.array([picture[y, x] for x, y in pixels]).T
        is_brain = red > blue + 25
        assert is_brain[is_face].mean() > 0.9
        assert (is_brain == is_hit).mean() > 0.95


def scene_of(path, size):
    """The `Scene` of a file as the page shows it at first, after it has got its size."""
    window = configured(vtkRenderWindow(), OffScreenRendering=True, Size=[900, 700])
    scene = Scene(window, [io.read_dataset(path)])
    window.SetSize(*size)
    scene.renderer.GetActiveCamera().SetUseHorizontalViewAngle(size[0] < size[1])
    return scene


def picture_in(path):
    """(height, width, 3) float, from below."""
    image = output_of(vtkPNGReader(), FileName=str(path))
    width, height, _ = image.GetDimensions()
    return arrays.to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1) * 1.0
