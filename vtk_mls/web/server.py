"""`vtk-mls view --web`: a server of one session, which prints the address of its page."""

from __future__ import annotations

import asyncio
import os
import socket
import sys
from pathlib import Path

from aiohttp import web
from trame.app import get_server

from vtk_mls.editor import saving
from vtk_mls.editor.autosave import Autosave
from vtk_mls.web import access, edits, page_layout, preparation
from vtk_mls.web.picture import Picture
from vtk_mls.web.session import Session
from vtk_mls.web.transfers import Transfers

LOOPBACK, PORT = "127.0.0.1", 8080
_OWN = LOOPBACK, "localhost", "::1"
_ANY = {"0.0.0.0": socket.gethostname, "::": socket.gethostname}
MOST = 2 << 30  # bytes of data that the page may send
_PAGE = "vtk_mls_page"  # where the page's own files are served
_READY = 100  # percent of the kernels


class Page:
    """One session and its page.

    Parameters
    ----------
    folder : Path
        For what is sent.
    within : Path
        Where folders are made for data that were sent and are saved.
    most : int
        Bytes that data may have that are sent.
    """

    def __init__(self, folder, within, most=MOST):
        os.environ.setdefault("TRAME_ARGS", "--server")  # the command's options are not trame's
        os.environ["WSLINK_READY_MSG"] = ""
        self._within, self._loop, self._preparing = within, None, None
        self.session = Session(self._told)
        self._picture = Picture(self.session)
        self._transfers = Transfers(self.session, folder, most, self._opened)
        self._server = get_server("vtk-mls", client_type="vue3")
        self._server.enable_module(
            {
                "serve": {_PAGE: str(Path(__file__).with_name("page"))},
                "scripts": [f"{_PAGE}/picture.js"],
                "styles": [f"{_PAGE}/page.css"],
                "vue_use": ["vtkMlsPage"],
            }
        )
        self._server.state.update(
            {
                "trame__favicon": f"{_PAGE}/icon.svg",
                "theme": "dark",
                "is_saving": False,
                "progress": 0,
                "prepared": _READY,
                "has_panel": True,  # on wide pages; on narrow ones:
                "has_sheet": False,
                "put_off": "",  # the offer that is not to be seen now
                "files": [],
                "files_at": "",
            }
        )

    def open(self, datasets, state, paths, saved_in):
        """Show data before the first page asks for them."""

        def show():
            self.session.open(datasets, state, paths, Autosave(paths[0]))
            self.session.editor.saver.folder = saved_in

        self.session.call(show).result()
        name = Path(paths[0]).name
        self._server.state.update({"title": name, "trame__title": f"{name} - vtk-mls"})

    def serve(self, host, port, ready):
        """Answer until the process is ended; `ready` is called with the address of the page."""
        token = access.new_token()

        def bind(server):
            server.app.middlewares.append(access.middleware(token))
            server.app.add_routes([web.get("/picture", self._picture.connect)])
            server.app.add_routes(self._transfers.routes)

        def begin(**_):
            self._loop = asyncio.get_running_loop()
            name = _ANY[host]() if host in _ANY else f"[{host}]" if ":" in host else host
            ready(f"http://{name}:{self._server.port}/?token={token}")
            self._preparing = self._loop.create_task(self._prepare())

        self._server.controller.on_server_bind.add(bind)
        self._server.controller.on_server_ready.add(begin)
        page_layout.build(self._server, self._edit, self._save, self._transfers.most)
        self._server.start(
            port=port, host=host, open_browser=False, show_connection_info=False, timeout=0
        )

    def _opened(self, name):
        """Called when the page has sent data that are shown now."""
        self._show(title=name, files=[], put_off="")
        saver = self.session.editor.saver
        saver.within, saver.copies_data = self._within, True

    async def _edit(self, name, value=None):
        await asyncio.wrap_future(self.session.call(lambda: edits.apply(self.session, name, value)))

    async def _save(self):
        if self._server.state.is_saving:
            return
        self._show(is_saving=True, progress=0)
        try:
            self.session.editor.saver.progress = self._progress
            folder = await asyncio.wrap_future(self.session.call(self.session.save))
            files = _files(self.session.editor.saver.files)
            self._show(files=files, files_at=str(folder.resolve()), has_files=True)
        except OSError:
            pass  # the editor has said why
        finally:
            self._show(is_saving=False)

    async def _prepare(self):
        """Have the other maps' kernels built, and show how far that is."""

        def told(done, of):
            self._show(prepared=round(_READY * done / of))

        await preparation.prepare(self.session.editor.state, told)
        self._show(prepared=_READY)

    def _progress(self, done):
        """Called by the editor's thread."""
        self._told({"progress": round(100 * done)})

    def _told(self, changed):
        """Called by the editor's thread."""
        if self._loop is None:
            self._server.state.update(changed)
        else:
            self._loop.call_soon_threadsafe(lambda: self._show(**changed))

    def _show(self, **values):
        with self._server.state as state:
            state.update(values)


def serve(datasets, state, paths, temporary, folder=None, address=(LOOPBACK, None)):
    """Edit on a page until the process is ended.

    Parameters
    ----------
    datasets, state, paths, folder
        As of `window.show`.
    temporary : path
        A folder for what the page sends.
    address : (host, port or None)
        To listen on; for None the usual port, or any if that is taken.

    Raises
    ------
    OSError
        If the address is not to be had.
    """
    host, port = address
    port = _free_port(host, port)
    folder = None if folder is None else Path(folder)
    page = Page(Path(temporary), folder or Path())
    page.open(datasets, state, paths, folder)
    _warn_of_others(host)
    page.serve(host, port, _announce)


def _announce(address):
    print(f"The page is at {address}\n(Ctrl-C ends it; unsaved handles are kept.)", flush=True)


def _warn_of_others(host):
    """Say what it means that a page is not served to this machine only."""
    if host not in _OWN:
        print(
            f"vtk-mls: `--host {host}` lets other machines reach the page: whoever has its address "
            "with the token can edit and take files, and what is sent is not encrypted. On a net "
            f"that is not yours leave `--host` out, and use ssh -L {PORT}:{LOOPBACK}:{PORT}.",
            file=sys.stderr,
            flush=True,
        )


def _free_port(host, port):
    """A port that can be listened on."""
    for each in (PORT, 0) if port is None else (port,):
        try:
            family, _, _, _, found = socket.getaddrinfo(host, each, type=socket.SOCK_STREAM)[0]
            with socket.create_server(found[:2], family=family) as one:
                return one.getsockname()[1]
        except OSError as error:
            reason = error
    raise OSError(f"`{host}:{port or PORT}` cannot be listened on: {reason.strerror or reason}")


def _files(paths):
    """Names and sizes for the list of files."""
    return [
        {"name": path.name, "size": _size(path.stat().st_size), "what": _what(path.name)}
        for path in paths
    ]


def _what(name):
    """What is in a file that `Saver` has written."""
    known = {
        saving.HANDLES: "the handles",
        saving.AT_REST: "handles at rest, for 3D Slicer",
        saving.MOVED: "handles as they are now, for 3D Slicer",
        saving.FIELD: "displacement field",
        saving.PICTURE: "picture",
        saving.SCRIPT: "does the same without the editor",
    }
    return known.get(name, "cut" if name.startswith("cut-") else "deformed data")


def _size(count):
    for unit in ("bytes", "kB", "MB"):
        if count < 1000:
            return f"{count:.0f} {unit}"
        count /= 1000
    return f"{count:.1f} GB"
