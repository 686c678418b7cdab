"""`vtk-mls view`: a server of one session on a page."""

import asyncio
import os
import socket
import sys
import time
import traceback
from contextlib import suppress
from pathlib import Path

from aiohttp import web
from trame.app import get_server

from vtk_mls.editor import saving
from vtk_mls.editor.autosave import Autosave
from vtk_mls.files import session_files
from vtk_mls.web import access, browsers, edits, page_layout
from vtk_mls.web.picture import Picture
from vtk_mls.web.session import Session
from vtk_mls.web.transfers import Transfers

LOOPBACK, PORT = "127.0.0.1", 8080
_LOCAL_HOSTS = LOOPBACK, "localhost", "::1"
_ALL_ADDRESSES = "0.0.0.0", "::"
_REMOTE_WARNING = (
    "vtk-mls: `--host {host}` lets other machines reach the page: whoever has its address with the "
    "token can edit and download files, and nothing is encrypted. In an untrusted network omit "
    f"`--host`, and use ssh -L {PORT}:{LOOPBACK}:{PORT}."
)
_WATCH_SECONDS = 0.5
_PAGE = "vtk_mls_page"  # path of the page's own files
# Titles of the long tasks, which the page can stop, by the methods of the editor.
_SAVING = {"save": "Saving", "save_session": "Saving"}
_TASKS = {**_SAVING, "refine": "Refining", "refine_all": "Refining"}


class Page:
    """One session and its page.

    `folder` is for uploads; `results` gets a folder for each uploaded dataset that is saved.
    """

    def __init__(self, folder, results):
        os.environ.setdefault("TRAME_ARGS", "--server")  # hides our options from trame
        os.environ["WSLINK_READY_MSG"] = ""
        self._results, self._loop = results, None
        self._task, self._watching, self._is_stopping = None, None, False
        self.session = Session(self._update)
        self._picture = Picture(self.session)
        self._transfers = Transfers(self.session, folder, self._note_upload)
        self._server = get_server("vtk-mls", client_type="vue3")
        files = {"scripts": [f"{_PAGE}/picture.js"], "styles": [f"{_PAGE}/page.css"]}
        files["serve"] = {_PAGE: str(Path(__file__).with_name("page"))}
        self._server.enable_module({**files, "vue_use": ["vtkMlsPage"]})
        self._server.state.update(
            {
                "trame__favicon": f"{_PAGE}/icon.svg",
                "theme": "dark",
                "is_saving": False,
                "task": "",  # title of the running task, while `is_saving`
                "progress": 0,
                "is_busy": False,  # with something that takes longer than the page should
                "has_panel": True,  # on wide pages; on narrow ones:
                "has_sheet": False,
                "selects_several": False,
                "hidden_offer": "",  # hidden until there is another one
                "files": [],
                "saved_folder": "",
            }
        )

    def open(self, datasets, state, paths, folder, target=None, session=None):
        """Show data, and save in a folder (None: beside the data), before the page is served."""

        def show():
            self.session.open(datasets, state, paths, Autosave(paths[0]), target)
            if folder is not None:
                self.session.editor.saver.set_output(folder)
            if session is not None:
                self.session.editor.resume_session(*session)

        self.session.call(show).result()
        name = Path(paths[0]).name
        self._server.state.update({"title": name, "trame__title": f"{name} - vtk-mls"})

    def serve(self, host, port, opens_browser):
        """Print the address of the page, maybe open it, and answer until the process is ended."""
        token = access.new_token()

        def bind(server):
            server.app.middlewares.append(access.middleware(token))
            server.app.add_routes([web.get("/picture", self._picture.connect)])
            server.app.add_routes([web.post("/paraview/", _session_place)])
            server.app.add_routes(self._transfers.routes)

        def begin(**_):
            self._loop = asyncio.get_running_loop()
            self._watching = self._loop.create_task(self._watch())
            address = f"http://{_address_name(host)}:{self._server.port}/?token={token}"
            text = f"The page is at {address}\n(Ctrl-C ends it; unsaved handles are kept.)"
            print(text, flush=True)
            if opens_browser:
                self._loop.run_in_executor(None, browsers.open_page, address)

        self._server.controller.on_server_bind.add(bind)
        self._server.controller.on_server_ready.add(begin)
        page_layout.build(self._server, self._edit, self._begin)
        is_quiet = {"open_browser": False, "show_connection_info": False}
        self._server.start(port=port, host=host, timeout=0, **is_quiet)

    async def _watch(self):
        """Show when the editor takes long, as when it compiles kernels."""
        while True:
            await asyncio.sleep(_WATCH_SECONDS)
            since = self.session.working_since
            is_busy = since is not None and time.monotonic() - since > _WATCH_SECONDS
            if is_busy != self._server.state.is_busy:
                self._show(is_busy=is_busy)

    def _note_upload(self, name):
        """Called when uploaded data are shown."""
        self._show(title=name, files=[], hidden_offer="")
        saver = self.session.editor.saver
        saver.within, saver.copies_data = self._results, True

    def _edit(self, name, value=None):
        """Queue an edit.

        A tab's messages are answered one after the other: nothing here waits for the editor.
        """
        future = self.session.call(lambda: edits.apply(self.session, name, value))
        future.add_done_callback(_print_failure)

    def _begin(self, name):
        if name == "stop":
            self._is_stopping = True
        elif name in _TASKS and self._task is None:
            self._is_stopping = False
            self._task = self._loop.create_task(self._run(name))

    async def _run(self, name):
        self._show(is_saving=True, progress=0, task=_TASKS[name])
        with suppress(Exception):  # the editor shows the reason
            await asyncio.wrap_future(self.session.call(lambda: self._run_in_editor(name)))
        self._task = None
        self._show(is_saving=False)

    def _run_in_editor(self, name):
        """Run one of `_TASKS` in the editor's thread; the editor shows errors."""
        editor = self.session.editor
        editor.finish()
        with editor.document.reporting_errors():
            saver = editor.saver
            saver.progress = self._progress
            if name not in _SAVING:
                getattr(editor, name)(progress=self._progress)
            elif getattr(editor, name)():
                folder, files = str(saver.files[0].parent.resolve()), _files(saver)
                self._update({"files": files, "saved_folder": folder, "has_files": True})

    def _progress(self, done):
        """Called by the editor's thread; whether to stop."""
        self._update({"progress": round(100 * done)})
        return self._is_stopping

    def _update(self, changed):
        """Show values; called by other threads."""
        if self._loop is None:
            self._server.state.update(changed)
        else:
            self._loop.call_soon_threadsafe(lambda: self._show(**changed))

    def _show(self, **values):
        with self._server.state as state:
            state.update(values)


def serve(datasets, state, paths, temporary, folder, address, opens_browser, *more):
    """Edit on a page until the process is ended; OSError if the address cannot be listened on.

    Arguments, and `more` of them, are as of `window.show`; `temporary` is a folder for uploads. The
    address is (host, port); None is port 8080, or a free port if that is in use.
    """
    host, port = address
    port = _free_port(host, port)
    folder = None if folder is None else Path(folder)
    page = Page(Path(temporary), folder or Path())
    page.open(datasets, state, paths, folder, *more)
    if host not in _LOCAL_HOSTS:
        print(_REMOTE_WARNING.format(host=host), file=sys.stderr, flush=True)
    page.serve(host, port, opens_browser)


async def _session_place(request):
    """Tell trame's script in the page where its socket is; it asks before it tries this place."""
    scheme = "wss" if request.headers.get("Origin", "").startswith("https:") else "ws"
    return web.json_response({"sessionURL": f"{scheme}://USE_HOST/ws"})


def _print_failure(future):
    """Print the traceback of an error that the editor does not show."""
    if future.exception() is not None:
        traceback.print_exception(future.exception())


def _address_name(host):
    if host in _ALL_ADDRESSES:
        return socket.gethostname()
    return f"[{host}]" if ":" in host else host


def _free_port(host, port):
    for candidate in (PORT, 0) if port is None else (port,):
        try:
            addresses = socket.getaddrinfo(host, candidate, type=socket.SOCK_STREAM)
            family, _, _, _, address = addresses[0]
            with socket.create_server(address[:2], family=family) as listener:
                return listener.getsockname()[1]
        except OSError as error:
            reason = error
    raise OSError(f"`{host}:{port or PORT}` cannot be listened on: {reason.strerror or reason}")


def _files(saver):
    is_filled = any(saving.FIELD in text for text in saver.warnings)
    return [
        {"name": path.name, "size": path.stat().st_size, "what": _description(path.name, is_filled)}
        for path in saver.files
    ]


def _description(name, is_filled):
    """The contents of a file that `Saver` has written."""
    contents = {
        saving.HANDLES: "the handles",
        saving.AT_REST: "handles at rest, for 3D Slicer",
        saving.MOVED: "handles as they are now, for 3D Slicer",
        saving.FIELD: "displacement field" + "; it fills the gap of a cut" * is_filled,
        saving.PICTURE: "picture",
        session_files.NAME: "session, opens again with `vtk-mls view`",
        saving.SCRIPT: "the same deformation without the editor",
    }
    return contents.get(name, "cut" if name.startswith("cut-") else "deformed data")
