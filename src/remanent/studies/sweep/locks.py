"""Who may write a store: one process, or one for each part of it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from remanent._errors import RemanentError

#: Beginning of the names of files of locks.
_PREFIX = "run-"
#: Seconds after which a lock that is held is not held by one that only asks.
_ASKING_SECONDS = 1.0


@contextmanager
def sole_writer(folder: Path, part: tuple[int, int]) -> Iterator[None]:
    """Hold the right to write one part of a store, (1, 1) for all of it.

    Parameters
    ----------
    folder : Path
        The store's bookkeeping.
    part : (int, int)
        I of N.

    Raises
    ------
    RemanentError
        Another process writes the same part, or the store in other parts.
    """
    name = f"{_PREFIX}{part[0]}-of-{part[1]}.lock"
    own = FileLock(folder / name)
    try:
        own.acquire(timeout=0)
    except Timeout:
        raise _busy_error(folder, name) from None
    try:
        for other in sorted(folder.glob(f"{_PREFIX}*.lock")):
            in_other_parts = not other.name.endswith(f"-of-{part[1]}.lock")
            if in_other_parts and _is_held(other):
                raise _busy_error(folder, other.name)
        yield
    finally:
        own.release()


def _is_held(file: Path) -> bool:
    lock = FileLock(file)
    try:
        # Another process may be asking the same, for which it holds the lock for a moment.
        lock.acquire(timeout=_ASKING_SECONDS, poll_interval=0.02)
    except Timeout:
        return True
    lock.release()
    return False


def _busy_error(folder: Path, name: str) -> RemanentError:
    part = name.removeprefix(_PREFIX).removesuffix(".lock").replace("-", " ")
    whose = "another run" if part == "1 of 1" else f"a run of part {part}"
    return RemanentError(
        f"The store {folder.parent} is being written by {whose}. "
        "Two runs may not write the same points. Wait for its end, or pass another place."
    )
