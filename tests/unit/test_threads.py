"""Threads that stop when the work that they are for is given up.

Law: Stopping.
"""

from __future__ import annotations

import concurrent.futures
import threading
import time
from concurrent.futures import Future
from typing import Any

import pytest

from remanent import _threads
from remanent._threads import (
    StoppableThreads,
    WorkStopped,
    as_finished,
    raise_if_stopped,
    results_of_all,
    work_stopped_after,
)

#: A thread that is not stopped gives up after so many seconds.
PATIENCE = 30.0


def work_until_stopped(started: threading.Event) -> None:
    """Ask again and again whether the work is still wanted."""
    started.set()
    begin = time.monotonic()
    while time.monotonic() - begin < PATIENCE:
        raise_if_stopped()
        time.sleep(0.001)


def test_a_pool_left_by_an_exception_stops_its_threads() -> None:
    """The exception comes out, and the work that was under way ended by being stopped."""
    started = threading.Event()
    futures: list[Future[None]] = []

    def work_that_is_interrupted() -> None:
        with StoppableThreads(2) as pool:
            futures.append(pool.submit(work_until_stopped, started))
            futures.extend(pool.submit(work_until_stopped, threading.Event()) for _ in range(4))
            assert started.wait(PATIENCE)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        work_that_is_interrupted()
    future, *waiting = futures
    assert isinstance(future.exception(), WorkStopped)
    assert all(f.cancelled() or isinstance(f.exception(), WorkStopped) for f in waiting)


def test_pools_of_pools_stop_too() -> None:
    """A thread's own pool is stopped with it; one that has nothing to do with it is not."""
    started, told = threading.Event(), threading.Event()
    result: list[Future[None]] = []

    def work_in_a_pool_of_its_own() -> None:
        with StoppableThreads(1) as inner:
            future = inner.submit(work_until_stopped, started)
            result.append(future)
            told.set()
            future.result()

    def work_that_is_interrupted() -> None:
        with StoppableThreads(1) as outer:
            outer.submit(work_in_a_pool_of_its_own)
            assert started.wait(PATIENCE)
            assert told.wait(PATIENCE)
            raise KeyboardInterrupt

    with StoppableThreads(1) as other:
        with pytest.raises(KeyboardInterrupt):
            work_that_is_interrupted()
        assert isinstance(result[0].exception(), WorkStopped)
        assert other.submit(raise_if_stopped).result() is None
    raise_if_stopped()


def test_a_pool_that_is_left_in_peace_finishes() -> None:
    """All results are there, in their order."""
    with StoppableThreads() as pool:
        assert list(pool.map(lambda k: k * k, range(20))) == [k * k for k in range(20)]


@pytest.mark.parametrize("seconds", [0.0, 0.01])
def test_work_is_stopped_after_a_while(seconds: float) -> None:
    """Work of the block is stopped, in pools too; what comes after the block goes on."""
    with pytest.raises(WorkStopped), work_stopped_after(seconds):
        work_until_stopped(threading.Event())
    with (
        pytest.raises(WorkStopped),
        work_stopped_after(seconds),
        StoppableThreads(1) as pool,
    ):
        pool.submit(work_until_stopped, threading.Event()).result()
    raise_if_stopped()
    with work_stopped_after(PATIENCE):
        raise_if_stopped()


def test_work_is_awaited_a_little_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every future comes once, and no wait is without an end: Ctrl-C comes between two of them."""
    limits: list[float | None] = []

    def watched(futures: Any, *, timeout: float | None, return_when: str) -> Any:
        limits.append(timeout)
        return concurrent.futures.wait(futures, timeout=timeout, return_when=return_when)

    def number(k: int) -> int:
        time.sleep(0.02 * k)
        return k

    monkeypatch.setattr(_threads, "wait", watched)
    monkeypatch.setattr(_threads, "_WAITING_SECONDS", 0.01)
    with StoppableThreads(2) as pool:
        futures = [pool.submit(number, k) for k in range(4)]
        ended = [future.result() for future in as_finished(futures)]
    assert sorted(ended) == [0, 1, 2, 3]
    assert len(limits) > 2
    assert set(limits) == {0.01}


@pytest.mark.parametrize("processors", [1, 2, 3])
def test_results_of_all_parts_come_in_their_order(
    processors: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever computes them: one processor takes no second thread."""
    monkeypatch.setattr(_threads, "available_processor_count", lambda: processors)
    threads = set()

    def square(number: int) -> int:
        threads.add(threading.current_thread())
        return number**2

    assert results_of_all(square, range(20)) == [k**2 for k in range(20)]
    assert (threads == {threading.current_thread()}) == (processors == 1)
    assert results_of_all(square, []) == []


def test_an_error_of_one_part_stops_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """What one part raised comes out, while another would have worked for long."""
    monkeypatch.setattr(_threads, "available_processor_count", lambda: 2)
    started = threading.Event()

    def work(part: int) -> None:
        if part:
            work_until_stopped(started)
        assert started.wait(PATIENCE)
        raise ZeroDivisionError

    begin = time.monotonic()
    with pytest.raises(ZeroDivisionError):
        results_of_all(work, [0, 1])
    assert time.monotonic() - begin < PATIENCE
