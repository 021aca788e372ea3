"""Who may talk to the page: this user's browser, and nobody's page on another site.

A server on 127.0.0.1 is reached by every page that the browser shows, by every user of the machine, and, where a name
resolves to 127.0.0.1 (DNS rebinding), as if it were another site. Therefore: the header ``Host`` has to name this
server, ``Origin`` and ``Sec-Fetch-Site`` this page, and a cookie holds a token that only the terminal has shown. The
same origin does not tell users of one machine apart, which is why there is a token.
"""

from __future__ import annotations

import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
Application = Callable[[Scope, Receive, Send], Awaitable[None]]

MEGABYTE = 1_000_000
# Of what surrounds a file in a form; what is sent without a file is smaller, too.
ROOM = 100_000


class Guard:
    """An ASGI application around another: refuses, limits what is uploaded, and says what a page may load.

    Parameters
    ----------
    app : ASGI application
    port : int
        Of the server, which belongs to its origin.
    largest_upload : int
        Bytes.

    Attributes
    ----------
    token : str
        Opens the page, once; a cookie keeps it afterwards.
    files : str
        Path under which results are read. It is as good as a password: a report is shown in a frame that belongs to no
        origin, so that its links bring no cookie.
    """

    def __init__(self, app: Application, port: int, largest_upload: int) -> None:
        self.app, self.port, self.largest_upload = app, port, largest_upload
        self.token = secrets.token_urlsafe(24)
        self.files = f"/files/{secrets.token_urlsafe(24)}/"
        self.hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost")}
        # Browsers keep one jar of cookies for all ports.
        self.cookie = f"camid-studio-{port}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or let the application answer."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        headers = {name.decode("latin-1").lower(): value.decode("latin-1") for name, value in scope["headers"]}
        if (problem := self._foreign(scope, headers)) is not None:
            await _answer(scope, receive, send, 403, problem)
        elif scope["path"] == "/" and self._brings_token(scope):
            cookie = f"{self.cookie}={self.token}; Path=/; HttpOnly; SameSite=Strict"
            await _answer(scope, receive, send, 303, "", {"location": "/", "set-cookie": cookie})
        elif not (self._reads_files(scope) or self._has_cookie(headers)):
            problem = "open the address that camid studio printed: it holds the token"
            await _answer(scope, receive, send, 403, problem)
        elif self._too_large(headers):
            await _answer(scope, receive, send, 413, too_large(self.largest_upload))
        else:
            await self._limited(scope, receive, send)

    def _foreign(self, scope: Scope, headers: dict[str, str]) -> str | None:
        """Why a request comes from elsewhere; None if it does not."""
        host = headers.get("host", "")
        if host not in self.hosts:
            return f"this is not the host {host[:100]!r}: open http://127.0.0.1:{self.port}/"
        if self._reads_files(scope):
            return None
        origin = headers.get("origin")
        if origin is not None and origin not in {f"http://{name}" for name in self.hosts}:
            return f"requests from the origin {origin[:100]!r} are refused"
        # Another port of this host is the same site, and not the same page.
        if headers.get("sec-fetch-site", "none") not in {"none", "same-origin"}:
            return "requests from other pages are refused: open the address that camid studio printed"
        return None

    def _brings_token(self, scope: Scope) -> bool:
        given = parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token", [""])[0]
        return secrets.compare_digest(given.encode(), self.token.encode())

    def _has_cookie(self, headers: dict[str, str]) -> bool:
        try:
            morsel = SimpleCookie(headers.get("cookie", "")).get(self.cookie)
        except CookieError:
            return False
        return morsel is not None and secrets.compare_digest(morsel.value.encode(), self.token.encode())

    def _reads_files(self, scope: Scope) -> bool:
        return (
            scope["type"] == "http" and scope["method"] in {"GET", "HEAD"} and str(scope["path"]).startswith(self.files)
        )

    def _too_large(self, headers: dict[str, str]) -> bool:
        length = headers.get("content-length", "0")
        return not length.isdecimal() or int(length) > self.largest_upload + ROOM

    async def _limited(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let the application answer, count what comes in, and add what a browser has to know."""
        headers = self._policy(scope)
        received, refused, started = 0, False, False

        async def counted() -> MutableMapping[str, Any]:
            nonlocal received, refused
            message = await receive()
            received += len(message.get("body", b"")) if message["type"] == "http.request" else 0
            if received > self.largest_upload + ROOM:
                refused = True
                return {"type": "http.disconnect"}
            return message

        async def guarded(message: MutableMapping[str, Any]) -> None:
            nonlocal started
            if refused and not started:
                return
            if message["type"] == "http.response.start":
                started = True
                message["headers"] = [*message.get("headers", []), *_encoded(headers)]
            await send(message)

        try:
            await self.app(scope, counted, guarded)
        except Exception:
            if not refused:
                raise
        if refused and not started:
            await _answer(scope, receive, send, 413, too_large(self.largest_upload))

    def _policy(self, scope: Scope) -> dict[str, str]:
        """Headers by which the browser itself refuses what no page of ours does."""
        if self._reads_files(scope):
            # A frame without an origin: whatever stands in a report reaches neither the page nor any host.
            policy = (
                "sandbox allow-scripts allow-downloads allow-popups; default-src 'none'; style-src 'unsafe-inline'; "
                "script-src 'unsafe-inline'; img-src 'self' data: blob:; font-src data:; form-action 'none'; "
                "base-uri 'none'; frame-ancestors 'self'"
            )
        else:
            sockets = " ".join(f"ws://{host}" for host in sorted(self.hosts))
            policy = (
                "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; "
                "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:; "
                f"connect-src 'self' {sockets}; object-src 'none'; "
                "form-action 'self'; base-uri 'none'; frame-ancestors 'none'"
            )
        return {
            "content-security-policy": policy,
            "x-content-type-options": "nosniff",
            "referrer-policy": "no-referrer",
            "x-dns-prefetch-control": "off",
        }


def too_large(largest: int) -> str:
    """The line for a file that is larger than ``largest`` bytes."""
    return f"this file is larger than {largest / MEGABYTE:g} MB; start camid studio with a larger --largest-upload"


def _encoded(headers: dict[str, str]) -> list[tuple[bytes, bytes]]:
    return [(name.encode("latin-1"), value.encode("latin-1")) for name, value in headers.items()]


async def _answer(
    scope: Scope, receive: Receive, send: Send, status: int, line: str, headers: dict[str, str] | None = None
) -> None:
    """One line of plain text; a socket is closed before it is open."""
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 1008, "reason": line[:100]})
        return
    body = f"camid studio: {line}\n".encode("utf-8", errors="replace") if line else b""
    sent = {
        "content-type": "text/plain; charset=utf-8",
        "content-length": str(len(body)),
        "x-content-type-options": "nosniff",
        "referrer-policy": "no-referrer",
        "cache-control": "no-store",
        "connection": "close",
        **(headers or {}),
    }
    await send({"type": "http.response.start", "status": status, "headers": _encoded(sent)})
    await send({"type": "http.response.body", "body": body})
