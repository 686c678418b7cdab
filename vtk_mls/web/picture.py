"""The picture on the page: frames to it, mouse and keys from it, through a web socket.

trame's remote area (trame-rca 2.11) was measured: it takes 1.4 times as long from a step of the
mouse to a frame, and would replace only the mouse in `picture.js`.
"""

import asyncio
import json
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress

from aiohttp import WSMsgType, web
from vtkmodules.vtkIOImage import vtkJPEGWriter

from vtk_mls.editor.saving import picture_of
from vtk_mls.vtk.objects import configured

_JPEG_QUALITY = 88
TAKEN_OVER = 4001  # the socket is closed with this code when another tab takes over
_MAX_MESSAGE = 4096  # characters
_MIN_SIDE, _MAX_SIDE = 64, 4096  # pixels
_MAX_WHEEL_STEPS = 10  # in one event
_BUTTONS = "Left", "Middle", "Right"
_POINTER_EVENTS = {
    "move": "MouseMoveEvent",
    "leave": "LeaveEvent",
    "double": "LeftButtonDoubleClickEvent",
    **{f"down{i}": f"{button}ButtonPressEvent" for i, button in enumerate(_BUTTONS)},
    **{f"up{i}": f"{button}ButtonReleaseEvent" for i, button in enumerate(_BUTTONS)},
}
# X's names of keys that browsers name otherwise
_KEY_SYMBOLS = {
    **{"Backspace": "BackSpace", "Enter": "Return", " ": "space"},
    **{f"Arrow{name}": name for name in ("Up", "Down", "Left", "Right")},
}
_INVALID = ValueError, KeyError, TypeError, OverflowError, RecursionError  # from a foreign message


class Picture:
    """Sends the newest frame when the page has shown the previous one: frames never queue."""

    def __init__(self, session):
        self._session, self._socket, self._loop = session, None, None
        self._has_frame, self._page_is_ready = False, False
        self._events, self._lock = [], threading.Lock()
        self._encoder = ThreadPoolExecutor(1, "encoder")
        session.on_draw = self._note_frame
        session.on_idle = self.send_frame

    async def connect(self, request):
        """Serve a tab until it is closed or another tab takes over."""
        socket = web.WebSocketResponse(max_msg_size=_MAX_MESSAGE, heartbeat=20)
        await socket.prepare(request)
        previous, self._socket, self._loop = self._socket, socket, asyncio.get_running_loop()
        if previous is not None:
            await previous.close(code=TAKEN_OVER)
        self._release_buttons()
        self._page_is_ready = self._has_frame = True
        self._session.call(self.send_frame)
        async for message in socket:
            if message.type != WSMsgType.TEXT or socket is not self._socket:
                break
            with suppress(*_INVALID):
                self._receive(json.loads(message.data))
        if socket is self._socket:
            self._socket = None
            self._release_buttons()
        return socket

    def send_frame(self):
        """Send a new frame if the page is ready; called by the session's thread."""
        socket = self._socket
        if self._has_frame and self._page_is_ready and socket is not None:
            self._has_frame = self._page_is_ready = False
            self._encoder.submit(self._send_encoded, socket, picture_of(self._session.window))

    def _send_encoded(self, socket, pixels):
        """Encode and send a frame, while the session's thread draws the next."""
        asyncio.run_coroutine_threadsafe(_send(socket, _jpeg(pixels)), self._loop)

    def _receive(self, event):
        if event["type"] == "shown":
            self._page_is_ready = True
            self._session.call(self.send_frame)
        elif event["type"] == "size":
            size = [int(min(max(float(event[k]), _MIN_SIDE), _MAX_SIDE)) for k in ("w", "h")]
            self._session.call(lambda: self._session.resize(size))
        else:
            self._queue(event)

    def _release_buttons(self):
        """Release the mouse of a closed page, since no other page has its button down."""
        self._queue(*({"type": "up", "button": i} for i in range(3)), {"type": "leave"})

    def _queue(self, *events):
        with self._lock:
            self._events.extend(events)
        self._session.call(self._work)

    def _work(self):
        """Send queued events to the editor; of successive moves only the last one."""
        with self._lock:
            events, self._events = self._events, []
        for event, following in zip(events, [*events[1:], {}]):
            with suppress(*_INVALID):
                if not event["type"] == following.get("type") == "move":
                    self._session.send(event)
        self.send_frame()

    def _note_frame(self):
        self._has_frame = True


def send_event(interactor, event):
    """Send an event of the page, a dict, to a vtkRenderWindowInteractor.

    Its `type` is "move", "leave", "double" (click), "down" or "up" with `button`, "wheel" with
    `steps`, or "key" with `key`; `x` and `y` are fractions of the picture, from its upper left
    corner; `ctrl`, `shift`.
    """
    kind = event["type"]
    if kind == "wheel":
        steps = int(event["steps"])
        name = "MouseWheelForwardEvent" if steps > 0 else "MouseWheelBackwardEvent"
        for _ in range(min(abs(steps), _MAX_WHEEL_STEPS)):
            _invoke(interactor, event, name)
    elif kind == "key":
        symbol = _KEY_SYMBOLS.get(event["key"], event["key"])
        for name in ("KeyPressEvent", "CharEvent", "KeyReleaseEvent"):
            _invoke(interactor, event, name, symbol)
    else:
        button = int(event["button"]) if kind in ("down", "up") else ""
        _invoke(interactor, event, _POINTER_EVENTS[f"{kind}{button}"])


def pixel_of(window, x, y):
    """The pixel (x, y) of fractions of the picture."""
    width, height = window.GetSize()
    return round(float(x) * (width - 1)), round((1 - float(y)) * (height - 1))


def _invoke(interactor, event, name, symbol=None):
    x, y = interactor.GetEventPosition()
    if "x" in event:
        x, y = pixel_of(interactor.GetRenderWindow(), event["x"], event["y"])
    code = symbol if symbol and len(symbol) == 1 and symbol.isascii() else chr(0)
    modifiers = int(bool(event.get("ctrl"))), int(bool(event.get("shift")))
    interactor.SetEventInformation(x, y, *modifiers, code, 0, symbol)
    interactor.InvokeEvent(name)


async def _send(socket, frame):
    with suppress(ConnectionError, RuntimeError):  # the socket has just been closed
        await socket.send_bytes(frame)


def _jpeg(pixels):
    # a progressive picture takes five times as long, here and in the browser
    options = {"Quality": _JPEG_QUALITY, "Progressive": False, "WriteToMemory": True}
    writer = configured(vtkJPEGWriter(), InputData=pixels, **options)
    writer.Write()
    return bytes(memoryview(writer.GetResult()))
