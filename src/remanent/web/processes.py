"""Processes that work is given to: started ahead, cancelled, killed where they do not listen."""

from __future__ import annotations

import asyncio
import json
import multiprocessing
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from multiprocessing.connection import Connection
from typing import Any, Final, TypeAlias

from remanent.web.errors import RefusalError, busy_refusal, out_of_time_refusal
from remanent.web.worker import serve_pipe

#: Seconds that cancelled work has to stop by itself before its process is killed.
_GRACE_SECONDS: Final = 1.0
#: Seconds that a process may take with what it did ahead, before it begins.
_PREPARING_SECONDS: Final = 60.0
#: What answers hold that are not the last.
_ON_THE_WAY: Final = frozenset({"begun", "progress"})
#: What is said where a process died of its work.
_CRASHED: Final = (
    "The process that computed it ended by itself. Ask for less, or for another point."
)
_TOO_DEEP: Final = "There are too many tables and lists within each other."
#: What is told of the share that is done.
ProgressFunction: TypeAlias = Callable[[float], None]


class Worker:
    """A process, and a thread that hands on what it sends; it ends when it is told to.

    Parameters
    ----------
    warm_up : bool
        Whether it compiles kernels ahead.
    """

    def __init__(self, warm_up: bool) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(
            target=serve_pipe, args=(theirs, warm_up), daemon=True, name="remanent-explore"
        )
        with _interrupts_held():
            self._process.start()
        theirs.close()
        self._number = 0
        self._is_closed = False
        self._loop: asyncio.AbstractEventLoop | None = None
        self._messages: asyncio.Queue[tuple[dict[str, Any], bytes] | None] = asyncio.Queue()

    @property
    def pid(self) -> int:
        """Number of the process."""
        assert self._process.pid is not None
        return self._process.pid

    @property
    def is_alive(self) -> bool:
        """Whether the process runs."""
        return not self._is_closed and self._process.is_alive()

    def listen(self) -> None:
        """Hand messages to the loop that runs now, from here on."""
        self._loop = asyncio.get_running_loop()
        threading.Thread(target=_read, args=(self._pipe, self._hand_on), daemon=True).start()

    def tell(self, task: str, arguments: Any) -> None:
        """Ask for something that has no answer."""
        self._send(_with_number(0, _text_of(task, arguments)))

    async def ask(
        self,
        request: str,
        report: ProgressFunction | None,
        begun: Callable[[], None],
    ) -> Any:
        """The answer to a request; `begun` is called when the process begins with it.

        Raises
        ------
        RefusalError
            What the process refuses, or that it died.
        """
        self._number += 1
        self._send(_with_number(self._number, request))
        while True:
            answer, data = await self._next()
            if answer["number"] != self._number:
                continue
            if "begun" in answer:
                begun()
            elif "progress" in answer:
                if report is not None:
                    report(answer["progress"])
            elif "error" in answer:
                told = answer["error"]
                raise RefusalError(told["status"], told["message"], told["faults"])
            else:
                return data if "bytes" in answer else answer["result"]

    async def stops(self) -> bool:
        """Whether the process breaks off what it does within its time of grace."""
        self._send(json.dumps({"cancel": self._number}))
        with suppress(TimeoutError, RefusalError):
            async with asyncio.timeout(_GRACE_SECONDS):
                while True:
                    answer, _ = await self._next()
                    if answer["number"] == self._number and not answer.keys() & _ON_THE_WAY:
                        return True
        return False

    def kill(self) -> None:
        """End the process at once."""
        self._process.kill()
        self._process.join()
        self._pipe.close()

    def _send(self, text: str) -> None:
        with suppress(OSError):  # a process that died is noticed where its answer is awaited
            self._pipe.send_bytes(text.encode())

    async def _next(self) -> tuple[dict[str, Any], bytes]:
        message = await self._messages.get()
        if message is None:
            self._is_closed = True
            raise RefusalError(422, _CRASHED)
        return message

    def _hand_on(self, message: tuple[dict[str, Any], bytes] | None) -> None:
        assert self._loop is not None
        with suppress(RuntimeError):  # the loop is closed, and nobody listens
            self._loop.call_soon_threadsafe(self._messages.put_nowait, message)


def _text_of(task: str, arguments: Any) -> str:
    """A request as JSON, without its number.

    Raises
    ------
    RefusalError
        Lists within lists, deeper than can be written.
    """
    try:
        return json.dumps({"task": task, "arguments": arguments})
    except RecursionError:
        raise RefusalError(422, _TOO_DEEP) from None


def _with_number(number: int, request: str) -> str:
    return f'{{"number": {number}, {request[1:]}'


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Start processes to which Ctrl-C is not delivered before they can handle it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _read(pipe: Connection, hand_on: Callable[[tuple[dict[str, Any], bytes] | None], None]) -> None:
    """Hand on every message of a pipe, None when it is closed."""
    with suppress(EOFError, OSError):
        while True:
            answer = json.loads(pipe.recv_bytes())
            hand_on((answer, pipe.recv_bytes() if "bytes" in answer else b""))
    hand_on(None)


def _end_in(limit: asyncio.Timeout, seconds: float) -> None:
    """Let some seconds pass from now on."""
    limit.reschedule(asyncio.get_running_loop().time() + seconds)


class WorkerPool:
    """Some processes, each with one piece of work at a time; it starts and ends them.

    Parameters
    ----------
    count : int
        Processes.
    waiting : int
        How many pieces of work may wait for one beside those that are done.
    warm_up : bool
        Whether processes compile kernels ahead.
    """

    def __init__(self, count: int, *, waiting: int = 0, warm_up: bool = False) -> None:
        self.count = count
        self._most = count + waiting
        self._warm_up = warm_up
        self._asked = 0
        self._workers: set[Worker] = set()
        self._idle: asyncio.Queue[Worker] = asyncio.Queue()
        self._stopping: set[asyncio.Task[None]] = set()

    @property
    def is_full(self) -> bool:
        """Whether new work is refused."""
        return self._asked >= self._most

    @property
    def process_numbers(self) -> list[int]:
        """Numbers of the processes."""
        return [worker.pid for worker in self._workers]

    def start_processes(self) -> None:
        """Start the processes, which takes them a while."""
        self._workers = {Worker(self._warm_up) for _ in range(self.count)}

    def listen(self) -> None:
        """Take work from now on, in the loop that runs."""
        for worker in self._workers:
            worker.listen()
            self._idle.put_nowait(worker)

    def warm_up(self, arguments: Any) -> None:
        """Have kernels compiled for other equations, where nothing else is asked."""
        for worker in self._workers:
            worker.tell("warm_up", arguments)

    async def run(
        self,
        task: str,
        arguments: Any,
        *,
        cap: float,
        remedy: str = "Ask for less.",
        report: ProgressFunction | None = None,
    ) -> Any:
        """The result of some work, which is broken off where the caller is cancelled.

        Parameters
        ----------
        task : str
        arguments : plain data
        cap : float
            Seconds that it may take.
        remedy : str
            What to do where it takes longer, a sentence.
        report : callable, optional
            Called with the share that is done.

        Raises
        ------
        RefusalError
            Too much is asked at once, it takes too long, or what the work itself refuses.
        """
        text = _text_of(task, arguments)
        if self.is_full:
            raise busy_refusal()
        self._asked += 1
        try:
            worker = await self._idle.get()
            try:
                async with asyncio.timeout(_PREPARING_SECONDS) as limit:
                    end = partial(_end_in, limit, cap)
                    result = await worker.ask(text, report, end)
            except RefusalError:
                self._give_back(worker)
                raise
            except TimeoutError:
                self._stop(worker)
                raise out_of_time_refusal(cap, remedy) from None
            except BaseException:
                self._stop(worker)
                raise
            self._give_back(worker)
            return result
        finally:
            self._asked -= 1

    def close(self) -> None:
        """Kill all processes."""
        for task in self._stopping:
            task.cancel()
        for worker in self._workers:
            worker.kill()
        self._workers.clear()

    def _give_back(self, worker: Worker) -> None:
        if worker.is_alive:
            self._idle.put_nowait(worker)
        else:
            self._replace(worker)

    def _replace(self, worker: Worker) -> None:
        """Put a new process in the place of one."""
        worker.kill()
        self._workers.discard(worker)
        successor = Worker(self._warm_up)
        self._workers.add(successor)
        successor.listen()
        self._idle.put_nowait(successor)

    def _stop(self, worker: Worker) -> None:
        """Have a process stop what it does, in the background."""

        async def stop() -> None:
            if await worker.stops():
                self._give_back(worker)
            else:
                self._replace(worker)

        task = asyncio.create_task(stop())
        self._stopping.add(task)
        task.add_done_callback(self._stopping.discard)
