"""The mouse over the 3-D view and over slices."""

import numpy as np

PRIORITY = 10.0  # above interactor styles and widgets
_PICK_DISTANCE = 9  # pixels from the center of a handle
_ADJUSTING_PIXELS = 200  # for the whole range of brightness, and for twice the contrast
_ZOOM = 1.21  # of a step of the wheel with Ctrl
_CLICK_DISTANCE = 3  # pixels that the mouse may move during a click
_MIN_PIXELS = 0.15  # length of a projected pixel step, below which a direction points at the eye


class Observer:
    """Handles events of an interactor before its style does."""

    def __init__(self, interactor, handlers):
        self._interactor = interactor
        self._tags = {
            event: interactor.AddObserver(event, handler, PRIORITY)
            for event, handler in handlers.items()
        }

    @property
    def pixel(self):
        """Pixel (2,) of the mouse."""
        return np.array(self._interactor.GetEventPosition(), float)

    def finish(self):
        """End an interaction."""

    def detach(self):
        """End an interaction, and handle no more events."""
        self.finish()
        for tag in self._tags.values():
            self._interactor.RemoveObserver(tag)

    def _abort(self, event):
        """Keep the event from the interactor style."""
        self._interactor.GetCommand(self._tags[event]).SetAbortFlag(True)


class Mouse(Observer):
    """Selects and drags handles, and moves slices; beside them the mouse moves the camera."""

    def __init__(self, interactor, document, tools, on_double_click):
        self._document, self._tools, self._on_double_click = document, tools, on_double_click
        self._view, self._slices = document.view, document.view.slices
        self._is_camera_click, self._adjusted_pixel, self._panned_pixel = False, None, None
        self._before_click = document.committed
        self._drag = self._picker = self._normal = None
        self._pane = self._band_corner = self._pressed_pixel = None
        handlers = {
            "LeftButtonPressEvent": self._press,
            "MouseMoveEvent": self._move,
            "LeftButtonReleaseEvent": self._release,
            "LeaveEvent": self._leave,
            "LeftButtonDoubleClickEvent": self._double_click,
            **{f"MouseWheel{way}Event": self._turn_wheel for way in ("Forward", "Backward")},
        }
        for name in ("Right", "Middle"):
            handlers[f"{name}ButtonPressEvent"] = self._press_other_button
            handlers[f"{name}ButtonReleaseEvent"] = self._release_other_button
        super().__init__(interactor, handlers)
        self._style = interactor.GetInteractorStyle()
        # the style takes all events from its button press to the release
        self._style_tag = self._style.AddObserver("EndInteractionEvent", self._end_camera)

    def detach(self):
        super().detach()
        self._style.RemoveObserver(self._style_tag)

    def finish(self):
        """Release handles, slices or the rubber band."""
        is_dragging, has_band = self._drag is not None, self._band_corner is not None
        self._drag = self._picker = self._normal = self._pane = self._band_corner = None
        self._is_camera_click, self._adjusted_pixel, self._panned_pixel = False, None, None
        if is_dragging:
            self._end_drag()
        if has_band:
            self._show_band(None)

    @property
    def _is_busy(self):
        held = self._drag, self._pane, self._band_corner, self._adjusted_pixel, self._panned_pixel
        return any(value is not None for value in held)

    def _press(self, interactor, event):
        self.finish()
        self._pressed_pixel, self._before_click = self.pixel, self._document.committed
        pane = self._view.pane_at(self.pixel)
        row, has_data = self._handle_at(pane), self._view.has_data_at(self.pixel)
        if has_data and any(tool.click(self.pixel, pane) for tool in self._tools):
            pass
        elif pane is not None and interactor.GetShiftKey():
            self._panned_pixel = self.pixel
        elif pane is not None:
            self._press_in_slice(pane, row)
        elif row is not None:
            self._grab(row, interactor.GetControlKey())
        elif interactor.GetControlKey() and has_data:
            self._band_corner = self.pixel
        else:
            self._is_camera_click = True
            return
        self._abort(event)

    def _press_in_slice(self, pane, row):
        self._view.cut_widget.finish()
        self._document.commit()
        self._pane = pane
        if row is None:
            self._document.move_slices(pane.point_at(self.pixel), is_moving=True)
        else:
            keeps_selection = bool(self._interactor.GetControlKey())
            self._grab(row, keeps_selection)
            if not keeps_selection:
                self._pressed_pixel = np.full(2, np.inf)  # a click has no effect in slices

    def _grab(self, row, keeps_selection):
        document, positions = self._document, self._document.state.grips.deformed
        if not keeps_selection and row not in document.selected:
            document.select([row])
        rows = np.union1d(document.selected, [row])
        projection = self._projection_of(self._pane)
        self._drag = Drag(projection, positions[rows], positions[row], self.pixel)
        scene, *_ = self._view.scenes_at(self.pixel)
        self._picker = scene.picker() if self._pane is None else None
        document.start_drag(rows, row)

    def _move(self, interactor, event):
        document = self._document
        if self._drag is not None:
            if not self._is_click:
                self._pressed_pixel = np.full(2, np.inf)  # no longer a click
                with document.reporting_errors():
                    self._drag_to(self._dragged_positions())
        elif self._pane is not None:
            document.move_slices(self._pane.point_at(self.pixel), is_moving=True)
        elif self._band_corner is not None:
            self._show_band((self._band_corner, self.pixel))
        elif self._adjusted_pixel is not None:
            self._adjust()
        elif self._panned_pixel is not None:
            start = self._panned_pixel
            if self._view.pane_at(self.pixel) is self._view.pane_at(start):
                self._panned_pixel = self.pixel
                document.zoom(start, self.pixel, 1.0)
        else:
            is_camera_moving = interactor.GetInteractorStyle().GetState() != 0
            pane = None if is_camera_moving else self._view.pane_at(self.pixel)
            document.hover(self._handle_at(pane))
            if pane is None:
                return
        self._abort(event)

    def _dragged_positions(self):
        drag, pixel, document = self._drag, self.pixel, self._document
        if self._pane is None and self._interactor.GetShiftKey():
            if self._normal is None:
                grabbed = document.state.grips.deformed[document.grabbed]
                self._normal = self._picker.normal(grabbed)
            return drag.along(self._normal, pixel)
        if self._pane is None and self._interactor.GetControlKey():
            point = self._picker.hit(pixel)
            return drag.in_view_plane(pixel) if point is None else drag.to(point)
        return drag.in_view_plane(pixel)

    def _release(self, interactor, event):
        # the last movement may be later than the release: X11's are merged during a slow picture
        interactor.InvokeEvent("MouseMoveEvent")
        if not self._is_busy:
            return
        document, corner, grabbed = self._document, self._band_corner, self._document.grabbed
        is_click = self._is_click
        is_slice_moving = self._pane is not None and self._drag is None
        self.finish()
        if is_slice_moving:
            if not (is_click and self._click_beside()):
                document.move_slices(self._slices.point)
        elif corner is not None:
            positions = document.state.grips.deformed
            document.select(self._view.scene.projection.between(positions, corner, self.pixel))
        elif is_click and grabbed is not None and interactor.GetControlKey():
            document.select(np.setxor1d(document.selected, [grabbed]))
        self._abort(event)

    def _end_camera(self, style, event):
        """A click, if the mouse has not moved the camera."""
        is_click, self._is_camera_click = self._is_camera_click and self._is_click, False
        if is_click:
            self._click_beside()

    def _leave(self, interactor, event):
        if not self._is_busy:
            self._document.hover(None)

    def _turn_wheel(self, interactor, event):
        pane = self._view.pane_at(self.pixel)
        step = 1 if "Forward" in event else -1
        if interactor.GetControlKey():
            self._document.zoom(self.pixel, self.pixel, _ZOOM**step)
        elif pane is not None:
            self._document.move_slices(self._slices.point_after(pane, step))
        else:
            return
        self._abort(event)

    def _press_other_button(self, interactor, event):
        if self._view.pane_at(self.pixel) is not None:
            if "Right" in event:
                self.finish()
                self._pressed_pixel = self._adjusted_pixel = self.pixel
            else:
                self._panned_pixel = self.pixel
            self._abort(event)

    def _release_other_button(self, interactor, event):
        if self._adjusted_pixel is not None:
            self._document.move_slices(self._slices.point)
        elif self._panned_pixel is None:
            return
        self._adjusted_pixel = self._panned_pixel = None
        self._abort(event)

    def _double_click(self, interactor, event):
        """Enlarge a pane, without the effect of the first click."""
        self.finish()
        if self._document.committed is not self._before_click:
            self._document.step(-1, "")
        self._document.say("")
        self._on_double_click(self.pixel)
        self._abort(event)

    def _adjust(self):
        """Brightness by movements up and down, contrast by those to the right and left."""
        right, up = (self.pixel - self._adjusted_pixel) / _ADJUSTING_PIXELS
        self._adjusted_pixel = self.pixel
        with self._document.reporting_errors():
            self._view.adjust(self._pressed_pixel, up, 2.0**right)
        self._document.draw_slices()

    @property
    def _is_click(self):
        return np.linalg.norm(self.pixel - self._pressed_pixel) <= _CLICK_DISTANCE

    def _click_beside(self):
        """Called for a click beside handles; whether it has an effect."""
        return False

    def _drag_to(self, positions):
        self._document.drag_to(positions)

    def _end_drag(self):
        self._document.end_drag()

    def _show_band(self, corners):
        self._view.overlay.set_band(corners)
        self._document.draw(is_moving=True)

    def _projection_of(self, pane):
        scene, *_ = self._view.scenes_at(self.pixel)
        return scene.projection if pane is None else pane.projection

    def _handle_at(self, pane):
        """Row of the grip under the mouse in a pane, or in the 3-D view for None; or None."""
        positions = self._document.state.grips.deformed
        projection = self._projection_of(pane)
        if pane is None:
            return projection.nearest(positions, self.pixel, _PICK_DISTANCE)
        rows = self._slices.rows_near(pane, positions)
        nearest = projection.nearest(positions[rows], self.pixel, _PICK_DISTANCE)
        return None if nearest is None else int(rows[nearest])


class Drag:
    """A drag of handles at positions (m, 3) by one at `grabbed` (3,), from a pixel of the mouse."""

    def __init__(self, projection, positions, grabbed, pixel):
        self._projection, self._positions, self._grabbed = projection, positions, grabbed
        self._start = np.array(pixel, float)
        self._grabbed_pixel = projection.pixels(grabbed[None])[0]

    def in_view_plane(self, pixel):
        """New positions (m, 3) at the same depth."""
        target = self._grabbed_pixel[:2] + np.asarray(pixel) - self._start
        depth = self._grabbed_pixel[2]
        return self._positions + self._projection.world(target, depth) - self._grabbed

    def along(self, direction, pixel):
        """New positions along a unit vector, as far as the mouse has moved along it."""
        step = self._projection.pixel_size(self._grabbed[None])[0]
        tip = self._projection.pixels((self._grabbed + step * direction)[None])[0]
        projected = tip[:2] - self._grabbed_pixel[:2]
        length = np.linalg.norm(projected)
        if length < _MIN_PIXELS:  # towards the eye: up is outwards
            projected, length = np.array([0.0, 1.0]), 1.0
        pixels = (np.asarray(pixel) - self._start) @ projected / length
        return self._positions + pixels / max(length, _MIN_PIXELS) * step * direction

    def to(self, point):
        """New positions, with the grabbed handle at a point (3,)."""
        return self._positions + point - self._grabbed
