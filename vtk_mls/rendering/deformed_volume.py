"""A volume that is drawn deformed, without resampling it (section 4 of the paper)."""

from __future__ import annotations

from weakref import WeakKeyDictionary, ref

import numpy as np
from vtkmodules.vtkCommonCore import reference, vtkCommand
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkRenderingCore import vtkAbstractVolumeMapper, vtkRenderer, vtkVolume
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper
from vtkmodules.vtkRenderingVolumeOpenGL2 import vtkSmartVolumeMapper

from vtk_mls import Deformation, Grid
from vtk_mls.rendering import shader, volume_paint
from vtk_mls.rendering.map_layers import MapBox, layers
from vtk_mls.rendering.rest_lines import RestLines
from vtk_mls.vtk.arrays import ImageGeometry

_ON_CARD = vtkSmartVolumeMapper.DefaultRenderMode, vtkSmartVolumeMapper.GPURenderMode
_MAX_GROWTHS = 8  # of the box in one update
# By vtkVolume: its image, deformation and a reference to its DeformedVolume.
_drawn = WeakKeyDictionary()


class DeformedVolume:
    """Draws a vtkVolume deformed: rays read each sample at the origin of its material.

    An update computes a small displacement map; the volume on the graphics card is not changed.
    The properties and the data of the volume may change at any time.

    Parameters
    ----------
    volume : vtkVolume
        Its mapper must be a vtkGPUVolumeRayCastMapper or a vtkSmartVolumeMapper that uses it, with
        a vtkImageData. The deformation is in the coordinates of the data; the volume's own matrix
        is applied after it.
    renderer : vtkRenderer
        The renderer of the volume.

    Attributes
    ----------
    failure : str or None
        The reason, if the graphics driver cannot draw the deformation: the volume is then drawn
        undeformed.
    uploads : int
        Number of maps uploaded to the graphics card.

    Raises
    ------
    TypeError, ValueError
        If the volume cannot be drawn deformed.

    Notes
    -----
    The volume is drawn undeformed until the first `update`. Keep a reference to this object as long
    as it draws: VTK does not keep one.
    """

    def __init__(self, volume: vtkVolume, renderer: vtkRenderer) -> None:
        self.failure: str | None = None
        _check_is_free(volume, self)
        self._volume, self._renderer = volume, renderer
        self._mapper = _checked_mapper(volume)
        self._producer = _producer_of(self._mapper)
        self._texture, self._box, self._stretched = shader.MapTexture(), None, None
        self._deformation, self._nodes, self._within = None, None, None
        self._source, self._source_time = None, 0
        self._checked_times, self._messages = None, None
        self._observers, self._paint, self._is_painted = [], (None, False), False

    @property
    def uploads(self) -> int:
        return self._texture.uploads

    def update(self, deformation: Deformation, nodes: int = 64, within: Grid | None = None) -> None:
        """Draw the volume deformed by `deformation` from the next Render on.

        Parameters
        ----------
        deformation : Deformation
        nodes : int
            Of the displacement map along the longest side of the deformed volume; the map is
            linear between them. With cuts in the rest frame faces are always sharp; with cuts in
            the deformed frame their sharpness depends on the nodes.
        within : Grid, optional
            Aligned with the image, with two points or more along each axis: only the part of the
            deformed volume inside is drawn. By default all of it.

        Raises
        ------
        RenderingError
            If an earlier update could not be drawn.
        ValueError
            If the volume cannot be drawn deformed.
        """
        if self.failure is not None:
            raise shader.RenderingError(self.failure)
        _check_is_free(self._volume, self)
        self._check_is_alone()
        _check_mode(self._mapper)
        self._deformation, self._nodes, self._within = deformation, nodes, within
        if self._source is None:
            image = _image_of(self._producer)
            _check_image(image)
            self._source, self._source_time = image, image.GetMTime()
        box = self._box
        if box is None or not box.ends_at(within):
            _, is_cell_data = scalars_of(self._mapper, self._source)
            box = MapBox.around(ImageGeometry.of_image(self._source), is_cell_data, within)
        rest, deformed = deformation.handle_set.positions
        inside = deformed[box.values.covers(box.values.index_of(rest))]
        for growths in range(_MAX_GROWTHS + 1):
            grid = box.nodes(nodes)
            values = layers(deformation, grid)
            fitted = box.fitted(values, grid, inside)
            if fitted is box or growths == _MAX_GROWTHS:
                break
            box = fitted
        self._show(box, grid, values)
        _drawn[self._volume] = self._source, deformation, ref(self)

    def paint(self, lines: RestLines | None = None, has_colors: bool = False) -> None:
        """Paint the deformation on the volume, from the next `update` on.

        Parameters
        ----------
        lines : RestLines, optional
            A grid of the undeformed space, whose planes are lines on the surface of the material.
        has_colors : bool
            Whether samples have the colors of the change of volume, red where space folds. It is
            that of the map between its nodes.
        """
        self._paint = lines, has_colors

    def detach(self) -> None:
        """Draw the volume undeformed again, and restore its mapper and shader."""
        observers, self._observers = self._observers, []
        for observer in observers:
            self._renderer.RemoveObserver(observer)
        self._finish_capture()
        if observers:
            del _drawn[self._volume]
            if self._mapper.GetInput() is self._stretched:
                producer, port = self._producer
                self._mapper.SetInputConnection(producer.GetOutputPort(port))
            volume_paint.remove(self._volume.GetShaderProperty())
            shader.remove(self._volume.GetShaderProperty())
            self._is_painted = False
            self._texture.free()
        self._box = self._source = self._stretched = None

    def _show(self, box, grid, values):
        if box is not self._box:
            self._stretch(box)
        self._texture.set(values.reshape(-1, *values.shape[2:]))
        material = self._volume.GetShaderProperty()
        shader.set_values(material, _placement(box, grid.dimensions, len(values)))
        if not self._observers:
            shader.install(material)
            self._observers = [
                self._renderer.AddObserver(vtkCommand.StartEvent, self._begin),
                self._renderer.AddObserver(vtkCommand.EndEvent, self._end),
            ]
            self._checked_times = None
        self._update_paint(box, grid)
        self._volume.Modified()

    def _update_paint(self, box, grid):
        """Set the shader code and the uniforms of the paint, for a box and the grid of its map."""
        material, is_painted = self._volume.GetShaderProperty(), self._paint != (None, False)
        if is_painted:
            shader.set_values(material, volume_paint.values_of(box, grid, *self._paint))
        if is_painted != self._is_painted:
            (volume_paint.install if is_painted else volume_paint.remove)(material)
            self._is_painted, self._checked_times = is_painted, None

    def _stretch(self, box):
        """Give the mapper the voxels stretched over a box, so that rays traverse all of it."""
        stretched = vtkImageData()
        stretched.ShallowCopy(self._source)
        box.image_geometry().apply_to(stretched)
        self._mapper.SetInputDataObject(stretched)
        self._box, self._stretched = box, stretched

    def _check_is_alone(self):
        """Raise ValueError if the mapper draws another volume, in this window or deformed."""
        window = self._renderer.GetRenderWindow()
        renderers = window.GetRenderers() if window else [self._renderer]
        volumes = (volume for renderer in renderers for volume in renderer.GetVolumes())
        others = [volume for volume in (*volumes, *_drawn) if volume is not self._volume]
        if any(volume.GetMapper() is self._volume.GetMapper() for volume in others):
            raise ValueError(
                "`volume` shares its mapper with another vtkVolume, which would be drawn in a "
                "wrong place; give each a mapper of its own"
            )

    def _follow_source(self):
        """Update after a change of the mapper's input."""
        if self._mapper.GetInput() is not self._stretched:
            self._producer, self._source = _producer_of(self._mapper), None
        else:
            image = _image_of(self._producer)
            _, is_cell_data = scalars_of(self._mapper, image)
            previous = self._source, self._source_time, self._box.is_cell_data
            if (image, image.GetMTime(), is_cell_data) == previous:
                return
            self._source = None
        self._box = None
        self.update(self._deformation, self._nodes, self._within)

    def _begin(self, renderer, event):
        if not vars(self):  # cleared by Python's garbage collector before the renderer is deleted
            return
        try:
            self._check_is_alone()
            _check_mode(self._mapper)
            _check_support(self._volume, renderer.GetRenderWindow())
            self._follow_source()
            unit = self._texture.bind(renderer.GetRenderWindow())
        except (ValueError, TypeError, RuntimeError, MemoryError) as error:
            self._fail(str(error) or "there is not enough memory")
            return
        shader.set_values(self._volume.GetShaderProperty(), {"mls_map": unit})
        # VTK's shader depends on both
        times = self._volume.GetProperty().GetMTime(), self._mapper.GetMTime()
        if times != self._checked_times and self._messages is None:
            self._checked_times, self._messages = times, shader.CapturedMessages()

    def _end(self, renderer, event):
        if not vars(self):
            return
        self._texture.release()
        if not self._finish_capture():
            self._fail("the graphics driver does not build the shader of the deformed volume")

    def _finish_capture(self):
        """End the capture of messages, if any; whether VTK reported no error of the shader."""
        messages, self._messages = self._messages, None
        return messages is None or not messages.finish("hader")

    def _fail(self, reason):
        self.failure = f"{reason}; it is drawn undeformed"
        self.detach()
        shader.report_error(f"DeformedVolume: {self.failure}")


def _check_is_free(volume, drawer):
    """Raise ValueError if another DeformedVolume than `drawer` draws a volume."""
    if volume in _drawn and _drawn[volume][2]() not in (None, drawer):
        raise ValueError("`volume` is drawn deformed already; update or detach that one")


def _producer_of(mapper):
    """The algorithm and the port of a mapper's input: a reference that keeps the producer alive."""
    connection = mapper.GetInputConnection(0, 0)
    return connection.GetProducer(), connection.GetIndex()


def _image_of(producer):
    algorithm, port = producer
    algorithm.Update(port)
    return algorithm.GetOutputDataObject(port)


def drawn_as(volume):
    """The image and the Deformation of a vtkVolume that is drawn deformed, else None."""
    return _drawn[volume][:2] if volume in _drawn else None


def scalars_of(mapper, image):
    """The array of an image that a volume mapper draws, or None; and whether it is cell data."""
    is_cell_data = reference(0)
    selection = mapper.GetScalarMode(), mapper.GetArrayAccessMode(), mapper.GetArrayId()
    array = vtkAbstractVolumeMapper.GetScalars(
        image, *selection, mapper.GetArrayName(), is_cell_data
    )
    return array, is_cell_data.get() == 1


def _placement(box, dimensions, layer_count):
    """Uniforms of the shader, from texture coordinates of the box."""
    values, points = box.values, np.array(box.image.grid.dimensions, float)
    count, size = np.array(values.dimensions, float), box.high - box.low
    # points are at the centers of texels
    end = np.zeros(3) if box.is_cell_data else 0.5 / points
    scale = 1 / (1 - 2 * end)
    bias = -end * scale
    nodes = np.array(dimensions, float)
    stack = np.array([1, 1, layer_count])
    map_scale, map_bias = (nodes - 1) / nodes / stack, 0.5 / nodes / stack
    to_texture = values.world_to_index / count[:, None]
    return {
        "mls_layers": float(layer_count),
        "mls_map_low": float(map_bias[2]),
        "mls_end": end,
        "mls_map_scale": map_scale * scale,
        "mls_map_bias": map_scale * bias + map_bias,
        "mls_origin_scale": size / count * scale,
        "mls_origin_bias": (size * bias + box.low + 0.5) / count,
        "mls_to_x": to_texture[0],
        "mls_to_y": to_texture[1],
        "mls_to_z": to_texture[2],
        "mls_step": 1 / size / scale,
        "mls_spacing": np.abs(values.spacing),
        "mls_voxel": float(np.abs(values.spacing).mean()),
    }


def _checked_mapper(volume):
    """The mapper of a volume, if it can draw a deformation."""
    mapper = volume.GetMapper()
    if not isinstance(mapper, (vtkGPUVolumeRayCastMapper, vtkSmartVolumeMapper)):
        raise TypeError(
            "`volume` must have a vtkGPUVolumeRayCastMapper or a vtkSmartVolumeMapper, "
            f"got {type(mapper).__name__}"
        )
    if mapper.GetNumberOfInputConnections(0) != 1:
        raise ValueError("the mapper of `volume` must have one input, got none or several")
    _check_mode(mapper)
    return mapper


def _check_mode(mapper):
    """Raise ValueError if a mapper is set to draw without the graphics card."""
    if isinstance(mapper, vtkGPUVolumeRayCastMapper):
        return
    mode = mapper.GetRequestedRenderMode()
    if mode not in _ON_CARD:
        names = (name for name, value in vars(vtkSmartVolumeMapper).items() if value == mode)
        name = next(name for name in names if name.endswith("RenderMode"))
        raise ValueError(
            "the mapper of `volume` must draw on the graphics card, "
            f"got {name}; call its SetRequestedRenderModeToGPU()"
        )


def _check_support(volume, window):
    """Raise RenderingError if VTK cannot draw a volume on the graphics card."""
    mapper = volume.GetMapper()
    if not isinstance(mapper, vtkGPUVolumeRayCastMapper):
        mapper = vtkGPUVolumeRayCastMapper()
    if not mapper.IsRenderSupported(window, volume.GetProperty()):
        raise shader.RenderingError(
            "`volume` must be drawn on the graphics card, which VTK cannot do in this window; "
            "draw the resampled volume instead"
        )


def _check_image(image):
    """Raise TypeError or ValueError if an image cannot be drawn deformed."""
    if not isinstance(image, vtkImageData):
        raise TypeError(
            f"`volume` must show a vtkImageData, got {type(image).__name__}; resample it to one"
        )
    if min(image.GetDimensions()) < 2:
        raise ValueError(
            f"`volume` must have at least two points along each axis, got {image.GetDimensions()}"
        )
