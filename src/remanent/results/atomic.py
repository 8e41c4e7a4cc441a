"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["replaced_whole"]


@contextmanager
def replaced_whole(path: Path) -> Iterator[Path]:
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
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
