"""Downloads of the page are saved files; uploads have limits."""

from __future__ import annotations

import asyncio
import io as streams
import socket
import sys
import zipfile
from urllib.error import HTTPError
from urllib.request import urlopen

import numpy as np
import pytest
from command_fixtures import python
from page_server import server
from vtkmodules.vtkFiltersSources import vtkSphereSource

from vtk_mls import Ball, CurveHandle, RegionHandle, io
from vtk_mls.editor import State
from vtk_mls.editor.handle_polydata import handle_polydata
from vtk_mls.files import session_files
from vtk_mls.vtk.objects import output_of
from vtk_mls.web.session import Session

pytest.importorskip("trame", reason="the extra web is not installed")
_TIMEOUT = 60  # seconds


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    io.write_dataset(output_of(vtkSphereSource()), tmp_path / "ball.vtp")
    return tmp_path


@pytest.fixture
def client(folder):
    client = Client(folder)
    yield client
    client._loop.close()


class Client:
    """Sends requests to the routes of one session."""

    def __init__(self, folder, limit=1 << 20):
        from vtk_mls.web.transfers import Transfers

        self.folder, self._loop = folder / "sent", asyncio.new_event_loop()
        self.folder.mkdir()
        self.session, self.opened = Session(lambda changed: None), []
        data, paths = [io.read_dataset("ball.vtp")], ["ball.vtp"]
        self.session.call(lambda: self.session.open(data, State([], []), paths, None)).result()
        self.transfers = Transfers(self.session, self.folder, self.opened.append, limit)

    def ask(self, *requests):
        """(status, body) of requests (method, path, data), sent at once."""
        return self._loop.run_until_complete(self._ask(requests))

    async def _ask(self, requests):
        from aiohttp import web
        from aiohttp.test_utils import TestClient, TestServer

        application = web.Application()
        application.add_routes(self.transfers.routes)
        async with TestClient(TestServer(application)) as client:
            return await asyncio.gather(*(self._one(client, *request) for request in requests))

    async def _one(self, client, method, path, data=None):
        async with client.request(method, path, data=data) as answer:
            return answer.status, await answer.read()

    def save(self):
        """Save as the page does."""
        editor = self.session.editor
        assert self.session.call(editor.save).result()
        return editor.saver.folder


def test_only_saved_files_are_served(client, folder):
    assert client.ask(("GET", "/saved/all.zip"))[0][0] == 404
    (folder / "output").mkdir()
    for name in ("secret.txt", "picture.png"):
        (folder / "output" / name).write_text("of others")
    client.session.editor.saver.folder = folder / "output"
    client.save()
    secret, parent, picture, archive = client.ask(
        *(("GET", f"/saved/{name}") for name in ("secret.txt", "..", "picture.png", "all.zip"))
    )
    assert (secret[0], parent[0], picture[0], archive[0]) == (404, 404, 200, 200)
    assert picture[1] == (folder / "output" / "picture.png").read_bytes() != b"of others"
    names = zipfile.ZipFile(streams.BytesIO(archive[1])).namelist()
    assert "secret.txt" not in names
    assert {"handles.csv", "ball-deformed.vtp", "deform.py"} <= set(names)
    client.save()  # the same files anew
    assert names == [path.name for path in client.session.editor.saver.files]


def test_uploaded_data_keep_device_and_tolerance(client, folder):
    def change(editor):
        editor.change(editor.state.changed(map_tolerance=0.5, device="reference"))

    client.session.call(lambda: change(client.session.editor)).result()
    ((status, _),) = client.ask(("POST", "/send/data/b.vtp", (folder / "ball.vtp").read_bytes()))
    assert status == 200
    state = client.session.editor.state
    assert (len(state.cuts), state.map_tolerance, state.device) == (0, 0.5, "reference")


def test_uploaded_shapes_are_handles(client, folder):
    rest, motion = np.array([(0.0, 0, 0)]), np.eye(4)
    motion[:3, 3] = (0, 0, 0.1)
    handles = [RegionHandle(Ball((0.2, 0, 0), 0.1), motion), CurveHandle(np.eye(3), 2 * np.eye(3))]
    state = State(rest, rest + 0.1, labels=["tip"], handles=handles)
    io.write_dataset(handle_polydata(state), folder / "handles.vtp")
    data = (folder / "handles.vtp").read_bytes()
    status, text = client.ask(("POST", "/send/handles/handles.vtp", data))[0]
    assert (status, text) == (200, b"handles.vtp is shown.")
    state = client.session.editor.state
    assert state.labels == ("tip",)
    curve, region = state.handles
    np.testing.assert_array_equal(curve.deformed, 2 * np.eye(3))
    np.testing.assert_allclose(region.motion, motion, atol=1e-12)


def test_uploads_are_removed_when_other_data_are_shown(client, folder):
    ball = (folder / "ball.vtp").read_bytes()
    answers = client.ask(
        ("POST", "/send/data/ball.vtp", ball),
        ("POST", "/send/data/ball.vtp", ball + b"\n"),
        ("POST", "/send/handles/handles.csv", b"x,y,z\n0,0,0\n1,1,1\n"),
    )
    assert [status for status, _ in answers] == [200] * 3
    assert len(client.opened) == 2
    current = client.transfers._current["data"]
    assert [*client.folder.iterdir()] == [current]
    before = (current / "ball.vtp").read_bytes()
    answers = client.ask(
        ("POST", "/send/data/ball.vtp", b"broken"),
        ("POST", "/send/data/ball.vtp", streams.BytesIO(bytes((1 << 20) + 1))),
        ("POST", "/send/data/ball.vtp", b""),
    )
    assert [status for status, _ in answers] == [400] * 3
    assert answers[1][1] == b"`ball.vtp` has more than 1 MB, which is the limit"
    assert not any(str(client.folder).encode() in text for _, text in answers)
    assert [*client.folder.iterdir()] == [current]
    assert (current / "ball.vtp").read_bytes() == before


def test_an_uploaded_target_is_shown_and_saved_with_a_session(client, folder):
    ball = (folder / "ball.vtp").read_bytes()
    assert len(client.session.editor.state) == 27
    for path in ("ball.vtp", "other.vtp", "broken.vtp"):
        content = b"broken" if path == "broken.vtp" else ball
        ((status, _),) = client.ask(("POST", f"/send/target/{path}", content))
        assert status == (400 if path == "broken.vtp" else 200)
    editor = client.session.editor
    assert (editor.target.name, len(editor.state)) == ("other.vtp", 0)
    assert [path.name for path in client.folder.glob("*/*")] == ["other.vtp"]
    client.session.call(lambda: editor.place("moving", (0, 0, 0.5))).result()
    ((status, _),) = client.ask(("POST", "/send/target/ball.vtp", ball))
    assert (status, len(editor.state)) == (200, 1)
    assert client.session.call(editor.save_session).result()
    saved = editor.saver.files[0].parent
    session = session_files.read(saved / "session.mls.json")
    assert session.target == (saved / "ball.vtp").resolve()
    assert session.target.read_bytes() == ball


def test_a_script_for_uploaded_data_has_them_beside_it(client, folder):
    ball = (folder / "ball.vtp").read_bytes()
    assert client.ask(("POST", "/send/data/ball.vtp", ball))[0][0] == 200
    editor = client.session.editor
    editor.saver.copies_data = True
    change = editor.state.moved([0], editor.state.rest[:1] + 0.1)
    client.session.call(lambda: editor.change(change)).result()
    saved = client.save()
    assert (saved / "ball.vtp").read_bytes() == ball
    text = (saved / "deform.py").read_text()
    assert "sent" not in text
    assert repr(("ball.vtp", "ball-deformed.vtp", None)) in text
    content = (saved / "ball-deformed.vtp").read_bytes()
    renamed = folder / "elsewhere"
    saved.rename(renamed)
    assert python(renamed / "deform.py")[0] == 0
    assert (renamed / "ball-deformed.vtp").read_bytes() == content


@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals on Windows")
def test_uploads_are_removed_with_the_server(folder):
    temporary = folder / "temporary"
    temporary.mkdir()
    with server(folder, "ball.vtp", TMPDIR=str(temporary)) as (process, address):
        start, _, token = address.partition("?")
        ball = (folder / "ball.vtp").read_bytes()
        with urlopen(f"{start}send/data/other.vtp?{token}", data=ball) as answer:
            assert answer.read() == b"other.vtp is shown."
        assert [*temporary.rglob("other.vtp")]
        process.terminate()
        process.wait(_TIMEOUT)
    assert [*temporary.glob("vtk-mls-*")] == []


def _has_ipv6():
    try:
        with socket.create_server(("::1", 0), family=socket.AF_INET6):
            return True
    except OSError:
        return False


@pytest.mark.skipif(not _has_ipv6(), reason="this machine has no IPv6")
def test_a_page_is_served_by_ipv6(folder):
    with server(folder, "ball.vtp", "--host", "::1") as (_, address):
        assert address.startswith("http://[::1]:")
        assert urlopen(address).status == 200
        with pytest.raises(HTTPError, match="403"):
            urlopen(address.partition("?")[0])
