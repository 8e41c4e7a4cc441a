"""Jobs through a WebSocket: asked, told how far they are, cancelled, answered."""

from __future__ import annotations

import asyncio
import json
import traceback
from contextlib import suppress
from typing import Any, Final

from fastapi import WebSocket, WebSocketDisconnect
from pydantic import ValidationError

from remanent.web.bodies import CancelMessage, JobMessage
from remanent.web.errors import UNEXPECTED, RefusalError
from remanent.web.explorer import Explorer
from remanent.web.limits import JOB_LIMITS

#: Pages that may be open at once.
_MOST_SOCKETS: Final = 32
#: Messages that wait for a slow client before reports of progress are left out.
_MANY_WAITING: Final = 16
#: Seconds that a client has to take a message.
_SEND_SECONDS: Final = 30.0
#: Codes with which a socket is closed: too many of them, and no text in JSON.
_TRY_AGAIN_LATER, _UNSUPPORTED_DATA = 1013, 1003


async def serve_jobs(socket: WebSocket, explorer: Explorer) -> None:
    """Answer a page until it goes; what is computed for it is broken off then.

    Parameters
    ----------
    socket : WebSocket
    explorer : Explorer
    """
    await socket.accept()
    if explorer.socket_count >= _MOST_SOCKETS:
        await socket.close(_TRY_AGAIN_LATER, "Too many pages are open.")
        return
    explorer.socket_count += 1
    try:
        await _Session(socket, explorer).run()
    finally:
        explorer.socket_count -= 1


class _Session:
    """The jobs of one page; it changes as they come and go."""

    def __init__(self, socket: WebSocket, explorer: Explorer) -> None:
        self._socket, self._explorer = socket, explorer
        self._jobs: dict[str, asyncio.Task[None]] = {}
        self._outbox: asyncio.Queue[dict[str, Any]] = asyncio.Queue()

    async def run(self) -> None:
        """Read and write until the page goes."""
        sending = asyncio.create_task(self._send_all())
        reading = asyncio.create_task(self._read_all())
        try:
            await asyncio.wait((sending, reading), return_when=asyncio.FIRST_COMPLETED)
        finally:
            tasks = [sending, reading, *self._jobs.values()]
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def _send_all(self) -> None:
        with suppress(WebSocketDisconnect, RuntimeError, TimeoutError):
            while True:
                text = json.dumps(await self._outbox.get(), allow_nan=False)
                async with asyncio.timeout(_SEND_SECONDS):
                    await self._socket.send_text(text)

    async def _read_all(self) -> None:
        with suppress(WebSocketDisconnect, RuntimeError):
            while True:
                message = await self._socket.receive()
                if message["type"] == "websocket.disconnect":
                    return
                text = message.get("text")
                if text is None:
                    await self._socket.close(_UNSUPPORTED_DATA, "Messages are text.")
                    return
                self._take(text)

    def _take(self, text: str) -> None:
        """Do what a message asks."""
        try:
            content = json.loads(text)
        except (ValueError, RecursionError):
            self._refuse("", RefusalError(400, "The message is no JSON."))
            return
        number = _id_of(content)
        try:
            if isinstance(content, dict) and content.get("type") == "cancel":
                self._cancel(CancelMessage.model_validate(content).id)
            else:
                self._begin(JobMessage.model_validate(content))
        except ValidationError as error:
            self._refuse(number, _refusal_of_message(error))
        except RefusalError as error:
            self._refuse(number, error)

    def _begin(self, asked: JobMessage) -> None:
        if asked.id in self._jobs:
            raise RefusalError(
                409, "A job with this id goes on already. Cancel it, or choose another id."
            )
        if asked.job not in JOB_LIMITS:
            names = ", ".join(JOB_LIMITS)
            raise RefusalError(422, f"There is no such job. The jobs are {names}.")
        task = asyncio.create_task(self._compute(asked))
        self._jobs[asked.id] = task
        task.add_done_callback(lambda _: self._jobs.pop(asked.id, None))

    def _cancel(self, number: str) -> None:
        task = self._jobs.get(number)
        if task is not None:
            task.cancel()

    async def _compute(self, asked: JobMessage) -> None:
        limit = JOB_LIMITS[asked.job]

        def report(share: float) -> None:
            if self._outbox.qsize() < _MANY_WAITING:
                self._tell(asked.id, "progress", {"share": share, "text": _percent(share)})

        try:
            result = await self._explorer.compute(
                "job", asked.model_dump(include={"job", "spec", "options"}),
                cap=limit.seconds, remedy=limit.remedy, report=report,
            )  # fmt: skip
        except RefusalError as error:
            self._refuse(asked.id, error)
        except asyncio.CancelledError:
            self._refuse(asked.id, RefusalError(499, "It was cancelled."))
            raise
        except Exception as error:  # a defect, which is told to the terminal
            traceback.print_exception(error)
            self._refuse(asked.id, RefusalError(500, UNEXPECTED))
        else:
            self._tell(asked.id, "result", {"result": result})

    def _refuse(self, number: str, error: RefusalError) -> None:
        self._tell(number, "error", {"error": error.answer})

    def _tell(self, number: str, kind: str, content: dict[str, Any]) -> None:
        self._outbox.put_nowait({"id": number, "type": kind, **content})


def _id_of(content: Any) -> str:
    """The id of a message that may not be sound; empty where it has none."""
    number = content.get("id") if isinstance(content, dict) else None
    return number[:64] if isinstance(number, str) else ""


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %"


def _refusal_of_message(error: ValidationError) -> RefusalError:
    """What is wrong with a message that is not of the form that was asked for."""
    texts = [
        f"{'.'.join(map(str, one['loc']))[:200]}: {one['msg']}"
        for one in error.errors(include_url=False, include_input=False)
    ]
    return RefusalError(422, "\n".join(texts))
