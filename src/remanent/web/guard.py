"""What stands before every request: who asks, how much, how slowly, and how answers are sent."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Mapping, Sequence
from http.cookies import CookieError, SimpleCookie
from typing import Any, Final
from urllib.parse import parse_qs, urlencode

from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from remanent.web.access import Access
from remanent.web.policy import security_headers

#: Largest body of a request, in bytes.
MAX_BODY_BYTES: Final = 10**6
#: Seconds within which a request has to be there as a whole.
_REQUEST_SECONDS: Final = 10.0
#: Seconds within which a client has to take a piece of an answer.
_ANSWER_SECONDS: Final = 30.0
#: Requests that are answered at once, beside each other.
_MOST_AT_ONCE: Final = 64
_TOO_LARGE: Final = f"A request may have at most {MAX_BODY_BYTES} bytes."
#: Said with a refusal that leaves the rest of a body unread.
_CLOSE: Final = {"connection": "close"}
#: Methods that change nothing.
_READING: Final = frozenset({"GET", "HEAD"})


class Guard:
    """An application behind checks of every request; it counts those under way.

    Parameters
    ----------
    app : ASGIApp
    access : Access
    request_seconds, answer_seconds : float
        Within which a request has to be there, and a piece of an answer to be taken.
    """

    def __init__(
        self,
        app: ASGIApp,
        access: Access,
        *,
        request_seconds: float = _REQUEST_SECONDS,
        answer_seconds: float = _ANSWER_SECONDS,
    ) -> None:
        self._app, self._access = app, access
        self._request_seconds, self._answer_seconds = request_seconds, answer_seconds
        self._headers = security_headers()
        self._under_way = 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or refuse it."""
        if scope["type"] == "websocket":
            await self._guard_socket(scope, receive, send)
        elif scope["type"] == "http":
            await self._guard_request(
                scope, receive, _Answer(send, self._answer_seconds, self._headers)
            )
        else:
            await self._app(scope, receive, send)

    async def _guard_socket(self, scope: Scope, receive: Receive, send: Send) -> None:
        refused = self._refused(scope, wants_origin=True)
        if refused is not None:  # before it is accepted, so that the client sees 403
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": refused[1]})
            return
        await self._app(scope, receive, _Answer(send, self._answer_seconds, self._headers))

    async def _guard_request(self, scope: Scope, receive: Receive, send: _Answer) -> None:
        refused = self._refused(scope, wants_origin=scope["method"] not in _READING)
        if refused is not None:
            await _refuse(send, *refused)
        elif self._access.token and scope["path"] == "/" and _token_of(scope):
            await self._keep_token(scope, send)
        elif _declared_length(scope) > MAX_BODY_BYTES:
            await _refuse(send, 413, _TOO_LARGE)
        elif self._under_way >= _MOST_AT_ONCE:
            await _refuse(send, 429, "Too many requests at once.")
        else:
            self._under_way += 1
            try:
                await self._app(scope, _Body(receive, self._request_seconds), send)
            finally:
                self._under_way -= 1

    def _refused(self, scope: Scope, *, wants_origin: bool) -> tuple[int, str] | None:
        """Status and words where this client is refused."""
        host = _header(scope, b"host")
        if host is None or not self._access.allows_host(host):
            return 403, "This server answers to the names of this machine alone."
        origin = _header(scope, b"origin")
        if origin is None and wants_origin:
            return 403, "A request that asks for work has to name its page, as browsers do."
        if origin is not None and not self._access.allows_origin(origin, host):
            return 403, "Another page asked for this."
        if not self._access.allows_token(_token_of(scope) or self._kept_token(scope)):
            return 403, "Open the address that the terminal shows: it has the token."
        return None

    def _kept_token(self, scope: Scope) -> str:
        """The token in the cookie; empty where there is none."""
        try:
            cookies = SimpleCookie(_header(scope, b"cookie") or "")
        except CookieError:
            return ""
        kept = cookies.get(self._access.cookie)
        return kept.value if kept is not None else ""

    async def _keep_token(self, scope: Scope, send: _Answer) -> None:
        """Put the token of the address in a cookie, and take it out of the address."""
        query = parse_qs(scope["query_string"].decode("latin-1"), keep_blank_values=True)
        query.pop("token")
        place = "/" + (f"?{urlencode(query, doseq=True)}" if query else "")
        cookie = f"{self._access.cookie}={self._access.token}; Path=/; HttpOnly; SameSite=Strict"
        await _send_whole(
            send, 303, b"", {"location": place, "set-cookie": cookie, "cache-control": "no-store"}
        )


class _Body:
    """The body of a request, as far as it is small and comes in time; it counts bytes."""

    def __init__(self, receive: Receive, seconds: float) -> None:
        self._receive = receive
        self._seconds = seconds
        self._bytes = 0
        self._is_whole = False

    async def __call__(self) -> Message:
        """The next piece."""
        if self._is_whole:  # what comes now is the end of the connection, whenever that is
            return await self._receive()
        begin = asyncio.get_running_loop().time()
        try:
            async with asyncio.timeout(max(self._seconds, 0.0)):
                message = await self._receive()
        except TimeoutError:
            raise HTTPException(408, "The request did not arrive in time.", _CLOSE) from None
        self._seconds -= asyncio.get_running_loop().time() - begin
        self._bytes += len(message.get("body", b""))
        self._is_whole = not message.get("more_body", False)
        if self._bytes > MAX_BODY_BYTES:
            raise HTTPException(413, _TOO_LARGE, _CLOSE)
        return message


class _Answer:
    """Sends an answer with the headers of all answers, to a client that takes it in time."""

    def __init__(self, send: Send, seconds: float, headers: Sequence[tuple[bytes, bytes]]) -> None:
        self._send, self._seconds, self._headers = send, seconds, headers

    async def __call__(self, message: Message) -> None:
        """Send a piece."""
        if message["type"] == "http.response.start":
            message = {**message, "headers": [*message.get("headers", []), *self._headers]}
        async with asyncio.timeout(self._seconds):
            await self._send(message)


async def _refuse(send: _Answer, status: int, message: str) -> None:
    """Send a refusal."""
    body = json.dumps({"error": {"status": status, "message": message, "faults": []}}).encode()
    headers = {"content-type": "application/json", "cache-control": "no-store"}
    await _send_whole(send, status, body, headers | (_CLOSE if status == 413 else {}))


async def _send_whole(send: _Answer, status: int, body: bytes, headers: Mapping[str, str]) -> None:
    pairs = {**headers, "content-length": str(len(body))}
    lines = [(name.encode(), value.encode("latin-1")) for name, value in pairs.items()]
    await send({"type": "http.response.start", "status": status, "headers": lines})
    await send({"type": "http.response.body", "body": body})


def _header(scope: Scope, name: bytes) -> str | None:
    """The one value of a header; none where it is missing, or there are several."""
    values: list[Any] = [value for key, value in scope["headers"] if key == name]
    return values[0].decode("latin-1") if len(values) == 1 else None


def _declared_length(scope: Scope) -> int:
    text = _header(scope, b"content-length") or "0"
    return int(text) if text.isascii() and text.isdigit() and len(text) < 20 else 0


def _token_of(scope: Scope) -> str:
    """The token in the address; empty where there is none."""
    return parse_qs(str(scope["query_string"], "latin-1")).get("token", [""])[0]
