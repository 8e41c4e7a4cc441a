"""Files that only save time: private, checked when read, replaced whole when written.

The directory is ``platformdirs.user_cache_path("remanent")`` or, if set, the
environment variable ``REMANENT_CACHE_DIR``.  A cache that cannot be used, because it
is read-only, damaged, or writable by somebody else, or because the user has no home,
is silently not used.
"""

from __future__ import annotations

import hashlib
import os
import re
import stat
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Final

from platformdirs import user_cache_path

_ENTRY_HEADER: Final = b"remanent-cache-1 "
_ENTRY_NAME_PATTERN: Final = re.compile(r"[A-Za-z0-9_-]{1,128}")


def source_digest(*parts: str) -> str:
    """A digest of some of this package's own source files, to make part of a key.

    Parameters
    ----------
    parts
        Files and folders, relative to the package: ``"_field.py"``, ``"codegen"``.
    """
    digest = hashlib.sha256()
    package = Path(__file__).parent
    for part in parts:
        path = package / part
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            digest.update(file.relative_to(package).as_posix().encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()


def load_bytes(kind: str, key: str) -> bytes | None:
    """What was stored under `key`, or None if nothing is there or it is damaged.

    Parameters
    ----------
    kind, key
        Letters, digits, ``-`` and ``_``: a family of entries, and the entry.
    """
    path = _entry_path(kind, key)
    try:
        if path is None or not _is_private_folder(path.parent):
            return None
        content = path.read_bytes()
    except OSError:
        return None
    header, _, data = content.partition(b"\n")
    return data if header == _header_with_checksum(data) else None


def store_bytes(kind: str, key: str, data: bytes) -> bool:
    """Store `data` under `key`; False where the cache cannot be used.

    The entry appears whole or not at all, also when two processes store it at once.
    """
    path = _entry_path(kind, key)
    if path is None:
        return False
    try:
        path.parent.parent.parent.mkdir(parents=True, exist_ok=True)
        for folder in (path.parent.parent, path.parent):
            folder.mkdir(mode=0o700, exist_ok=True)
        if not _is_private_folder(path.parent):
            return False
        _write_atomically(path, _header_with_checksum(data) + b"\n" + data)
    except OSError:
        return False
    return True


def load_text(kind: str, key: str) -> str | None:
    """Text stored by :func:`store_text`, or None."""
    data = load_bytes(kind, key)
    if data is None:
        return None
    try:
        return data.decode()
    except UnicodeDecodeError:
        return None


def store_text(kind: str, key: str, text: str) -> bool:
    """Store text; see :func:`store_bytes`."""
    return store_bytes(kind, key, text.encode())


def cache_directory() -> Path | None:
    """The directory of the cache, which may not exist; None for a user without a home."""
    chosen = os.environ.get("REMANENT_CACHE_DIR")
    if chosen:
        return Path(chosen)
    try:
        return user_cache_path("remanent")
    except (RuntimeError, KeyError):  # no HOME, and no entry for the user
        return None


def _entry_path(kind: str, key: str) -> Path | None:
    for name in (kind, key):
        if not _ENTRY_NAME_PATTERN.fullmatch(name):
            raise ValueError(f"not a name for a cache entry: {name!r}")
    directory = cache_directory()
    return None if directory is None else directory / kind / key


def _header_with_checksum(data: bytes) -> bytes:
    return _ENTRY_HEADER + hashlib.sha256(data).hexdigest().encode()


def _is_private_folder(folder: Path) -> bool:
    """Whether the folder and its parent, the cache, are ours and only ours to write."""
    return all(_is_writable_only_by_user(part.lstat()) for part in (folder, folder.parent))


def _is_writable_only_by_user(status: os.stat_result) -> bool:
    if not stat.S_ISDIR(status.st_mode):
        return False
    if os.name != "posix":
        return True
    return status.st_uid == os.getuid() and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def _write_atomically(path: Path, content: bytes) -> None:
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=".new-")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        os.replace(temporary, path)
    except BaseException:
        with suppress(OSError):
            os.unlink(temporary)
        raise
