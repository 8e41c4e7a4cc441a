"""Ctrl-C ends every verb within two seconds, and the next call is right.

Law: Stopping.
"""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import pytest

import remanent as rm
from tests.repetitions import fast_and_slow

#: From the signal to the exception, seconds.
LONGEST_WAIT = 2.0
#: Seconds of work before the signal, after which every verb is in the middle of it.
WORK = 1.0
#: Seconds after which a call counts as one that does not stop.
CAP = 60.0
FREE, DRIVE = rm.Actuator(), rm.SineSquared(0.4, 1.25)
DAMPED = FREE.replace(dissipation=rm.Rayleigh(0.1))
GRID = {"stretch": np.linspace(0.5, 2.0, 60), "stretch_rate": np.linspace(-1.0, 1.0, 60)}
MANY = np.linspace(0.1, 1.0, 500)

#: Calls that would take minutes or hours.
LONG_CALLS: dict[str, Callable[[], Any]] = {
    "periodic_orbits": lambda: rm.periodic_orbits(DAMPED, DRIVE, orbit_period=4000),
    "symmetry_check": lambda: rm.symmetry_check(FREE, DRIVE, periods=10**7),
    "basins": lambda: rm.basins(DAMPED, DRIVE, GRID, periods=20_000),
    "classify": lambda: rm.classify(FREE, DRIVE, periods=5000, over={"b": MANY}),
    "simulate": lambda: rm.simulate(FREE, DRIVE, periods=10**5, over={"b": MANY}),
    "poincare_section": lambda: rm.poincare_section(FREE, DRIVE, periods=10**5, over={"b": MANY}),
    "frequency_response": lambda: rm.frequency_response(
        FREE, DRIVE, np.linspace(0.5, 2.0, 200_001), duration=1000
    ),
    "lyapunov": lambda: rm.lyapunov(FREE, DRIVE, periods=10**5, over={"b": MANY}),
    "bifurcation_diagram": lambda: rm.bifurcation_diagram(DAMPED, DRIVE, "b", MANY, discard=10**5),
    "regime_chart": lambda: rm.regime_chart(
        DAMPED, DRIVE, over={"b": MANY, "omega": np.linspace(0.5, 2.0, 60)}, periods=10**4
    ),
    "response_diagram": lambda: rm.response_diagram(
        FREE.replace(dissipation=rm.Rayleigh(0.002)),
        rm.SineSquared(0.8, 1.2),
        (1.8, 4.5),
        orbit_period=3,
        over={"temperature": np.linspace(250.0, 400.0, 40)},
    ),
    "cycle_losses": lambda: rm.cycle_losses(DAMPED, DRIVE, periods=10**5, over={"b": MANY[:50]}),
    "crossings": lambda: rm.crossings(FREE, DRIVE, "thickness_stretch", 1.0, duration=10**6),
    "energy_balance": lambda: rm.energy_balance(
        DAMPED, DRIVE, periods=10**5, over={"b": MANY[:50]}
    ),
    "resonances": lambda: rm.resonances(
        DAMPED, DRIVE, (0.1, 4.0), over={"temperature": np.linspace(250.0, 400.0, 200)}
    ),
    "backbone": lambda: rm.backbone(
        FREE, 0.1, over={"temperature": np.linspace(250.0, 400.0, 20_000)}
    ),
}
#: Those that run in `make test` as well.
FAST = ("periodic_orbits", "symmetry_check", "classify", "simulate")
VERBS = fast_and_slow(list(LONG_CALLS), FAST)


@pytest.fixture
def alarms() -> Iterator[list[float]]:
    """Instants of the interrupts that a timer raises in the main thread, as Ctrl-C does.

    Python swallows one that is raised in a callback of its garbage collector, such as Hypothesis
    leaves behind; there are none meanwhile.
    """
    sent: list[float] = []
    callbacks = gc.callbacks[:]
    gc.callbacks.clear()

    def interrupt(_signal: int, _frame: FrameType | None) -> None:
        sent.append(time.monotonic())
        if len(sent) == 1:
            signal.setitimer(signal.ITIMER_REAL, CAP)
            raise KeyboardInterrupt
        raise TimeoutError("the call did not stop")

    before = signal.signal(signal.SIGALRM, interrupt)
    yield sent
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    signal.signal(signal.SIGALRM, before)
    gc.callbacks.extend(callbacks)


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="timers that signal are POSIX")
@pytest.mark.parametrize("verb", VERBS)
def test_an_interrupt_ends_the_call(verb: str, alarms: list[float]) -> None:
    """Within two seconds; and a call after it gives what it always gives."""
    reference = rm.simulate(DAMPED, DRIVE, periods=3)
    signal.setitimer(signal.ITIMER_REAL, WORK)
    with pytest.raises(KeyboardInterrupt):
        LONG_CALLS[verb]()
    assert time.monotonic() - alarms[0] < LONGEST_WAIT
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    assert rm.simulate(DAMPED, DRIVE, periods=3).identical(reference)


def children(process: int) -> list[int]:
    """Processes that a process started, with theirs."""
    tasks = Path(f"/proc/{process}/task")
    own = [int(k) for t in tasks.glob("*/children") for k in t.read_text().split()]
    return own + [k for child in own for k in children(child)]


def is_alive(process: int) -> bool:
    """Whether a process runs; one that ended and waits to be noticed does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="Linux lists processes there")
@pytest.mark.parametrize(("asked", "code"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_a_command_takes_its_processes_with_it(
    asked: signal.Signals, code: int, tmp_path: Path
) -> None:
    """`remanent paper`, asked to end while several processes work: none stays behind."""
    # A process that is started in the background is born deaf to interrupts.
    code_of_command = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
        "from remanent.cli import main; main()"
    )
    command = [sys.executable, "-c", code_of_command, "paper"]
    with subprocess.Popen([*command, "--out", str(tmp_path)], stderr=subprocess.PIPE) as paper:
        begin = time.monotonic()
        while len(children(paper.pid)) < 3 and time.monotonic() - begin < CAP:
            time.sleep(0.1)
        started = children(paper.pid)
        assert len(started) >= 3
        os.kill(paper.pid, asked)
        assert paper.wait(CAP) == code
        begin = time.monotonic()
        while any(map(is_alive, started)) and time.monotonic() - begin < LONGEST_WAIT:
            time.sleep(0.05)
        assert not [k for k in started if is_alive(k)]
