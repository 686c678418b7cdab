"""Access to the page for all kinds of requests, and messages of its socket."""

from __future__ import annotations

import asyncio
import json

import pytest
from test_session import ball_mesh, do, opened

pytest.importorskip("trame", reason="the extra web is not installed")
aiohttp = pytest.importorskip("aiohttp")
TOKEN = "right-token"


def _statuses(*requests):
    """The status of the answer to each (path, headers) of a server behind the middleware."""
    from aiohttp import web
    from aiohttp.test_utils import TestServer

    from vtk_mls.web import access

    async def hello(request):
        return web.Response(text="hello")

    async def ask():
        application = web.Application(middlewares=[access.middleware(TOKEN)])
        application.add_routes([web.get("/", hello)])
        async with TestServer(application) as server:
            return [await _raw_status(server, *request) for request in requests]

    return asyncio.run(ask())


async def _raw_status(server, path, headers):
    """The status of a request with a path and headers of bytes."""
    reader, writer = await asyncio.open_connection("127.0.0.1", server.port)
    host = b"127.0.0.1:%d" % server.port
    lines = [b"GET %s HTTP/1.1" % path, b"Host: " + host, b"Connection: close"]
    lines += [line.replace(b"HOST", host) for line in headers]
    writer.write(b"\r\n".join([*lines, b"", b""]))
    answer = await reader.read()
    writer.close()
    return int(answer.split()[1])


def test_requests_need_the_token_and_come_from_the_page():
    right = b"/?token=" + TOKEN.encode()
    allowed = [(right, []), (right, [b"Origin: http://HOST"])]
    refused = [
        (b"/", []),
        (b"/?token=", []),
        (b"/?token=right-toke", []),
        (right + b"n", []),
        (b"/?token=%ed%a0%80", []),
        (b"/?token=%ff", []),
        (b"/", [b"Cookie: a=\xff\xfe; vtk-mls-1=\xed\xa0\x80"]),
        (b"/", [b"Cookie: " + b"=;" * 500]),
    ]
    hosts = b"http://[", b"http://127.0.0.1:1", b"http://HOST.evil.example", b"http://evil.example"
    refused += [(right, [b"Origin: " + origin]) for origin in (b"null", *hosts, b"\xff")]
    assert _statuses(*allowed) == [200] * len(allowed)
    assert _statuses(*refused) == [403] * len(refused)


VALUES = [None, [], {}, "", "x", 1e400, float("nan"), -1, 10**400, [1], [0, 1], [[0]], {"a": 1}]
NAMES = ["position", "select", "preset", "step", "cut", "alpha"]
NAMES += ["smoothing", "kind", "say", "no such", ["x"]]


@pytest.mark.parametrize("name", NAMES, ids=str)
def test_edits_with_invalid_values_do_not_fail(name):
    session = opened(ball_mesh())
    for value in VALUES:
        do(session, name, value)
    assert len(do(session, "lay_lattice")["rows"]) == 64


TEXTS = [
    *("", "{", "[]", "1", "null", '"type"', '{"type": []}', '{"type": "move"}', "[" * 4000),
    *('{"type": "down", "button": 9, "x": 0, "y": 0}', '{"type": "key", "key": 3}'),
    *('{"type": "move", "x": NaN, "y": 1}', '{"type": "move", "x": 1e300, "y": 1}'),
    *('{"type": "wheel", "steps": "many"}', '{"type": "size", "w": NaN, "h": -1}'),
    *('{"type": "key", "key": "\\ud800"}', '{"type": "key", "key": ""}', '{"type": "size"}'),
    json.dumps({"type": "key", "key": "x" * 3000}),
]


def test_the_socket_survives_invalid_messages(capfd):
    from aiohttp import web
    from aiohttp.test_utils import TestClient, TestServer

    from vtk_mls.web.picture import Picture

    session = opened(ball_mesh())
    picture = Picture(session)

    async def talk():
        application = web.Application()
        application.add_routes([web.get("/picture", picture.connect)])
        server = TestServer(application)
        async with TestClient(server) as client, client.ws_connect("/picture") as socket:
            for text in TEXTS:
                await socket.send_str(text)
            await socket.send_str('{"type": "key", "key": "l"}')
            until = asyncio.get_running_loop().time() + 60
            while len(session.editor.state) == 27:
                assert asyncio.get_running_loop().time() < until
                await asyncio.sleep(0.05)
            assert not socket.closed

    asyncio.run(talk())
    assert len(session.editor.state) == 64
    assert "Traceback" not in capfd.readouterr().err
