"""Access to the page: requests need the token, and come from the page itself."""

import secrets
from urllib.parse import urlsplit

from aiohttp import web

_NO_TOKEN = (
    "This page opens only by the whole address that `vtk-mls view` has printed, with its token.\n"
)
_FOREIGN_PAGE = "Requests of other pages are refused.\n"
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
    """An aiohttp middleware that refuses requests and sockets without the token.

    The token is in the address of the first request, and in a cookie from then on.
    """
    cookie = f"vtk-mls-{secrets.token_hex(4)}"  # cookies do not depend on the port

    @web.middleware
    async def check(request, handler):
        from_address = request.query.get("token", "")
        candidates = from_address, request.cookies.get(cookie, "")
        if not any(_is_same(candidate, token) for candidate in candidates):
            return web.Response(status=403, text=_NO_TOKEN)
        origin = request.headers.get("Origin")
        if origin and _host_of(origin) != request.host:
            return web.Response(status=403, text=_FOREIGN_PAGE)
        try:
            response = await handler(request)
        except web.HTTPException as raised:  # redirections are raised
            response = raised
        if not response.prepared:
            response.headers.update(_HEADERS)
            if from_address:
                response.set_cookie(cookie, token, httponly=True, samesite="Strict", path="/")
        if isinstance(response, web.HTTPException):
            raise response
        return response

    return check


def _is_same(text, token):
    """Whether a text equals the token, compared in constant time."""
    return secrets.compare_digest(text.encode(errors="surrogateescape"), token.encode())


def _host_of(origin):
    """The host and port of an origin; None if it is not valid."""
    try:
        return urlsplit(origin).netloc
    except ValueError:
        return None
