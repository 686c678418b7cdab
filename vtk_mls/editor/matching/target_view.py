"""The target beside or over the moving data: its renderer, its slices, and landmarks on both."""

import numpy as np
from vtkmodules.vtkCommonCore import VTK_UNSIGNED_CHAR, vtkUnsignedCharArray
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkRenderingCore import vtkActor, vtkActor2D, vtkImageMapper

from vtk_mls import Deformation
from vtk_mls.editor.commands import HINT, TARGET_HINT
from vtk_mls.editor.distortion import Distortion
from vtk_mls.editor.grips import names_of
from vtk_mls.editor.matching.pairs import MOVING, TARGET
from vtk_mls.editor.matching.target import BESIDE, CHECKERBOARD, DIFFERENCE, FADE
from vtk_mls.editor.overlay import Names
from vtk_mls.editor.scene import Scene, box_around, new_renderer
from vtk_mls.editor.scene_mesh import SceneMesh
from vtk_mls.editor.slice_pane import colors_of
from vtk_mls.editor.slices import ALL, ONLY_3D, Slices
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured

_OUTLINE_COLOR = (0.45, 0.75, 1.0)  # of a mesh as target
_FAR = 0.5  # distance of the centers of sides that hardly overlap, relative to their size
_TILES = 8  # of the checkerboard along the longest side of the data
# Colors of a difference, 0 to 1: where the moving data are brighter, and where the target is.
_MOVING_COLOR, _TARGET_COLOR = np.array((1.0, 0.6, 0.15)), np.array((0.2, 0.65, 1.0))


class TargetView:
    """The second side of a `MatchingView`, which shares camera and slices with it."""

    def __init__(self, view, target):
        self._view, self._moving, self._moving_slices = view, view.scene, view.slices
        window = view.scene.window
        self.scene = Scene(window, [target.dataset], new_renderer(window))
        self.slices = Slices(self.scene, Distortion(self.scene.bounds))
        self._own_camera = self.scene.renderer.GetActiveCamera()
        self.scene.renderer.SetActiveCamera(view.scene.renderer.GetActiveCamera())
        self._ghosts, self.dragged = [], None
        self.far_centers = self._far_centers()
        bounds = self._bounds()
        for slices in (self._moving_slices, self.slices):
            slices.set_bounds(bounds)
        scenes = {MOVING: self._moving, TARGET: self.scene}
        self._names = {side: Names(scene.overlay) for side, scene in scenes.items()}
        view.overlay.set_hint(TARGET_HINT)
        for item in self._meshes(self.scene.items):
            item.outline_color = _OUTLINE_COLOR
            # draws the mesh once more, in the other renderer
            ghost = configured(vtkActor(), Mapper=item.plain_mapper(), Pickable=False)
            ghost.VisibilityOff()
            ghost.GetProperty().SetColor(_OUTLINE_COLOR)
            self._ghosts.append(ghost)
            self._moving.renderer.AddActor(ghost)
        self._cross_fade = CrossFade(self.scene.renderer, self._moving.overlay)
        self._tags = [
            (scene.renderer, scene.renderer.AddObserver("StartEvent", _fit_clipping, 1.0))
            for scene in scenes.values()
        ]
        is_plain = isinstance(self.scene.items[0], SceneMesh) or self.scene.flat_axis is not None
        self.arrange(view.slices.first_pane if is_plain else ALL)
        self.reset_camera()

    def arrange(self, pane=None):
        """Divide the window for the comparison, and draw both sides as it says.

        `pane` is one of `slices.PANES`, by default the last one. Without the 3-D views, both sides
        show that slice.
        """
        comparison = self._view.comparison
        self._pane = pane = pane or self._pane
        self._is_upright = self._window_is_upright()
        left, right = (0, 0, 0.5, 1), (0.5, 0, 1, 1)
        if self._is_upright:
            left, right = (0, 0.5, 1, 1), (0, 0, 1, 0.5)
        if comparison.mode == BESIDE:
            self._moving_slices.compared = []
            self._moving_slices.arrange(left, _grid, pane)
            self.slices.arrange(right, _grid, pane)
        else:
            items = self._moving.items, self.scene.items
            image = ComparedItem(*items, comparison, self._bounds())
            self._moving_slices.compared = [image, *self._meshes([*items[0], *items[1]])]
            pane = ALL if pane == ONLY_3D else pane  # slices show the comparison
            self._moving_slices.arrange((0, 0, 1, 1), _row, pane)
            self.slices.arrange((0.5, 0.5, 1, 1), _grid, ONLY_3D)
            for layer in self.scene.layers:
                layer.SetDraw(pane == ALL)
        share = comparison.share if comparison.mode == FADE else None
        for ghost in self._ghosts:
            ghost.SetVisibility(comparison.mode != BESIDE)
            ghost.GetProperty().SetOpacity(0.5 if share is None else share)
        if not self._ghosts:
            self._cross_fade.set_share(share or 0.0)

    def is_at(self, pixel):
        """Whether the target is drawn at a pixel."""
        view = self.scene.renderer
        is_in_3d = view.GetDraw() and view.IsInViewport(*map(int, pixel))
        return bool(is_in_3d) or self.slices.pane_at(pixel) is not None

    def initial_map(self, device):
        """The translation that shows undeformed data near the target; None if they are near."""
        if self.far_centers is None:
            return None
        p, q = self.far_centers
        return Deformation(p[None], q[None], device=device)

    def show_slices(self, is_final=True):
        """Draw the slices through the same point as those of the moving data."""
        slices, moving = self.slices, self._moving_slices
        slices.point, slices.zoom, slices.center = moving.point, moving.zoom, moving.center
        slices.show(is_final)

    def draw(self, state, selected, hovered, colors):
        """Place the landmarks of a `State`, with colors (g, 3), on both sides."""
        positions, are_visible = state.grips.deformed, not self._view.hides_handles
        names = names_of(state), np.isin(np.arange(len(positions)), selected).astype(int)
        on_data = positions.copy()
        if self.dragged is not None:
            rows, on_data[rows] = self.dragged
        for side, scene, slices, places in (
            (MOVING, self._moving, self._moving_slices, on_data),
            (TARGET, self.scene, self.slices, positions),
        ):
            scene.glyphs.show(places, places, colors, hovered)
            slices.show_handles(places, colors, are_visible, names)
            self._names[side].show(places, *names, are_visible)

    def lay_out(self):
        """Place both sides for the size of the window: above each other in upright ones."""
        if self._is_upright != self._window_is_upright():
            self.arrange()

    def _window_is_upright(self):
        width, height = self.scene.window.GetSize()
        return height > width

    def reset_camera(self):
        """Fit the shared camera to the target, and to the data if they are near."""
        self.scene.renderer.ResetCamera(self._bounds().T.ravel())

    def detach(self):
        """Remove the target from the window."""
        for renderer, tag in self._tags:
            renderer.RemoveObserver(tag)
        self.slices.set_pane(ONLY_3D)
        self._moving_slices.restore()
        for actor in self._ghosts:
            self._moving.renderer.RemoveActor(actor)
        self._cross_fade.detach()
        self._names[MOVING].show(np.zeros((0, 3)), [], [], False)
        self._view.overlay.set_hint(HINT)
        self.scene.detach()
        self.scene.renderer.SetActiveCamera(self._own_camera)
        for renderer in (self.scene.renderer, self.scene.overlay):
            self.scene.window.RemoveRenderer(renderer)
        self.scene.window.SetNumberOfLayers(self.scene.overlay.GetLayer())
        self._moving.reset_camera()

    def _bounds(self):
        """Corners (2, 3) of a box around the target, and the data unless they are far."""
        boxes = [self.scene.bounds] + [self._moving.bounds] * (self.far_centers is None)
        return box_around(boxes)

    def _far_centers(self):
        boxes = self._moving.bounds, self.scene.bounds
        p, q = (box.mean(axis=0) for box in boxes)
        size = max(np.ptp(box, axis=0).max() for box in boxes)
        return (p, q) if np.linalg.norm(q - p) > _FAR * size else None

    @staticmethod
    def _meshes(items):
        return [item for item in items if isinstance(item, SceneMesh)]


def _fit_clipping(renderer, event):
    """Fit the depths of the shared camera to the data of one renderer, before it draws."""
    renderer.ResetCameraClippingRange()


def _grid(viewport):
    """The 3-D view at the top left, and three slices beside and below it."""
    left, low, right, high = viewport
    x, y = (left + right) / 2, (low + high) / 2
    return (left, y, x, high), (x, y, right, high), (left, low, x, y), (x, low, right, y)


def _row(viewport):
    """The 3-D view at the top left, and three slices below; the target is at the top right."""
    left, low, right, high = viewport
    y = (low + high) / 2
    edges = np.linspace(left, right, 4)
    slices = [(edges[i], low, edges[i + 1], y) for i in range(3)]
    return (left, y, (left + right) / 2, high), *slices


class ComparedItem:
    """Images of both sides, items of a `Scene`, as one item of `Slices`.

    The checkerboard divides the box with the corners `bounds` (2, 3).
    """

    def __init__(self, moving, target, comparison, bounds):
        self._sides, self._comparison, self._bounds = (moving, target), comparison, bounds

    def mesh(self):
        """None: meshes are items of their own."""

    def colors_at(self, points):
        """Where points (n, 3) have material of a side, and their colors; None without images."""
        moving, target = (colors_of(items, points) for items in self._sides)
        if moving is None or target is None:
            return target if moving is None else moving
        (has_moving, moving), (has_target, target) = moving, target
        mode, share = self._comparison.mode, self._comparison.share
        if mode == CHECKERBOARD:
            is_target = self._is_target_tile(points)
            has_material = np.where(is_target, has_target, has_moving)
            return has_material, np.where(is_target[:, None], target, moving)
        has_material, moving, target = has_moving | has_target, moving / 1.0, target / 1.0
        if mode == DIFFERENCE:
            colors = difference_colors(moving, target)
        else:
            colors = (1 - share) * moving + share * target
        return has_material, np.rint(colors).astype(np.uint8)

    def _is_target_tile(self, points):
        """Whether each point is in a tile of the target: (n,) bool."""
        size = np.ptp(self._bounds, axis=0).max() / _TILES
        # an odd number of half tiles from the middle, so that no slice there is on an edge
        tiles = np.floor((points - self._bounds.mean(axis=0)) / size + 0.5).astype(int)
        return tiles.sum(axis=1) % 2 == 1


def difference_colors(moving, target):
    """Colors (n, 3) of the difference of two sides (n, 3), all 0 to 255; black where equal."""
    difference = (moving - target).mean(axis=1, keepdims=True)
    more, less = np.clip(difference, 0, None), np.clip(-difference, 0, None)
    return more * _MOVING_COLOR + less * _TARGET_COLOR


class CrossFade:
    """Copies each picture of a renderer, and draws it behind the objects of a layer.

    The `layer` is above the renderer that is faded out; it has the size of `source`, and no data.
    """

    def __init__(self, source, layer):
        self._source, self._image = source, vtkImageData()
        self._share, self._pixels = 0.0, vtkUnsignedCharArray()
        mapper = configured(vtkImageMapper(), InputData=self._image, ColorWindow=255)
        mapper.SetColorLevel(127.5)
        self._image.AllocateScalars(VTK_UNSIGNED_CHAR, 4)
        self._actor = configured(vtkActor2D(), Mapper=mapper, Pickable=False, Visibility=False)
        self._actor.GetProperty().SetDisplayLocationToBackground()
        layer.AddViewProp(self._actor)
        self._layer = layer
        self._tag = source.AddObserver("EndEvent", self._copy)

    def set_share(self, share):
        """Set the opacity, 0 to 1, from the next picture on."""
        self._share = share
        self._actor.SetVisibility(share > 0)

    def detach(self):
        """Remove the picture from the layer."""
        self._source.RemoveObserver(self._tag)
        self._layer.RemoveViewProp(self._actor)

    def _copy(self, renderer, event):
        if not self._share:
            return
        (left, low), (width, height) = renderer.GetOrigin(), renderer.GetSize()
        corners = left, low, left + width - 1, low + height - 1
        renderer.GetRenderWindow().GetPixelData(*corners, 0, self._pixels, 0)
        colors = arrays.to_numpy(self._pixels).reshape(-1, 3)
        opacity = np.full((len(colors), 1), round(255 * self._share), np.uint8)
        self._image.SetDimensions(width, height, 1)
        scalars = arrays.from_numpy(np.hstack([colors, opacity]), VTK_UNSIGNED_CHAR)
        self._image.GetPointData().SetScalars(scalars)
        self._image.Modified()
