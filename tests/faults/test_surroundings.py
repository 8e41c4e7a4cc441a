"""Limits of memory, users without a home, forked processes, folders that cannot be made.

Law: Stopping.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import remanent as rm

FREE, DRIVE = rm.Actuator(), rm.SineSquared(0.4, 1.25)
MANY = np.linspace(0.1, 1.0, 10_000)
GRID = {"stretch": np.linspace(0.5, 2.0, 60), "stretch_rate": np.linspace(-1.0, 1.0, 60)}

#: Requests that no machine can hold, and the argument that makes them so.
TOO_LARGE: dict[str, tuple[str, Callable[[], Any]]] = {
    "classify": ("periods", lambda: rm.classify(FREE, DRIVE, periods=2**40)),
    "lyapunov": ("periods", lambda: rm.lyapunov(FREE, DRIVE, periods=2**40)),
    "symmetry": ("periods", lambda: rm.symmetry_check(FREE, DRIVE, periods=2**40)),
    "basins": ("periods", lambda: rm.basins(FREE, DRIVE, GRID, periods=2**40)),
    "section": ("periods", lambda: rm.poincare_section(FREE, DRIVE, periods=2**40)),
    "losses": ("periods", lambda: rm.cycle_losses(FREE, DRIVE, periods=2**40)),
    "diagram": ("keep", lambda: rm.bifurcation_diagram(FREE, DRIVE, "b", MANY, keep=2**40)),
    "simulate": ("over", lambda: rm.simulate(FREE, DRIVE, periods=10**7, over={"b": MANY * 1.0,
                 "c": MANY})),
}  # fmt: skip


@pytest.mark.parametrize("case", TOO_LARGE)
def test_what_memory_cannot_hold_is_refused(case: str) -> None:
    """Before anything is allocated, with the argument and the memory that it needs."""
    name, call = TOO_LARGE[case]
    with pytest.raises(rm.InputError, match=rf"`{name}` must ask for results of at most .* GiB"):
        call()


def run_python(code: str, **options: Any) -> str:
    """What a fresh process prints."""
    answer = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True, **options
    )
    return str(answer.stdout).strip()


@pytest.mark.skipif(os.name != "posix", reason="limits of processes are POSIX")
def test_limits_of_the_process_count() -> None:
    """What this machine could hold is refused where the process may not."""
    code = """
import resource, remanent as rm
def labels(count):
    values = [0.1 + k / count for k in range(count)]
    return rm.classify(rm.Actuator(), rm.SineSquared(0.4, 1.25), periods=10**6, over={"b": values})
hard = resource.getrlimit(resource.RLIMIT_AS)[1]
resource.setrlimit(resource.RLIMIT_AS, (4 * 2**30, hard))
try:
    labels(1000)
except rm.InputError as error:
    print(error)
"""
    assert "`periods` must ask for results of at most" in run_python(code)


SIMULATE = """
import remanent as rm
print(float(rm.simulate(rm.Actuator(), rm.SineSquared(0.4, 1.0), duration=1.0).stretch[-1]))
"""


@pytest.mark.parametrize("wrong", [RuntimeError("no home"), KeyError("no such user")])
def test_a_user_without_a_home_has_no_cache(
    wrong: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing is stored or found; nothing fails."""
    from remanent import _cache

    def fail(_name: str) -> Path:
        raise wrong

    monkeypatch.delenv("REMANENT_CACHE_DIR", raising=False)
    monkeypatch.setattr(_cache, "user_cache_path", fail)
    assert _cache.cache_directory() is None
    assert not _cache.store_bytes("kind", "key", b"x")
    assert _cache.load_bytes("kind", "key") is None


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="the table of users is POSIX")
def test_an_unknown_user_without_a_home_computes() -> None:
    """As in a container with ``--user 12345``: no HOME, no entry in the table of users."""
    unknown = """
import os, pwd
def fail(*_):
    raise KeyError("uid not found")
pwd.getpwuid = fail
assert os.path.expanduser("~") == "~"
"""
    kept = {k: v for k, v in os.environ.items() if k not in ("HOME", "REMANENT_CACHE_DIR")}
    kept = {k: v for k, v in kept.items() if not k.startswith("XDG")}
    assert run_python(unknown + SIMULATE, env=kept) == run_python(SIMULATE)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="fork is POSIX")
def test_a_fork_while_a_thread_compiles_can_compile(tmp_path: Path) -> None:
    """The child computes too, whenever in the compilation it is forked."""
    code = """
import os, threading, time
import remanent as rm
rm.simulate, rm.frequency_response  # what is imported in a thread, Python itself cannot fork
rm.simulate(rm.Actuator(), rm.Constant(0.1), duration=1.0)
drive = rm.Sine(0.1, 1.0)
body = rm.Actuator(dissipation=rm.KelvinVoigt(0.1))
work = threading.Thread(target=lambda: rm.simulate(body, drive, duration=1.0))
work.start()
ends = []
while work.is_alive() and len(ends) < 5:
    time.sleep(0.05)
    child = os.fork()
    if child == 0:
        rm.simulate(rm.Actuator(), rm.SineSquared(0.4, 1.0), duration=1.0)
        os._exit(0)
    ends.append(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
work.join()
print(len(ends) > 0 and not any(ends))
"""
    fresh = {**os.environ, "REMANENT_CACHE_DIR": str(tmp_path)}
    assert run_python(code, env=fresh, timeout=120) == "True"


def test_a_report_that_cannot_be_written_is_refused_at_once(tmp_path: Path) -> None:
    """One line, and exit code 1, before any work: no line of progress was drawn."""
    (tmp_path / "file").write_text("")
    command = [sys.executable, "-c", "from remanent.cli import main; main()", "paper"]
    answer = subprocess.run(
        [*command, "--out", str(tmp_path / "file" / "below")],
        check=False,
        capture_output=True,
        text=True,
    )
    assert answer.returncode == 1
    assert "file" in answer.stderr
    assert answer.stdout == ""
