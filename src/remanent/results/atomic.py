"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["atomic_replacement"]

#: Tries to replace a file: Windows refuses while another process reads it, for a moment.
_TRIES = 20 if os.name == "nt" else 1
_SECONDS_BETWEEN_TRIES = 0.05


@contextmanager
def atomic_replacement(path: Path) -> Iterator[Path]:
    """Lend the name of a temporary file, which replaces `path` once it is complete.

    Parameters
    ----------
    path : pathlib.Path
        The file to replace; it stays as it is where the writing fails.

    Yields
    ------
    pathlib.Path
        A name in the same folder, since only there a replacement is one step; it is that of
        this thread alone.
    """
    writer = f"{os.getpid()}-{threading.get_ident()}"
    part = path.with_name(f".{path.name}.{writer}.part")
    try:
        yield part
        _replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def _replace(part: Path, path: Path) -> None:
    for _ in range(_TRIES - 1):
        try:
            part.replace(path)
        except PermissionError:
            time.sleep(_SECONDS_BETWEEN_TRIES)
        else:
            return
    part.replace(path)
