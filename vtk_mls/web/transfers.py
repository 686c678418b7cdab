"""Files to and from the page: what is saved, and data or handles that it sends."""

from __future__ import annotations

import asyncio
import hashlib
import os
import shutil
import sys
import tempfile
import zipfile
from pathlib import Path

from aiohttp import web

from vtk_mls import io
from vtk_mls.editor import State
from vtk_mls.editor.autosave import Autosave
from vtk_mls.files.replacing import replacing

ALL = "all.zip"
MOST_OF_HANDLES = 64 << 20  # bytes
# Reads a file where a reader that crashes takes nothing with it.
_TRIAL = "import sys; from vtk_mls import io; getattr(io, sys.argv[1])(sys.argv[2])"
_READERS = {"data": "read_dataset", "handles": "read_control_points"}
_PATIENCE = 300  # seconds


class Transfers:
    """Answers the page's requests for files, and takes its own.

    Parameters
    ----------
    session : Session
    folder : Path
        For what is sent.
    most : int
        Bytes that data may have.
    opened : callable
        Called with the name of data that are shown.
    """

    def __init__(self, session, folder, most, opened):
        self._session, self._folder, self.most = session, folder, most
        self._opened, self._shown = opened, None  # the folder of data that are shown
        self._one_by_one = asyncio.Lock()

    @property
    def routes(self):
        """Those of aiohttp."""
        return [
            web.get("/saved/{name}", self.saved),
            web.post("/send/{kind}/{name}", self.sent),
        ]

    async def saved(self, request):
        """One of the files that were saved last, or all of them."""
        saver, name = self._session.editor.saver, request.match_info["name"]
        files = {path.name: path for path in saver.files}
        if not files:
            raise web.HTTPNotFound(text="Nothing is saved yet.")
        if name == ALL:
            return await self._zipped(saver)
        if name not in files:
            raise web.HTTPNotFound(text="There is no such file.")
        return web.FileResponse(files[name], headers=_as_attachment(name))

    async def _zipped(self, saver):
        """All files as one, which is made on the disk."""
        path = self._folder / ALL
        await asyncio.to_thread(_zip, path, saver.files)
        headers = _as_attachment(f"{saver.folder.resolve().name}.zip")
        return web.FileResponse(path, headers=headers)

    async def sent(self, request):
        """Take data, or handles for the data that are shown; a sentence says what became of it."""
        kind, name = request.match_info["kind"], Path(request.match_info["name"]).name
        most = {"data": self.most, "handles": MOST_OF_HANDLES}.get(kind)
        if most is None or not name.strip("."):
            raise web.HTTPNotFound()
        async with self._one_by_one:  # there is one file more than what is shown, at most
            folder = Path(tempfile.mkdtemp(dir=self._folder))
            try:
                await self._taken(request, kind, folder / name, most)
            except (OSError, ValueError, TypeError, RuntimeError, MemoryError) as error:
                text = " ".join(str(error).split()) or "There is not enough memory"
                return web.Response(status=400, text=text.replace(f"{folder}{os.sep}", ""))
            finally:
                if folder != self._shown:
                    shutil.rmtree(folder, ignore_errors=True)
        return web.Response(text=f"{name} is shown.")

    async def _taken(self, request, kind, path, most):
        """Receive a file, and show what is in it."""
        digest = await self._received(request, path, most)
        await _try(_READERS[kind], path)
        if kind == "handles":
            await asyncio.wrap_future(self._session.call(lambda: self._take_handles(path)))
        else:
            await self._take_data(path, digest)

    async def _received(self, request, path, most):
        """Write what is sent to a path; a digest of it."""
        name, digest, size = path.name, hashlib.sha256(), 0
        with open(path, "wb") as file:
            async for chunk in request.content.iter_chunked(1 << 20):
                size += len(chunk)
                if size > most:
                    raise ValueError(f"`{name}` has more than {most >> 20} MB, which is the limit")
                digest.update(chunk)
                file.write(chunk)
        if size == 0:
            raise ValueError(f"`{name}` is empty")
        return digest.hexdigest()

    def _take_handles(self, path):
        editor = self._session.editor
        state = _state_of(io.read_control_points(path), editor.state)
        editor.select([])
        if not editor.change(state):
            raise ValueError(editor.message)

    async def _take_data(self, path, digest):
        dataset = await asyncio.to_thread(io.read_dataset, path)
        if not dataset.IsA("vtkDataSet"):
            raise ValueError(f"`{path.name}` has blocks; single images and meshes are shown")
        await asyncio.wrap_future(self._session.call(lambda: self._show(dataset, path, digest)))
        before, self._shown = self._shown, path.parent
        if before is not None:
            shutil.rmtree(before, ignore_errors=True)
        self._opened(path.name)

    def _show(self, dataset, path, digest):
        autosave = Autosave(path, digest=digest)
        shown = self._session.editor.state
        state = State([], [], map_tolerance=shown.map_tolerance, device=shown.device)
        self._session.open([dataset], state, [path], autosave)


async def _try(reader, path):
    """Read a file in another process, and raise ValueError if that fails."""
    child = await asyncio.create_subprocess_exec(
        *(sys.executable, "-c", _TRIAL, reader, str(path)),
        stdout=asyncio.subprocess.DEVNULL,
        stderr=asyncio.subprocess.PIPE,
    )
    try:
        _, said = await asyncio.wait_for(child.communicate(), _PATIENCE)
    except asyncio.TimeoutError:
        child.kill()
        await child.wait()
        raise ValueError(f"VTK's reader does not come to an end with `{path.name}`") from None
    if child.returncode:
        raise ValueError(_last_words(said) or f"`{path.name}` makes VTK's reader crash")


def _state_of(points, state):
    """The state with control points of a file."""
    from vtk_mls.vtk import arrays

    rest = arrays.to_numpy(points.GetPoints().GetData())
    shift = points.GetPointData().GetArray("Displacement")
    weight = points.GetPointData().GetArray("Weight")
    deformed = rest if shift is None else rest + arrays.to_numpy(shift)
    weights = None if weight is None else arrays.to_numpy(weight).ravel()
    return state.changed(rest=rest, deformed=deformed, weights=weights, labels=(), anchored=None)


def _last_words(said):
    """The message of the exception that ended a Python."""
    lines = [line for line in said.decode(errors="replace").splitlines() if line.strip()]
    name, _, text = (lines or [""])[-1].partition(": ")
    return text if name.isidentifier() else ""


def _zip(archive, files):
    how = {"compression": zipfile.ZIP_DEFLATED, "compresslevel": 1}
    with replacing(archive) as new, zipfile.ZipFile(new, "w", **how) as written:
        for path in files:
            written.write(path, path.name)


def _as_attachment(name):
    from urllib.parse import quote

    return {"Content-Disposition": f"attachment; filename*=UTF-8''{quote(name)}"}
