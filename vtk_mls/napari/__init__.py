"""A plugin of napari: drag points, and an image or labels follow.

One points layer has the control points at rest, another where they are moved. The deformed data are
a layer of their own, computed lazily: napari asks for the shown slices of the shown level only.
"""

from __future__ import annotations

import napari
import numpy as np
from magicgui.widgets import ComboBox, Container, FloatSpinBox, PushButton, SpinBox
from napari.layers import Image, Labels, Layer, Points
from napari.utils.notifications import show_warning

from vtk_mls import Deformation, Grid, Sampling, dask
from vtk_mls.model.options import MAX_STEPS, named

# Blocks (nz, ny, nx) that are computed at once.
_CHUNKS = (16, 512, 512)
_KINDS = ("rigid", "similarity", "affine", "spline", "auto")
_PLACED = ("scale", "translate", "rotate", "shear", "affine", "units", "axis_labels")


class DeformWidget(Container):
    """The panel *MLS Deform*.

    Parameters
    ----------
    napari_viewer : napari.Viewer
        Napari gives it to the parameter of this name.
    """

    def __init__(self, napari_viewer: napari.Viewer) -> None:
        self._viewer = viewer = napari_viewer
        self._deformed: Layer | None = None
        self._connected: list[Points] = []
        self._data = ComboBox(label="Image or labels", choices=self._layers(Image, Labels))
        self._rest = ComboBox(label="Points at rest", choices=self._layers(Points))
        self._copy = PushButton(text="Copy the points, to drag them")
        self._moved = ComboBox(label="Points moved", choices=self._layers(Points))
        self._kind = ComboBox(choices=_KINDS, **_about("kind"))
        low, high, step = named("alpha").slider
        self._alpha = FloatSpinBox(min=low, max=high, step=step, **_about("alpha"))
        self._smoothing = FloatSpinBox(min=0, max=1e6, **_about("smoothing"))
        self._steps = SpinBox(min=0, max=MAX_STEPS, **_about("steps"))
        super().__init__(
            widgets=[
                *(self._data, self._rest, self._copy, self._moved),
                *(self._kind, self._alpha, self._smoothing, self._steps),
            ]
        )
        self._copy.changed.connect(self._copy_points)
        for chosen in (self._rest, self._moved):
            chosen.changed.connect(self._follow)
        for option in (self._data, self._kind, self._alpha, self._smoothing, self._steps):
            option.changed.connect(self.update)
        viewer.layers.events.inserted.connect(self.reset_choices)
        viewer.layers.events.removed.connect(self.reset_choices)
        self._follow()

    def _layers(self, *kinds):
        def choices(_):
            layers = [layer for layer in self._viewer.layers if isinstance(layer, kinds)]
            return [layer for layer in layers if layer is not self._deformed]

        return choices

    def _copy_points(self) -> None:
        if (rest := self._rest.value) is None:
            show_warning("Add a points layer first, with a point at each place to move or to hold")
            return
        placed = {name: getattr(rest, name) for name in _PLACED}
        moved = self._viewer.add_points(
            rest.data.copy(), name=f"{rest.name} moved", face_color="red", size=rest.size, **placed
        )
        moved.mode = "select"
        self._moved.value = moved

    def _follow(self) -> None:
        for points in self._connected:
            points.events.data.disconnect(self.update)
            points.mouse_drag_callbacks.remove(self._on_drag)
        self._connected = list({self._rest.value, self._moved.value} - {None})
        for points in self._connected:
            points.events.data.connect(self.update)
            points.mouse_drag_callbacks.append(self._on_drag)
        self.update()

    def _on_drag(self, _, event):
        """Napari tells of moved points only at their release."""
        yield
        while event.type == "mouse_move":
            self.update()
            yield

    def deformation(self) -> Deformation:
        """The deformation in the world of napari, whose axes are those of the arrays reversed.

        Raises
        ------
        ValueError
            One sentence, where the layers do not fit.
        """
        rest, moved = (_world(layer.value) for layer in (self._rest, self._moved))
        if len(rest) != len(moved):
            raise ValueError(
                f'"{self._rest.value.name}" has {len(rest)} points and "{self._moved.value.name}" '
                f"{len(moved)}; they need the same number, in the same order"
            )
        return Deformation(
            *(rest, moved, self._kind.value),
            alpha=self._alpha.value,
            smoothing=self._smoothing.value,
            steps=self._steps.value or "auto",
        )

    def update(self, _=None) -> None:
        """Deform the chosen layer; a sentence in napari's corner says what does not fit."""
        data, points = self._data.value, (self._rest.value, self._moved.value)
        if data is None or None in points or points[0] is points[1]:
            return
        try:
            arrays = deformed_levels(data, self.deformation())
        except (ValueError, TypeError) as error:
            show_warning(str(error))
            return
        result = arrays if data.multiscale else arrays[0]
        old = self._deformed
        if old in self._viewer.layers and type(old) is type(data) and old.ndim == data.ndim:
            old.data = result
            return
        state = {name: getattr(data, name) for name in _PLACED}
        if isinstance(data, Image):
            state |= {"colormap": data.colormap, "contrast_limits": data.contrast_limits}
        self._deformed = type(data)(
            result, name=f"{data.name} deformed", multiscale=data.multiscale, **state
        )
        data.visible = False
        layers = self._viewer.layers
        layers.insert(layers.index(data) + 1, self._deformed)
        layers.selection.active = self._moved.value  # ready to be dragged


def _about(name):
    """Label, default and tooltip of an option."""
    option = named(name)
    return {"label": option.label, "value": option.default, "tooltip": option.help}


def deformed_levels(layer: Layer, deformation: Deformation) -> list:
    """The levels of an image or labels, deformed lazily: arrays of dask in the layer's shapes.

    Raises
    ------
    ValueError
        If the layer is not an image or labels of two or three dimensions, without colors.
    """
    if layer.ndim not in (2, 3) or getattr(layer, "rgb", False):
        raise ValueError(
            f'"{layer.name}" must have two or three dimensions and no colors, got '
            f"{'colors' if getattr(layer, 'rgb', False) else layer.ndim}; show one channel or time"
        )
    method = "nearest" if isinstance(layer, Labels) else "linear"
    levels = layer.data if layer.multiscale else [layer.data]
    arrays = []
    for level, factors in zip(levels, layer.downsample_factors):
        solid = level if level.ndim == 3 else level[None]
        sampling = Sampling(_grid(layer, solid.shape, factors), interpolation=method)
        result = dask.resample(solid, deformation, sampling, _CHUNKS)
        arrays.append(result if level.ndim == 3 else result[0])
    return arrays


def _world(points: Points):
    """The points (n, 3) in the world, x first; z is 0 in a plane."""
    places = np.array([points.data_to_world(place) for place in points.data])[:, ::-1]
    return np.pad(places, ((0, 0), (0, 3 - places.shape[1])))


def _grid(layer, shape, factors) -> Grid:
    """The grid of a level with `factors` (ndim,) between its points, in points of the first."""
    n = layer.ndim
    origin = np.array(layer.data_to_world(np.zeros(n)))
    ends = [layer.data_to_world(row) for row in np.diag(factors)[::-1]]
    edges = np.eye(3)
    edges[:n, :n] = (np.array(ends) - origin)[:, ::-1].T  # columns
    spacing = np.linalg.norm(edges, axis=0)
    origin = np.pad(origin[::-1], (0, 3 - n))
    return Grid(shape[::-1], origin, spacing, edges / spacing)
