"""Running the server: its protocol and its end."""

from __future__ import annotations

import asyncio
import socket as sockets
from functools import partial
from typing import Any, Final, cast

import uvicorn
from starlette.types import ASGIApp
from uvicorn.protocols.http.h11_impl import H11Protocol

from remanent.web.guard import MAX_BODY_BYTES

#: Seconds within which the first lines of a request have to be there.
_HEADER_SECONDS: Final = 10.0
#: Seconds that answers under way have when the server ends.
_ENDING_SECONDS: Final = 1
#: Seconds between two questions whether a page is still there, and for its answer.
_PING_SECONDS: Final = 20.0


def serve(app: ASGIApp, listener: sockets.socket) -> None:
    """Answer requests until the process is told to end by SIGINT or SIGTERM.

    Parameters
    ----------
    app : ASGIApp
    listener : socket
        It is closed at the end.
    """
    make_server(app).run(sockets=[listener])


def make_server(app: ASGIApp, header_seconds: float = _HEADER_SECONDS) -> uvicorn.Server:
    """A server that is not started yet.

    Parameters
    ----------
    app : ASGIApp
    header_seconds : float
        Seconds within which the first lines of a request have to be there.
    """
    config = uvicorn.Config(
        app,
        http=cast(Any, partial(PatientProtocol, header_seconds=header_seconds)),
        ws="websockets-sansio",
        ws_max_size=MAX_BODY_BYTES,
        ws_ping_interval=_PING_SECONDS,
        ws_ping_timeout=_PING_SECONDS,
        ws_per_message_deflate=False,  # a small frame may hold a large message
        lifespan="on",
        log_config=None,
        log_level="critical",
        access_log=False,
        proxy_headers=False,
        server_header=False,
        timeout_graceful_shutdown=_ENDING_SECONDS,
    )
    return uvicorn.Server(config)


class PatientProtocol(H11Protocol):
    """The protocol of uvicorn, whose patience with the first lines of a request is finite.

    Parameters
    ----------
    header_seconds : float
    **others
        As uvicorn passes them.
    """

    def __init__(self, *, header_seconds: float, **others: Any) -> None:
        super().__init__(**others)
        self._header_seconds = header_seconds
        self._waiting: asyncio.TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        """Begin to wait for a request."""
        super().connection_made(transport)
        self._wait()

    def data_received(self, data: bytes) -> None:
        """Wait on where no request has come of what was sent so far."""
        super().data_received(data)
        if self._is_answering():
            self._stop_waiting()
        elif self._waiting is None:
            self._wait()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait for nothing any more."""
        self._stop_waiting()
        super().connection_lost(exc)

    def _is_answering(self) -> bool:
        upgraded = self.transport.get_protocol() is not self
        return upgraded or (self.cycle is not None and not self.cycle.response_complete)

    def _wait(self) -> None:
        self._waiting = self.loop.call_later(self._header_seconds, self._give_up)

    def _stop_waiting(self) -> None:
        if self._waiting is not None:
            self._waiting.cancel()
            self._waiting = None

    def _give_up(self) -> None:
        self._waiting = None
        if not self._is_answering():
            self.transport.close()
