"""What macOS and Windows have in another way, or not at all: simulated here as far as it can be.

``docs/reference/portability.md`` says what is simulated and what only those systems can show.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import platform
import socket
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import remanent as rm
from remanent import _machine
from remanent.report.processes import work_executor
from remanent.results import atomic
from remanent.studies.sweep import layout
from remanent.studies.sweep.layout import unstorable_names
from remanent.web import listening

#: What only some systems have, taken away before this package is imported.
ONLY_SOMEWHERE = """
import os, signal, sys, time
for module, names in {
    os: "sched_getaffinity sched_setaffinity register_at_fork sysconf nice fork forkpty getloadavg",
    signal: "pthread_sigmask pthread_kill SIGKILL SIGHUP SIGUSR1 SIGALRM setitimer sigwait",
}.items():
    for name in names.split():
        if hasattr(module, name):
            delattr(module, name)
sys.modules["resource"] = None
"""
#: A day's work: a motion, a file, a store that is resumed, a picture.
WORK = """
import numpy as np
import remanent as rm
body, drive, grid = rm.Actuator(), rm.SineSquared(0.4, 1.25), {"temperature": [300.0, 350.0]}
motion = rm.simulate(body, drive, duration=5.0, over=grid, progress=True)
rm.save(motion, "λ.nc")
assert rm.load("λ.nc").identical(motion)
for _ in range(2):
    stored = rm.sweep(body, drive, grid, "simulate", store="store.zarr", times=[0.0, 5.0])
assert (stored.status == rm.Status.OK).all()
"""
STUDY_FILE = """
verb = "simulate"
store = "grid.zarr"
[actuator]
[drive]
kind = "Constant"
m = 0.1
[over]
temperature = [300.0, 350.0]
[options]
times = [0.0, 1.0]
"""


def run(code: str, folder: Path, *options: str, **environment: str) -> str:
    """What a fresh process writes; it must end well."""
    done = subprocess.run(
        [sys.executable, *options, "-c", code], cwd=folder, capture_output=True, check=False,
        env={**os.environ, **environment},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr.decode("utf-8", "replace")
    return done.stdout.decode("utf-8", "replace") + done.stderr.decode("utf-8", "replace")


def command(*words: str) -> str:
    """Code that runs the command with these words."""
    return f"import sys; sys.argv = {['remanent', *words]!r}\nfrom remanent.cli import main; main()"


@pytest.mark.slow
def test_work_goes_on_without_what_only_some_systems_have(tmp_path: Path) -> None:
    """No affinities, no fork, no limits of processes, no masks of signals."""
    run(ONLY_SOMEWHERE + WORK, tmp_path)


@pytest.mark.slow
def test_files_do_not_depend_on_the_locale(tmp_path: Path) -> None:
    """Every file is opened with its encoding named, also where the locale knows ASCII only."""
    strict = "import warnings\nwarnings.filterwarnings('error', '', EncodingWarning, 'remanent')\n"
    plain = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    options = ("-X", "warn_default_encoding")
    run(strict + WORK.replace("λ", "l"), tmp_path, *options, **plain)
    (tmp_path / "study.toml").write_text(f"# λ\n{STUDY_FILE}", encoding="utf-8")
    for words in (
        ("new", "chart"),
        ("run", "study.toml"),
        ("verify", "grid.zarr"),
        ("export", "study.toml", "--to", "python"),
    ):
        run(strict + command(*words), tmp_path, *options, **plain)


@pytest.mark.parametrize("encoding", ["cp1252", "cp850"])
def test_consoles_with_few_letters_show_the_rest_as_question_marks(
    encoding: str, tmp_path: Path
) -> None:
    """The command ends as elsewhere, whatever names and claims hold."""
    done = subprocess.run(
        [sys.executable, "-c", command("new", "λ²τ")], cwd=tmp_path, capture_output=True,
        check=False, env={**os.environ, "PYTHONIOENCODING": encoding},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(b"Wrote ?")
    assert (tmp_path / "λ²τ.toml").is_file()


def simulated(temperature: float) -> float:
    """The last stretch of a motion, in whichever process."""
    body = rm.Actuator(temperature=temperature)
    motion = rm.simulate(body, rm.SineSquared(0.4, 1.25), times=[0.0, 5.0])
    return float(motion["stretch"][-1])


@pytest.mark.slow
def test_processes_that_are_started_afresh_compute_the_same() -> None:
    """As on macOS and Windows: nothing is inherited, all is pickled."""
    temperatures = [300.0, 350.0]
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        there = list(pool.map(simulated, temperatures))
    assert there == [simulated(one) for one in temperatures]


@pytest.mark.slow
def test_the_pool_of_the_paper_needs_no_fork_server(monkeypatch: pytest.MonkeyPatch) -> None:
    """Elsewhere than on Linux its processes are spawned."""
    monkeypatch.setattr(platform, "system", lambda: "Darwin")
    with work_executor(2) as pool:
        assert pool.submit(abs, -3).result() == 3


def test_a_system_without_affinities_counts_its_processors(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """All that there are; one where nobody knows."""
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.delenv(_machine.THREADS_VARIABLE, raising=False)
    for told, counted in ((8, 8), (None, 1)):
        monkeypatch.setattr(os, "cpu_count", lambda told=told: told)
        assert _machine.available_processor_count() == counted


@pytest.mark.parametrize("answers", [1, 0])
def test_windows_tells_its_memory(answers: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """By its own function; what is assumed elsewhere counts where that fails."""

    def fill(reference: Any) -> int:
        status = reference._obj
        assert status.length == ctypes.sizeof(status) == 64
        status.physical = 3 * 2**30
        return answers

    library = SimpleNamespace(kernel32=SimpleNamespace(GlobalMemoryStatusEx=fill))
    monkeypatch.setattr(ctypes, "windll", library, raising=False)
    monkeypatch.delattr(os, "sysconf", raising=False)
    expected = 3 * 2**30 if answers else _machine._ASSUMED_MEMORY_BYTES
    assert _machine._physical_memory_bytes() == expected


def test_a_system_without_limits_of_processes_has_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """The module is missing, or a limit is."""
    monkeypatch.setitem(sys.modules, "resource", SimpleNamespace())
    assert list(_machine._process_limits_bytes()) == []
    monkeypatch.setitem(sys.modules, "resource", None)
    assert list(_machine._process_limits_bytes()) == []


def refusing(times: int, usual: Callable[..., Any]) -> Callable[..., Any]:
    """A function that is refused a few times, as where a file is open elsewhere."""
    left = [times]

    def call(*args: Any) -> Any:
        left[0] -= 1
        if left[0] >= 0:
            raise PermissionError(13, "The process cannot access the file")
        return usual(*args)

    return call


def test_a_file_that_is_being_read_is_replaced_a_moment_later(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Windows refuses meanwhile; on other systems a refusal is one."""
    target = tmp_path / "file"
    monkeypatch.setattr(atomic, "_SECONDS_BETWEEN_TRIES", 0.0)
    for tries, succeeds in ((20, True), (1, False)):
        target.write_text("old", encoding="utf-8")
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(atomic, "_TRIES", tries)
            patch.setattr(Path, "replace", refusing(3, Path.replace))
            try:
                with atomic.atomic_replacement(target) as part:
                    part.write_text("new", encoding="utf-8")
            except PermissionError:
                assert not succeeds
        assert target.read_text(encoding="utf-8") == ("new" if succeeds else "old")
        assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize(
    ("names", "system", "refused"),
    [
        ({"a", "A", "b"}, {"ignores_case": True}, ["A", "a"]),
        ({"a", "A", "b"}, {}, []),
        ({"aux", "con", "com1", "auxiliary"}, {"on_windows": True}, ["aux", "com1", "con"]),
        ({"aux", "con"}, {"ignores_case": True}, []),
        ({"a:b", "end.", "dissipation.0.eta"}, {"on_windows": True}, ["a:b", "end."]),
        ({"zarr.json", ".x", "a/b", "a\\b"}, {}, [".x", "a/b", "a\\b", "zarr.json"]),
    ],
)
def test_names_that_a_system_cannot_have_are_refused(
    names: set[str], system: dict[str, bool], refused: list[str]
) -> None:
    """Before a store is begun, whose folders would be taken for each other."""
    found = unstorable_names(
        names, **{"on_windows": False, "ignores_case": False, **system}
    )  # fmt: skip
    assert found == refused


def test_whether_capitals_count_is_asked_of_the_file_system(tmp_path: Path) -> None:
    """A folder that is not there yet lies where those above it do."""
    (tmp_path / "Lower").mkdir()
    assert layout._ignores_case(tmp_path / "Lower" / "not there") == (tmp_path / "lOWER").exists()


@pytest.mark.slow
def test_letters_that_differ_in_capitals_make_a_store_where_they_can(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A system with `a` and `A` is refused on a file system that takes one for the other."""
    system = rm.LagrangianSystem(
        coordinates=("x",), kinetic="x_rate**2/2", potential="a*x**2/2 + A*x**4",
        parameters={"a": 1.0, "A": 0.1},
    )  # fmt: skip
    grid = {"a": [1.0, 2.0], "A": [0.1]}
    monkeypatch.setattr(layout, "_ignores_case", lambda _: True)
    with pytest.raises(rm.InputError, match="cannot tell it from another"):
        rm.sweep(
            system, rm.Constant(0.0), grid, "simulate", store=tmp_path / "s.zarr",
            times=np.array([0.0, 1.0]),
        )  # fmt: skip


def test_a_port_is_taken_by_one_program_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """On Windows another option says so than elsewhere."""
    monkeypatch.setattr(socket, "SO_EXCLUSIVEADDRUSE", -5, raising=False)
    assert listening._address_option() == -5
    monkeypatch.delattr(socket, "SO_EXCLUSIVEADDRUSE")
    assert listening._address_option() == socket.SO_REUSEADDR
