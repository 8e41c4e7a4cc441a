"""Marks of work that was begun, by which a process that died is noticed by the next one.

A point that takes its process down, by a crash or for want of memory, is tried again; so is one
that is stopped for taking too long.  After a death the chunks of a task are tried one by one,
then the points of a chunk, and a point is given up at its third failure.
"""

from __future__ import annotations

import json
import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from remanent.results.atomic import atomic_replacement

#: Failures after which a point is given up.
MAX_FAILURES = 3


@contextmanager
def ended_after(seconds: float, before: Callable[[], None] = lambda: None) -> Iterator[None]:
    """End this process, which must be a worker, where the block takes longer.

    Parameters
    ----------
    seconds : float
    before : callable
        Called right before the end.
    """

    def end() -> None:
        before()
        os.kill(os.getpid(), getattr(signal, "SIGKILL", signal.SIGTERM))

    timer = threading.Timer(seconds, end)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


@dataclass(frozen=True)
class Attempts:
    """Marks in a folder, one for each piece of work that is not finished."""

    folder: Path

    def failures(self, name: str) -> int:
        """How often work of this name was begun and not finished."""
        return int(self._read(name).get("begun", 0))

    def was_stopped(self, name: str) -> bool:
        """Whether it was stopped for taking too long."""
        return bool(self._read(name).get("stopped", False))

    @contextmanager
    def begun(self, name: str) -> Iterator[None]:
        """Mark work as begun, and remove the mark when it ends, also by an exception."""
        self._write(name, begun=self.failures(name) + 1)
        try:
            yield
        finally:
            self.clear(name)

    def mark_as_stopped(self, name: str) -> None:
        """Say that work is stopped for taking too long, right before its process ends."""
        self._write(name, begun=self.failures(name), stopped=True)

    def clear(self, name: str) -> None:
        """Remove the mark."""
        self._file(name).unlink(missing_ok=True)

    def _file(self, name: str) -> Path:
        return self.folder / f"{name}.json"

    def _read(self, name: str) -> dict[str, int]:
        try:
            content = json.loads(self._file(name).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}
        return content if isinstance(content, dict) else {}

    def _write(self, name: str, **content: int) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        with atomic_replacement(self._file(name)) as file:
            file.write_text(json.dumps(content), encoding="utf-8")
