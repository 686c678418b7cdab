"""Downloads of saved files, and uploads of data and handles."""

import asyncio
import hashlib
import shutil
import tempfile
import zipfile
from pathlib import Path
from urllib.parse import quote

from aiohttp import web

from vtk_mls import io
from vtk_mls.base import child_process
from vtk_mls.base.errors import InputError
from vtk_mls.editor import State, sessions, time_steps
from vtk_mls.editor.autosave import Autosave
from vtk_mls.editor.handle_polydata import handle_values
from vtk_mls.editor.matching.target import Target
from vtk_mls.files import session_files
from vtk_mls.files.paths import replacing

ALL = "all.zip"
MAX_DATA_BYTES, MAX_HANDLE_BYTES = 2 << 30, 64 << 20  # in an upload
_READ_STEP = "vtk_mls.editor.time_steps:read"
_READERS = {"data": _READ_STEP, "target": _READ_STEP, "handles": "vtk_mls.io:read_control_points"}
_KINDS = *_READERS, "session"
_READING_TIMEOUT = 300  # seconds


class Transfers:
    """Serves saved files, and shows uploaded ones.

    `folder` is for uploads, of at most `max_bytes`. `on_open` is called with the name of uploaded
    data that are shown.
    """

    def __init__(self, session, folder, on_open, max_bytes=MAX_DATA_BYTES):
        self._session, self._folder, self._max_bytes = session, folder, max_bytes
        self._on_open = on_open
        self._current = {}  # folders of the data and the target that are shown
        self._upload_lock = asyncio.Lock()

    @property
    def routes(self):
        """Routes of aiohttp."""
        return [
            web.get("/saved/{name}", self.download),
            web.post("/send/{kind}/{name}", self.upload),
        ]

    async def download(self, request):
        """One of the saved files, or all of them."""
        saver, name = self._session.editor.saver, request.match_info["name"]
        files = {path.name: path for path in saver.files}
        if not files:
            raise web.HTTPNotFound(text="Nothing is saved yet.")
        if name == ALL:
            path = self._folder / ALL
            await asyncio.to_thread(_zip, path, saver.files)
            headers = _as_attachment(f"{saver.folder.resolve().name}.zip")
            return web.FileResponse(path, headers=headers)
        if name not in files:
            raise web.HTTPNotFound(text="There is no such file.")
        return web.FileResponse(files[name], headers=_as_attachment(name))

    async def upload(self, request):
        """Show uploaded data, or handles on the current data; the answer is a sentence."""
        kind, name = request.match_info["kind"], Path(request.match_info["name"]).name
        if kind not in _KINDS or not name.strip("."):
            raise web.HTTPNotFound()
        limit = self._max_bytes if kind in ("data", "target") else MAX_HANDLE_BYTES
        async with self._upload_lock:  # at most one file beside the current ones
            folder = Path(tempfile.mkdtemp(dir=self._folder))
            try:
                await self._receive(request, kind, folder / name, limit)
            except web.HTTPException:
                raise
            except Exception as error:
                if isinstance(error, InputError) and error.path == str(folder / name):
                    error = InputError(error.predicate, path=name)
                no_text = {MemoryError: "There is not enough memory"}
                text = " ".join(str(error).split()) or no_text.get(type(error), repr(error))
                return web.Response(status=400, text=text)
            finally:
                if folder not in self._current.values():
                    shutil.rmtree(folder, ignore_errors=True)
        return web.Response(text=f"{name} is shown.")

    async def _receive(self, request, kind, path, limit):
        digest = await self._write(request, path, limit)
        if kind == "session":
            await asyncio.wrap_future(self._session.call(lambda: self._resume(path)))
            return
        await asyncio.to_thread(_check, _READERS[kind], path)
        if kind == "handles":
            await asyncio.wrap_future(self._session.call(lambda: self._show_handles(path)))
        else:
            await self._show_dataset(kind, path, digest)

    async def _write(self, request, path, limit):
        """Write the upload to a file, and return its SHA-256."""
        name, digest, size = path.name, hashlib.sha256(), 0
        with open(path, "wb") as file:
            async for chunk in request.content.iter_chunked(1 << 20):
                size += len(chunk)
                if size > limit:
                    raise ValueError(f"`{name}` has more than {limit >> 20} MB, which is the limit")
                digest.update(chunk)
                file.write(chunk)
        if size == 0:
            raise ValueError(f"`{name}` is empty")
        return digest.hexdigest()

    def _show_handles(self, path):
        editor = self._session.editor
        polydata = io.read_control_points(path)
        has_shapes = polydata.GetNumberOfLines() + polydata.GetNumberOfPolys() > 0
        # lines and surfaces are curves and regions
        values = handle_values(polydata, "cells" if has_shapes else "points")
        state = editor.state.changed(**values, anchored=None, enabled=None)
        editor.select([])
        if not editor.change(state):
            raise ValueError(editor.message)

    def _resume(self, path):
        """Show the edit and the views of a session of the data that are shown."""
        editor, session = self._session.editor, session_files.read(path)
        names, current_names = _names(session.paths), _names(editor.saver.paths)
        if editor.target is not None:
            current_names += _names([editor.target.path])
        if names != current_names:
            raise ValueError(
                f"`{path.name}` is a session of {' and '.join(names)}, and "
                f"{' and '.join(current_names)} is shown: open it with `vtk-mls view`"
            )
        state = sessions.state_of(session, path.name)
        editor.finish()
        editor.select([])
        if not editor.change(state):
            raise ValueError(editor.message)
        editor.show_views(session.views)

    async def _show_dataset(self, kind, path, digest):
        dataset = await asyncio.to_thread(time_steps.read, path)
        if not dataset.IsA("vtkDataSet"):
            raise ValueError(f"`{path.name}` has blocks; single images and meshes are shown")
        if kind == "target":
            target = Target(dataset, path, is_upload=True)
            await asyncio.wrap_future(self._session.call(lambda: self._session.set_target(target)))
            replaced = {"target"}
        else:
            await asyncio.wrap_future(self._session.call(lambda: self._open(dataset, path, digest)))
            replaced = {"data", "target"}  # other data are opened without a target
            self._on_open(path.name)
        for other in replaced & self._current.keys():
            shutil.rmtree(self._current.pop(other), ignore_errors=True)
        self._current[kind] = path.parent

    def _open(self, dataset, path, digest):
        current = self._session.editor.state
        state = State([], [], map_tolerance=current.map_tolerance, device=current.device)
        self._session.open([dataset], state, [path], Autosave(path, digest=digest))


def _check(reader, path):
    """Read a file in a child, and raise its error if that fails."""
    try:
        child_process.run(reader, str(path), timeout=_READING_TIMEOUT)
    except TimeoutError:
        raise ValueError(f"VTK's reader does not come to an end with `{path.name}`") from None
    except ChildProcessError:
        raise ValueError(f"`{path.name}` makes VTK's reader crash") from None


def _names(paths):
    return [f"`{Path(path).name}`" for path in paths]


def _zip(archive, files):
    options = {"compression": zipfile.ZIP_DEFLATED, "compresslevel": 1}
    with replacing(archive) as new, zipfile.ZipFile(new, "w", **options) as zip_file:
        for path in files:
            zip_file.write(path, path.name)


def _as_attachment(name):
    return {"Content-Disposition": f"attachment; filename*=UTF-8''{quote(name)}"}
