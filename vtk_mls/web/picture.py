"""The picture on the page: frames to it, mouse and keys from it, through a web socket."""

from __future__ import annotations

import asyncio
import json
import threading
from contextlib import suppress

from aiohttp import WSMsgType, web
from vtkmodules.vtkIOImage import vtkJPEGWriter
from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

from vtk_mls.web import events

_QUALITY = 88
TAKEN_OVER = 4001  # the socket is closed with this code when another tab goes on
_LONGEST = 4096  # characters of a message
_SIDES = 64, 4096  # pixels
_LEAVE = {"type": "leave"}


class Picture:
    """Sends the newest frame whenever the page has shown the last one: none wait in a queue.

    Parameters
    ----------
    session : Session
    """

    def __init__(self, session):
        self._session, self._socket, self._loop = session, None, None
        self._is_new, self._is_awaited = False, False
        self._pending, self._lock = [], threading.Lock()
        session.drawn = self._drawn
        session.idle = self.send_frame

    async def connect(self, request):
        """Serve a tab until it is closed, or until another one takes over."""
        socket = web.WebSocketResponse(max_msg_size=_LONGEST, heartbeat=20)
        await socket.prepare(request)
        before, self._socket, self._loop = self._socket, socket, asyncio.get_running_loop()
        if before is not None:
            await before.close(code=TAKEN_OVER)
        self._let_go()
        self._is_awaited = True
        self._session.call(self._refresh)
        async for message in socket:
            if message.type != WSMsgType.TEXT or socket is not self._socket:
                break
            with suppress(ValueError, KeyError, TypeError, OverflowError, RecursionError):
                self._hear(json.loads(message.data))
        if socket is self._socket:
            self._socket = None
            self._let_go()
        return socket

    def _let_go(self):
        """Let go of what a page's mouse held that is gone: no other page has its button."""
        with self._lock:
            self._pending.extend([*({"type": "up", "button": i} for i in range(3)), _LEAVE])
        self._session.call(self._work)

    def send_frame(self):
        """Send a frame if there is a new one, and the page waits; called by the worker."""
        socket = self._socket
        if self._is_new and self._is_awaited and socket is not None:
            self._is_new = self._is_awaited = False
            frame = _encoded(self._session.window)
            asyncio.run_coroutine_threadsafe(_send(socket, frame), self._loop)

    def _hear(self, event):
        kind = event["type"]
        if kind == "shown":
            self._is_awaited = True
            self._session.call(self.send_frame)
        elif kind == "size":
            size = [int(min(max(float(event[side]), _SIDES[0]), _SIDES[1])) for side in ("w", "h")]
            self._session.call(lambda: self._session.resize(size))
        else:
            with self._lock:
                self._pending.append(event)
            self._session.call(self._work)

    def _work(self):
        """Do what the page wants; of moves that have come meanwhile only the newest."""
        with self._lock:
            pending, self._pending = self._pending, []
        for event in events.newest(pending):
            with suppress(ValueError, KeyError, TypeError, OverflowError):  # no such event
                self._session.send(event)
        self.send_frame()

    def _refresh(self):
        self._is_new = True
        self.send_frame()

    def _drawn(self):
        self._is_new = True


async def _send(socket, frame):
    with suppress(ConnectionError, RuntimeError):  # it has just been closed
        await socket.send_bytes(frame)


def _encoded(window):
    grab, writer = vtkWindowToImageFilter(), vtkJPEGWriter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.ShouldRerenderOff()
    writer.SetInputConnection(grab.GetOutputPort())
    writer.SetQuality(_QUALITY)
    writer.WriteToMemoryOn()
    writer.Write()
    return bytes(memoryview(writer.GetResult()))
