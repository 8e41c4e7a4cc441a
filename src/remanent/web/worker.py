"""The process behind one job at a time: asked in JSON through a pipe, answering in the same way.

A thread reads what is asked, so that work can be cancelled while it goes on, and so that nothing
is left running where the server itself is gone.
"""

from __future__ import annotations

import json
import os
import queue
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection
from types import FrameType
from typing import Any, Final

#: Least seconds between two reports of progress.
_SECONDS_BETWEEN_REPORTS: Final = 0.1
#: Number of what is done ahead, which no request has.
_AHEAD: Final = -1
#: Seconds between two steps of what is done ahead, in which a request finds the process free.
_PAUSE_SECONDS: Final = 0.3
#: Seconds after which work is broken off that was importing something.
_IMPORT_SECONDS: Final = 0.02
#: By how much the work gives way to the server and the browser.
_NICENESS: Final = 5


def serve_pipe(pipe: Connection, warm_up: bool) -> None:
    """Answer what comes through a pipe until it is closed.

    Parameters
    ----------
    pipe : Connection
        Texts in JSON: ``{"number", "task", "arguments"}``, or ``{"cancel": number}``.  Answers
        have the number, and ``begun``, ``progress``, ``result`` or ``error``; ``bytes`` in place of
        a result announces bytes that follow.
    warm_up : bool
        Whether to compile kernels while nothing is asked, and to give way to other processes.
    """
    inbox = _Inbox(pipe)
    if warm_up:
        with suppress(OSError, AttributeError):
            os.nice(_NICENESS)
    signal.signal(signal.SIGINT, inbox.interrupt)
    if hasattr(signal, "pthread_sigmask"):  # they were held while the process started
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    threading.Thread(target=inbox.listen, daemon=True).start()
    from remanent.web import tasks

    steps = tasks.warm_up_steps() if warm_up else []
    while True:
        request = inbox.next_request(0.0)
        if request is None:
            _take_step(inbox, steps)
            request = inbox.next_request(_PAUSE_SECONDS if steps else None)
        if request is None:
            continue
        if request["task"] == "warm_up":
            steps[:] = tasks.warm_up_steps(request["arguments"])
        else:
            _answer(pipe, inbox, request, tasks.TASKS[request["task"]])


def _take_step(inbox: _Inbox, steps: list[Callable[[], object]]) -> None:
    """Do the first of what is done ahead; where a request breaks it off, it is the last to do."""
    if not steps:
        return
    step = steps.pop(0)
    try:
        try:
            inbox.begin(_AHEAD)
            step()
        finally:
            inbox.end()
    except KeyboardInterrupt:
        steps.append(step)
    except Exception:  # what is done ahead is no answer to anybody; the job itself will tell
        return


class _Inbox:
    """What was asked and is not answered yet; it changes as requests come and are cancelled."""

    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe
        self._requests: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        self._lock = threading.Lock()
        self._running: int | None = None
        self._cancelled: int | None = None

    def listen(self) -> None:
        """Read the pipe until it is closed, then end the process."""
        with suppress(EOFError, OSError):
            while True:
                message = json.loads(self._pipe.recv_bytes())
                if "cancel" in message:
                    self._cancel(message["cancel"])
                else:
                    self._requests.put(message)
                    self._cancel(_AHEAD)
        os._exit(0)  # the server is gone, and so is whoever asked

    def next_request(self, seconds: float | None) -> dict[str, Any] | None:
        """The next request; None where none comes in some seconds, or in any time if None."""
        try:
            return self._requests.get(timeout=seconds)
        except queue.Empty:
            return None

    def begin(self, number: int) -> None:
        """Work on a request begins: an interrupt is for it from now on."""
        with self._lock:
            self._running = number
            if number == _AHEAD:  # what broke it off before does not count again
                self._cancelled = None
        if self._cancelled == number or (number == _AHEAD and not self._requests.empty()):
            raise KeyboardInterrupt

    def end(self) -> None:
        """Work has ended, and no interrupt is for it any more."""
        with self._lock:
            self._running = None

    def interrupt(self, _: int, frame: FrameType | None) -> None:
        """Break off the work that is going on; called in the main thread as SIGINT comes.

        An import is let go on, and broken off soon after: of a package that was left half
        imported no later import is sound.
        """
        if self._running is None or self._running != self._cancelled:
            return
        if is_importing(frame):
            again = threading.Timer(_IMPORT_SECONDS, _interrupt_main_thread)
            again.daemon = True
            again.start()
            return
        raise KeyboardInterrupt

    def _cancel(self, number: int) -> None:
        with self._lock:
            is_running = self._running == number
            if is_running or number != _AHEAD:
                self._cancelled = number
        if not is_running:
            return
        _interrupt_main_thread()


def is_importing(frame: FrameType | None) -> bool:
    """Whether a module is being imported in a frame, or in one that called it."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def _interrupt_main_thread() -> None:
    """Send SIGINT to the main thread, which wakes it from any wait."""
    if hasattr(signal, "pthread_kill"):
        ident = threading.main_thread().ident
        assert ident is not None
        signal.pthread_kill(ident, signal.SIGINT)
    else:
        signal.raise_signal(signal.SIGINT)


def _answer(
    pipe: Connection,
    inbox: _Inbox,
    request: dict[str, Any],
    task: Callable[..., Any],
) -> None:
    """Do what is asked and send the result, or what is wrong."""
    number = request["number"]
    report = _Report(pipe, number)
    result: Any = None
    try:
        try:
            inbox.begin(number)
            pipe.send_bytes(_text(number, {"begun": True}))
            result = task(request["arguments"], report)
        finally:
            inbox.end()
        answer = {"bytes": len(result)} if isinstance(result, bytes) else {"result": result}
        text = _text(number, answer)
    except KeyboardInterrupt:
        text = _text(number, {"error": {"status": 499, "message": "cancelled", "faults": []}})
        result = None
    except Exception as error:
        text = _text(number, {"error": _told(error)})
        result = None
    pipe.send_bytes(text)
    if isinstance(result, bytes):
        pipe.send_bytes(result)


def _text(number: int, answer: dict[str, Any]) -> bytes:
    return json.dumps({"number": number, **answer}, allow_nan=False).encode()


def _told(error: Exception) -> dict[str, Any]:
    """What is sent of an error; a defect is told to the terminal, and in general words here."""
    from remanent.web.errors import UNEXPECTED, refusal_of

    refusal = refusal_of(error)
    if refusal is not None:
        return refusal.answer
    traceback.print_exception(error, file=sys.stderr)
    return {"status": 500, "message": UNEXPECTED, "faults": []}


class _Report:
    """Sends the share that is done, not too often; it remembers when the last one was."""

    def __init__(self, pipe: Connection, number: int) -> None:
        self._pipe, self._number = pipe, number
        self._last = float("-inf")

    def __call__(self, share: float) -> None:
        """Send the share in [0, 1]."""
        now = time.monotonic()
        if now - self._last >= _SECONDS_BETWEEN_REPORTS:
            self._last = now
            self._pipe.send_bytes(_text(self._number, {"progress": min(max(share, 0.0), 1.0)}))
