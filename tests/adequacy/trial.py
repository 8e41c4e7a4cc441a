"""One trial: the tests that run a line, on a copy of the repository with a mutant in it."""

from __future__ import annotations

import enum
import os
import shutil
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from itertools import count
from pathlib import Path
from typing import Final

import pytest

from tests.adequacy.core import PACKAGE, ROOT

#: What is imported once, before the trials part: three seconds for each of them.
_HEAVY: Final = (
    "hypothesis.extra.numpy", "llvmlite.binding", "llvmlite.ir", "mpmath", "numpy", "pandas",
    "pint", "scipy.integrate", "scipy.interpolate", "scipy.linalg", "scipy.optimize",
    "scipy.signal", "scipy.special", "scipy.stats", "sympy", "xarray",
)  # fmt: skip
#: What is no part of a copy.
_NOT_COPIED: Final = shutil.ignore_patterns("__pycache__", ".*", "_build", "paper", "dist")
#: Seconds of the processor beside the tests: imports, collection, derivations, kernels.
_START_SECONDS: Final = 30.0
#: How many times as long as alone the tests may take.
_PATIENCE: Final = 3.0
#: How many times the limit of the processor's seconds may pass on the clock.
_CLOCK_PATIENCE: Final = 8.0
_CHECK_SECONDS: Final = 0.02
_SECONDS_OF_CHANGES: Final = count(1)


class Verdict(enum.StrEnum):
    """What the tests said of a mutant."""

    KILLED = "killed"
    TIMEOUT = "timeout"
    SURVIVED = "survived"
    UNCOVERED = "not covered"

    @property
    def is_kill(self) -> bool:
        """Whether the tests saw the mutant; what never ends, they do not let pass."""
        return self in (Verdict.KILLED, Verdict.TIMEOUT)


def copy_repository(folder: Path) -> Path:
    """A copy in which files can be changed while the repository is worked on."""
    return shutil.copytree(ROOT, folder / "tree", ignore=_NOT_COPIED)


def prepare() -> None:
    """Import what every trial needs and no mutant changes."""
    for name in _HEAVY:
        import_module(name)


@contextmanager
def changed(path: Path, text: str) -> Iterator[None]:
    """A file with another text for a while.

    Python knows by the time and the size of a file whether what it has compiled is still
    right, so every text gets a time of its own.
    """
    before, times = path.read_text("utf-8"), path.stat()
    path.write_text(text, encoding="utf-8")
    seconds = next(_SECONDS_OF_CHANGES)
    os.utime(path, (seconds, seconds))
    try:
        yield
    finally:
        path.write_text(before, encoding="utf-8")
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


@contextmanager
def cache_of_its_own(cache: Path) -> Iterator[Path]:
    """A cache that begins as a copy of `cache` and is thrown away, as a mutant fills it.

    Keys hold a digest of the sources, but a mutant may be in what makes the keys.
    """
    own = cache.with_name(f"{cache.name}-of-mutant")
    shutil.rmtree(own, ignore_errors=True)
    shutil.copytree(cache, own, copy_function=os.link)  # entries are replaced, never changed
    try:
        yield own
    finally:
        shutil.rmtree(own, ignore_errors=True)


def judge(
    copy: Path, cache: Path, file: str, text: str, tests: Sequence[str], seconds: float
) -> Verdict:
    """The verdict of `tests`, which alone take `seconds`, on a file with the text `text`."""
    if not tests:
        return Verdict.UNCOVERED
    limit = _START_SECONDS + _PATIENCE * seconds
    with changed(copy / PACKAGE / file, text), cache_of_its_own(cache) as own:
        status = _in_a_process(lambda: _run_tests(copy, own, tests), limit)
    if status is None or (os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGXCPU):
        return Verdict.TIMEOUT
    passed = os.WIFEXITED(status) and os.WEXITSTATUS(status) == pytest.ExitCode.OK
    return Verdict.SURVIVED if passed else Verdict.KILLED


def _in_a_process(work: Callable[[], int], limit: float) -> int | None:
    """How a process ended that does `work`, or None if it took too long."""
    import resource  # Windows has none, and no processes that part

    child = os.fork()
    if child == 0:
        os.setsid()
        resource.setrlimit(resource.RLIMIT_CPU, (int(limit), int(limit) + 5))
        os._exit(work())
    deadline = time.monotonic() + _CLOCK_PATIENCE * limit
    ended = status = 0
    while not ended and time.monotonic() < deadline:
        time.sleep(_CHECK_SECONDS)
        ended, status = os.waitpid(child, os.WNOHANG)
    with suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)  # and what it has started
    if not ended:
        os.waitpid(child, 0)
    return status if ended else None


def _run_tests(copy: Path, cache: Path, tests: Sequence[str]) -> int:
    with open(os.devnull, "w", encoding="utf-8") as nowhere:
        os.dup2(nowhere.fileno(), 1)
        os.dup2(nowhere.fileno(), 2)
    os.chdir(copy)
    sys.path[:] = [str(copy / "src"), str(copy), *(p for p in sys.path if not _is_ours(p))]
    os.environ["PYTHONPATH"] = os.pathsep.join(sys.path[:2])
    os.environ["REMANENT_CACHE_DIR"] = str(cache)
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    for name in [name for name in sys.modules if name.partition(".")[0] == "tests"]:
        del sys.modules[name]
    options = ["-x", "-q", "--no-header", "-p", "no:cacheprovider"]
    with suppress(BaseException):
        return int(pytest.main([*options, *tests]))
    return 1


def _is_ours(entry: str) -> bool:
    return Path(entry or ".").resolve() in (ROOT, ROOT / "src", ROOT / "tests")
