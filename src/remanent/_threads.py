"""Threads that stop when the work that they are for is given up, as by Ctrl-C.

Python raises ``KeyboardInterrupt`` in the main thread only.  Work in other threads is told
by an event: :func:`raise_if_stopped`, which every call of a kernel asks first, raises in them.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from contextvars import ContextVar, copy_context
from types import TracebackType
from typing import Any, Self, TypeVar

from remanent._machine import available_processor_count

S = TypeVar("S")
T = TypeVar("T")
#: Longest time for which a thread waits for others at a stretch.
_WAITING_SECONDS = 0.1
#: The events that stop the work of this thread: its pool's, and those of the pools above it.
_STOP_EVENTS: ContextVar[tuple[threading.Event, ...]] = ContextVar("stop_events", default=())


class WorkStopped(BaseException):
    """The work of this thread is no longer wanted; nobody is to see this."""


def raise_if_stopped() -> None:
    """Raise :class:`WorkStopped` where the work of this thread is no longer wanted."""
    if any(event.is_set() for event in _STOP_EVENTS.get()):
        raise WorkStopped


@contextmanager
def work_stopped_after(seconds: float) -> Iterator[None]:
    """Stop the work of the block after a while: calls of kernels then raise :class:`WorkStopped`.

    Parameters
    ----------
    seconds : float
        0 stops it at the first call, when arguments have been checked.
    """
    event = threading.Event()
    timer = threading.Timer(seconds, event.set)
    timer.daemon = True
    token = _STOP_EVENTS.set((*_STOP_EVENTS.get(), event))
    try:
        if seconds > 0.0:
            timer.start()
        else:
            event.set()
        yield
    finally:
        timer.cancel()
        _STOP_EVENTS.reset(token)


class StoppableThreads(ThreadPoolExecutor):
    """A pool of threads that is left at once by an exception; its threads then stop by themselves.

    Parameters
    ----------
    thread_count : int, optional
        As many as this process may use processors by default.
    """

    def __init__(self, thread_count: int | None = None) -> None:
        self.thread_count = thread_count or available_processor_count()
        super().__init__(max_workers=self.thread_count)
        self._stop_event = threading.Event()

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """Start `fn` in a thread where :func:`raise_if_stopped` listens to this pool too."""
        context = copy_context()
        context.run(_STOP_EVENTS.set, (*_STOP_EVENTS.get(), self._stop_event))
        return super().submit(context.run, fn, *args, **kwargs)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        _value: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        if kind is not None:
            self._stop_event.set()
        self.shutdown(wait=kind is None, cancel_futures=kind is not None)


def results_of_all(work: Callable[[S], T], parts: Sequence[S]) -> list[T]:
    """The results of `work` for all parts, by as many threads as there are processors.

    With one processor, or one part, this thread does it.

    Parameters
    ----------
    work : callable
    parts : sequence
    """
    if len(parts) == 1 or available_processor_count() == 1:
        return [work(part) for part in parts]
    with StoppableThreads() as pool:
        futures = [pool.submit(work, part) for part in parts]
        for future in as_finished(futures):
            future.result()  # raises at once what one of them raised
    return [future.result() for future in futures]


def as_finished(futures: Collection[Future[T]]) -> Iterator[Future[T]]:
    """Futures as they end.

    Parameters
    ----------
    futures : collection of Future
    """
    waiting = set(futures)
    while waiting:
        done = first_finished(waiting)
        waiting -= done
        yield from done


def first_finished(futures: Collection[Future[T]]) -> set[Future[T]]:
    """Those of some futures that have ended, as soon as one has; awaited a little at a time.

    Windows delivers Ctrl-C to the main thread between two waits only.

    Parameters
    ----------
    futures : collection of Future
        Not empty.
    """
    done: set[Future[T]] = set()
    while not done:
        done, _ = wait(futures, timeout=_WAITING_SECONDS, return_when=FIRST_COMPLETED)
    return done
