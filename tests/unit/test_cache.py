"""The cache saves time or does nothing; it never gives back what was not stored."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from remanent import _cache

needs_posix = pytest.mark.skipif(os.name != "posix", reason="ownership and modes are POSIX")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    chosen = tmp_path / "deep" / "cache"
    monkeypatch.setenv("REMANENT_CACHE_DIR", str(chosen))
    return chosen


def entry(folder: Path) -> Path:
    (path,) = (path for path in folder.rglob("*") if path.is_file())
    return path


@pytest.mark.parametrize("data", [b"", b"\n", b"a\nb\n", bytes(range(256))])
def test_what_is_stored_is_loaded(data: bytes) -> None:
    """The same bytes come back, under their own kind and key only."""
    assert _cache.load_bytes("kind", "key") is None
    assert _cache.store_bytes("kind", "key", data)
    assert _cache.load_bytes("kind", "key") == data
    assert _cache.load_bytes("other", "key") is None


def test_text_survives() -> None:
    """Text comes back with its letters and ends of lines; what is no text is not loaded."""
    assert _cache.store_text("kind", "key", "λ₃\r\n")
    assert _cache.load_text("kind", "key") == "λ₃\r\n"
    assert _cache.load_text("kind", "none") is None
    _cache.store_bytes("kind", "key", b"\xff")
    assert _cache.load_text("kind", "key") is None


def test_the_last_to_store_wins() -> None:
    """A second entry of the same key replaces the first."""
    _cache.store_text("kind", "key", "first")
    _cache.store_text("kind", "key", "second")
    assert _cache.load_text("kind", "key") == "second"


def test_every_flipped_bit_and_every_truncation_is_noticed(folder: Path) -> None:
    """A damaged entry is never loaded, wherever the damage is."""
    _cache.store_bytes("kind", "key", b"data")
    path = entry(folder)
    content = path.read_bytes()
    for position in range(8 * len(content)):
        damaged = bytearray(content)
        damaged[position // 8] ^= 1 << position % 8
        path.write_bytes(damaged)
        assert _cache.load_bytes("kind", "key") is None
    for length in range(len(content)):
        path.write_bytes(content[:length])
        assert _cache.load_bytes("kind", "key") is None


def test_damage_is_repaired_by_storing_again(folder: Path) -> None:
    """A damaged entry can be replaced."""
    _cache.store_bytes("kind", "key", b"some data")
    entry(folder).write_bytes(b"")
    assert _cache.store_bytes("kind", "key", b"some data")
    assert _cache.load_bytes("kind", "key") == b"some data"


@pytest.mark.parametrize("name", ["", "..", "a/b", "a\\b", ".hidden", "a" * 129, "ä", "a\n"])
def test_names_cannot_leave_the_folder(name: str) -> None:
    """A name that could reach outside of the cache is refused."""
    with pytest.raises(ValueError, match="not a name for a cache entry"):
        _cache.load_bytes("kind", name)
    with pytest.raises(ValueError, match="not a name for a cache entry"):
        _cache.store_bytes(name, "key", b"")


@needs_posix
def test_the_folder_is_private(folder: Path) -> None:
    """Folders and entries can be read by their owner only."""
    _cache.store_bytes("kind", "key", b"some data")
    for path in (folder, folder / "kind"):
        assert path.stat().st_mode & 0o777 == 0o700
    assert entry(folder).stat().st_mode & 0o777 == 0o600


@needs_posix
@pytest.mark.parametrize("mode", [0o770, 0o702])
@pytest.mark.parametrize("part", ["", "kind"])
def test_a_folder_that_others_can_write_is_not_used(folder: Path, mode: int, part: str) -> None:
    """What others may have written is neither loaded nor added to."""
    _cache.store_bytes("kind", "key", b"some data")
    (folder / part).chmod(mode)
    assert _cache.load_bytes("kind", "key") is None
    assert not _cache.store_bytes("kind", "key", b"new data")
    (folder / part).chmod(0o700)
    assert _cache.load_bytes("kind", "key") == b"some data"


@needs_posix
def test_a_folder_of_somebody_else_is_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder of another owner is neither loaded from nor added to."""
    _cache.store_bytes("kind", "key", b"some data")
    stranger = os.getuid() + 1
    monkeypatch.setattr(os, "getuid", lambda: stranger)
    assert _cache.load_bytes("kind", "key") is None
    assert not _cache.store_bytes("kind", "key", b"new data")


@needs_posix
def test_a_link_is_not_used(folder: Path, tmp_path: Path) -> None:
    """A symbolic link in place of a folder is not followed."""
    (tmp_path / "elsewhere").mkdir(mode=0o700)
    folder.mkdir(mode=0o700, parents=True)
    (folder / "kind").symlink_to(tmp_path / "elsewhere")
    assert not _cache.store_bytes("kind", "key", b"some data")
    assert not list((tmp_path / "elsewhere").iterdir())


def test_a_cache_that_cannot_be_written_is_silently_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without a usable folder nothing is stored, nothing is loaded, and nothing is raised."""
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("REMANENT_CACHE_DIR", str(tmp_path / "file" / "cache"))
    assert not _cache.store_bytes("kind", "key", b"some data")
    assert _cache.load_bytes("kind", "key") is None


def test_a_full_disk_leaves_the_old_entry(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An entry that cannot be replaced stays whole, and leaves no scraps."""
    _cache.store_bytes("kind", "key", b"old data")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    assert not _cache.store_bytes("kind", "key", b"new data")
    assert _cache.load_bytes("kind", "key") == b"old data"
    assert len(list((folder / "kind").iterdir())) == 1


def test_processes_that_store_at_once_leave_a_whole_entry() -> None:
    """An entry is that of one process or of the other, never a mixture."""
    script = (
        "import sys; from remanent import _cache\n"
        "data = sys.argv[1].encode() * 100_000\n"
        "for _ in range(100):\n"
        "    assert _cache.store_bytes('kind', 'key', data)\n"
        "    assert set(_cache.load_bytes('kind', 'key')) in ({97}, {98})"
    )
    processes = [subprocess.Popen([sys.executable, "-c", script, letter]) for letter in "ab"]
    assert [process.wait(timeout=60) for process in processes] == [0, 0]
    assert _cache.load_bytes("kind", "key") in (b"a" * 100_000, b"b" * 100_000)
