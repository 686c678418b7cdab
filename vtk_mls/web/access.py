"""Who is let in: whoever has the token, from this page."""

from __future__ import annotations

import secrets
from urllib.parse import urlsplit

from aiohttp import web

_REFUSED = (
    "This page opens only by the whole address that `vtk-mls view --web` has printed, with its "
    "token.\n"
)
_FOREIGN = "Another page may not ask this server.\n"
_HEADERS = {
    "Content-Security-Policy": "frame-ancestors 'none'",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}


def new_token():
    """A token that cannot be guessed."""
    return secrets.token_urlsafe(24)


def middleware(token):
    """An aiohttp middleware that answers nothing without the token, pages or sockets.

    The token is in the address at first, and in a cookie from then on.
    """
    cookie = f"vtk-mls-{secrets.token_hex(4)}"  # cookies know no ports: each server has its own

    @web.middleware
    async def check(request, handler):
        given = request.query.get("token", ""), request.cookies.get(cookie, "")
        if not any(_is_same(each, token) for each in given):
            return web.Response(status=403, text=_REFUSED)
        origin = request.headers.get("Origin")
        if origin and _host_of(origin) != request.host:
            return web.Response(status=403, text=_FOREIGN)
        try:
            response = await handler(request)
        except web.HTTPException as raised:  # redirections are raised
            response = raised
        if not response.prepared:
            response.headers.update(_HEADERS)
            if given[0]:
                response.set_cookie(cookie, token, httponly=True, samesite="Strict", path="/")
        if isinstance(response, web.HTTPException):
            raise response
        return response

    return check


def _is_same(text, token):
    """Whether a text, of whatever bytes, is the token; as slowly if it nearly is."""
    return secrets.compare_digest(text.encode(errors="surrogateescape"), token.encode())


def _host_of(origin):
    """The host and port of an origin; None for what is none."""
    try:
        return urlsplit(origin).netloc
    except ValueError:
        return None
