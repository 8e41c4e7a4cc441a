"""Where slow single-threaded work goes: other processes, or a thread."""

from __future__ import annotations

import platform
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from multiprocessing import active_children, get_context
from types import FrameType
from typing import Final

#: Imported once and shared by all further processes, where the system can do that.
_PRELOADED_MODULES: Final = [
    "remanent.report.drawings",
    "remanent.report.dynamics",
    "remanent.report.tolerance",
]


@contextmanager
def work_executor(processes: int) -> Iterator[Executor]:
    """Somewhere to submit work to; left by an exception, it ends the processes it started.

    Parameters
    ----------
    processes : int
        How many; 1 means a thread of this process.  With more, a script that calls this
        must guard its own start with ``if __name__ == "__main__"``.
    """
    others = set(active_children())
    with _interrupts_held():
        executor = _start_executor(processes)
        # All processes are started now: one that an interrupt met half started would stay behind.
        for _ in range(processes):
            executor.submit(_do_nothing)
    try:
        yield executor
    except BaseException:
        executor.shutdown(wait=False, cancel_futures=True)
        # What was on its way to a process that ends has nobody to take it, and is not waited for.
        on_its_way = getattr(executor, "_call_queue", None)
        if on_its_way is not None:
            on_its_way.cancel_join_thread()
        for process in set(active_children()) - others:
            process.terminate()
        raise
    executor.shutdown()


def _start_executor(processes: int) -> Executor:
    if processes == 1:
        return ThreadPoolExecutor(1)
    if platform.system() == "Linux":
        context = get_context("forkserver")
        context.set_forkserver_preload(_PRELOADED_MODULES)
        return ProcessPoolExecutor(processes, mp_context=context)
    return ProcessPoolExecutor(processes, mp_context=get_context("spawn"))


def _do_nothing() -> None:
    """Have a process started."""


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Ctrl-C and a request to end wait until the block has ended."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[tuple[int, FrameType | None]] = []
    usual = {
        number: signal.signal(number, lambda *one: came.append(one))
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield
    finally:
        for number, handler in usual.items():
            signal.signal(number, handler or signal.SIG_DFL)
        for received, _ in came:
            signal.raise_signal(received)
