"""Where slow single-threaded work goes: other processes, or a thread."""

from __future__ import annotations

import platform
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from typing import Final

#: Imported once and shared by all further processes, where the system can do that.
_PRELOADED: Final = [
    "remanent.report.drawings",
    "remanent.report.dynamics",
    "remanent.report.tolerance",
]


def pool(processes: int) -> Executor:
    """Somewhere to submit work to.

    Parameters
    ----------
    processes : int
        How many; 1 means a thread of this process.  With more, a script that calls this
        must guard its own start with ``if __name__ == "__main__"``.
    """
    if processes == 1:
        return ThreadPoolExecutor(1)
    if platform.system() == "Linux":
        context = get_context("forkserver")
        context.set_forkserver_preload(_PRELOADED)
        return ProcessPoolExecutor(processes, mp_context=context)
    return ProcessPoolExecutor(processes, mp_context=get_context("spawn"))
