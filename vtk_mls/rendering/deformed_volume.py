"""A volume that is drawn deformed, without resampling it (section 4 of the paper)."""

from __future__ import annotations

from weakref import WeakKeyDictionary, ref

import numpy as np
from vtkmodules.vtkCommonCore import reference, vtkCommand
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkRenderingCore import vtkAbstractVolumeMapper, vtkRenderer, vtkVolume

from vtk_mls import Deformation, Grid
from vtk_mls.rendering import shader, volume_checks
from vtk_mls.rendering.errors import RenderingError
from vtk_mls.rendering.map_box import MapBox
from vtk_mls.rendering.map_layers import layers
from vtk_mls.rendering.map_texture import MapTexture
from vtk_mls.rendering.messages import Messages
from vtk_mls.vtk.arrays import ImageGeometry

_GROWTHS = 8  # of the box in one update
_drawn = WeakKeyDictionary()  # by vtkVolume: its image and deformation, and by whom


class DeformedVolume:
    """Draws a vtkVolume deformed: rays fetch each sample where its material came from.

    A move costs one small displacement map; the volume itself stays on the graphics card as it is.
    All of the volume's properties go on working, and may change at any time, as may its data.

    Parameters
    ----------
    volume : vtkVolume
        Its mapper must be a vtkGPUVolumeRayCastMapper or a vtkSmartVolumeMapper that uses it, with
        a vtkImageData. The deformation is in the coordinates of the data; the volume's own matrix
        comes after it.
    renderer : vtkRenderer
        Where it is drawn.

    Attributes
    ----------
    failure : str or None
        Why it is not drawn deformed any more: what the graphics driver said. The volume is drawn
        undeformed then.
    uploads : int
        How many maps went to the graphics card.

    Raises
    ------
    TypeError, ValueError
        If the volume cannot be drawn so.

    Notes
    -----
    Until the first `update` the volume is drawn as it is. Keep this object as long as it draws: VTK
    does not hold it.
    """

    def __init__(self, volume: vtkVolume, renderer: vtkRenderer) -> None:
        self.failure: str | None = None
        _check_is_free(volume, self)
        self._volume, self._renderer = volume, renderer
        self._mapper = volume_checks.checked_mapper(volume)
        self._producer = _producer_of(self._mapper)
        self._texture, self._box, self._stretched = MapTexture(), None, None
        self._deformation, self._nodes, self._within = None, None, None
        self._source, self._source_time = None, 0
        self._proven, self._messages = None, None
        self._observers = []

    @property
    def uploads(self) -> int:
        return self._texture.uploads

    def update(self, deformation: Deformation, nodes: int = 64, within: Grid | None = None) -> None:
        """Draw the volume as `deformation` has it from the next Render on.

        Parameters
        ----------
        deformation : Deformation
        nodes : int
            Of the displacement map along the longest side of what is drawn; between them it is
            interpolated linearly. With cuts in the rest frame faces are sharp whatever it is; with
            cuts in the deformed frame they are as sharp as the map is fine.
        within : Grid, optional
            In line with the image, with two points or more along each axis: what the deformation
            takes out of it is not drawn. Without it all of the deformed volume is.

        Raises
        ------
        RenderingError
            If an earlier update could not be drawn.
        ValueError
            If the volume cannot be drawn so.
        """
        if self.failure is not None:
            raise RenderingError(self.failure)
        _check_is_free(self._volume, self)
        self._check_is_alone()
        volume_checks.check_mode(self._mapper)
        self._deformation, self._nodes, self._within = deformation, nodes, within
        if self._source is None:
            self._take_source()
        box = self._box
        if box is None or not box.ends_at(within):
            box = MapBox.around(*self._geometry(), within)
        inside = deformation.deformed[box.values.covers(box.values.index_of(deformation.rest))]
        for _ in range(_GROWTHS):
            grid = box.nodes(nodes)
            values = layers(deformation, grid)
            fitted = box.fitted(values, grid, inside)
            if fitted is box:
                break
            box = fitted
        else:
            grid = box.nodes(nodes)
            values = layers(deformation, grid)
        self._show(box, grid, values)
        _drawn[self._volume] = self._source, deformation, ref(self)

    def detach(self) -> None:
        """Draw the volume undeformed again, as if nothing had been here."""
        observers, self._observers = self._observers, []
        for observer in observers:
            self._renderer.RemoveObserver(observer)
        self._is_built()
        if observers:
            del _drawn[self._volume]
            if self._mapper.GetInput() is self._stretched:
                producer, port = self._producer
                self._mapper.SetInputConnection(producer.GetOutputPort(port))
            shader.remove(self._volume.GetShaderProperty())
            self._texture.free()
        self._box = self._source = self._stretched = None

    def _show(self, box, grid, values):
        if box is not self._box:
            self._stretch(box)
        self._texture.set(values.reshape(-1, *values.shape[2:]))
        shader.set_values(
            self._volume.GetShaderProperty(), _placement(box, grid.dimensions, len(values))
        )
        if not self._observers:
            shader.install(self._volume.GetShaderProperty())
            for event, what in (
                (vtkCommand.StartEvent, self._begin),
                (vtkCommand.EndEvent, self._end),
            ):
                self._observers.append(self._renderer.AddObserver(event, what))
            self._proven = None
        self._volume.Modified()

    def _stretch(self, box):
        """Let rays go through all of a box: the same voxels, placed otherwise."""
        stretched = vtkImageData()
        stretched.ShallowCopy(self._source)
        box.image_geometry().apply_to(stretched)
        self._mapper.SetInputDataObject(stretched)
        self._box, self._stretched = box, stretched

    def _check_is_alone(self):
        """Whether the mapper draws just this volume: in this window, or deformed in another."""
        window = self._renderer.GetRenderWindow()
        renderers = window.GetRenderers() if window else [self._renderer]
        seen = (volume for renderer in renderers for volume in renderer.GetVolumes())
        volume_checks.check_own_mapper(self._volume, [*seen, *_drawn])

    def _take_source(self):
        """The image as it is now."""
        image = _image_of(self._producer)
        volume_checks.check_image(image)
        self._source, self._source_time = image, image.GetMTime()

    def _geometry(self):
        return ImageGeometry.of_image(self._source), _has_cell_values(self._mapper, self._source)

    def _follow_source(self):
        """Take over another input, or what has changed in it."""
        if self._mapper.GetInput() is not self._stretched:
            self._producer, self._source = _producer_of(self._mapper), None
        else:
            image = _image_of(self._producer)
            of_cells = _has_cell_values(self._mapper, image)
            if (image, image.GetMTime(), of_cells) == (
                self._source,
                self._source_time,
                self._box.of_cells,
            ):
                return
            self._source = None
        self._box = None
        self.update(self._deformation, self._nodes, self._within)

    def _begin(self, renderer, event):
        if not vars(self):  # Python's collector has emptied it before VTK let the renderer go
            return
        try:
            self._check_is_alone()
            volume_checks.check_mode(self._mapper)
            volume_checks.check_support(self._volume, renderer.GetRenderWindow())
            self._follow_source()
            unit = self._texture.bind(renderer.GetRenderWindow())
        except (ValueError, TypeError, RuntimeError, MemoryError) as error:
            self._fail(str(error) or "there is not enough memory")
            return
        shader.set_values(self._volume.GetShaderProperty(), {"mls_map": unit})
        # of which VTK makes its shader
        looks = self._volume.GetProperty().GetMTime(), self._mapper.GetMTime()
        if looks != self._proven and self._messages is None:
            self._proven, self._messages = looks, Messages()

    def _end(self, renderer, event):
        if not vars(self):
            return
        self._texture.release()
        if not self._is_built():
            self._fail("the graphics driver does not build the shader of the deformed volume")

    def _is_built(self):
        """Whether VTK did not complain of the shader, if this picture was to tell."""
        messages, self._messages = self._messages, None
        if messages is None:
            return True
        return not messages.finish("hader")

    def _fail(self, why):
        self.failure = f"{why}; it is drawn undeformed"
        self.detach()
        Messages.error(f"DeformedVolume: {self.failure}")


def _owner(volume):
    """The DeformedVolume that draws a vtkVolume; None if none does."""
    return _drawn[volume][2]() if volume in _drawn else None


def _check_is_free(volume, wanted):
    if _owner(volume) not in (None, wanted):
        raise ValueError("`volume` is drawn deformed already; update or detach that one")


def _producer_of(mapper):
    """Whose output a mapper shows, and which; the pipeline itself keeps no producer alive."""
    connection = mapper.GetInputConnection(0, 0)
    return connection.GetProducer(), connection.GetIndex()


def _image_of(producer):
    algorithm, port = producer
    algorithm.Update(port)
    return algorithm.GetOutputDataObject(port)


def drawn_as(volume):
    """The image and the Deformation that a vtkVolume is drawn from; None if it is not deformed."""
    return _drawn[volume][:2] if volume in _drawn else None


def _has_cell_values(mapper, image):
    """Whether the array that is drawn belongs to cells."""
    of_cells = reference(0)
    vtkAbstractVolumeMapper.GetScalars(
        image,
        mapper.GetScalarMode(),
        mapper.GetArrayAccessMode(),
        mapper.GetArrayId(),
        mapper.GetArrayName(),
        of_cells,
    )
    return of_cells.get() == 1


def _placement(box, dimensions, layer_count):
    """Uniforms of the shader, from texture coordinates of the box."""
    values, points = box.values, np.array(box.image.grid.dimensions, float)
    count, size = np.array(values.dimensions, float), box.high - box.low
    # texture coordinates of points are those of their texels' centres
    end = np.zeros(3) if box.of_cells else 0.5 / points
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
