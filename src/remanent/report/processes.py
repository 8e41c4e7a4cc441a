"""Where slow single-threaded work goes: other processes, or a thread."""

from __future__ import annotations

import platform
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from multiprocessing import active_children, get_context
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
    executor = _start_executor(processes)
    try:
        yield executor
    except BaseException:
        executor.shutdown(wait=False, cancel_futures=True)
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
