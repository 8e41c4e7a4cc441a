"""Studies in stores: what tasks, files and workers cost, and how memory grows.

Measured are seconds of the wall clock, each way of running in turn, medians of repeats; and the
peak of resident memory of whole processes.  What two processes gain over one without any study says
how far the machine itself lets two workers go.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

import remanent as rm
from benchmarks.machine import one_core
from benchmarks.rows.growth import peak
from benchmarks.rows.plan import Plan
from remanent.studies.sweep.dask_engine import local_workers

#: Points along each side of the grid that is timed.
_SIDE = 400
#: The same in a quick run.
_QUICK_SIDE = 48
#: Points along each side of the grids by which memory is compared.
_MEMORY_SIDES = (100, 1000)
#: The same in a quick run.
_QUICK_MEMORY_SIDES = (20, 60)
#: Runs of each kind, in turn.
_REPEATS = 3
#: Rows of the grid that one process computes at once without a study.
_ROWS_AT_ONCE = 8
#: Drive periods of every motion.
_PERIODS = 20


def measure(plan: Plan) -> dict[str, Any]:
    """Time of one study run in four ways, and memory of a small and a large one."""
    side = _QUICK_SIDE if plan.quick else _SIDE
    sides = _QUICK_MEMORY_SIDES if plan.quick else _MEMORY_SIDES
    seconds, gain = _seconds(plan, side)
    return {
        "side": side,
        "periods": _PERIODS,
        "repeats": _REPEATS,
        "seconds": seconds,
        "gain_of_two_processes": gain,
        "memory": [_memory(plan, side) for side in sides],
    }


def _seconds(plan: Plan, side: int) -> tuple[dict[str, float], float]:
    """Median seconds by way of running, the workers and kernels being ready.

    With them comes how many times as much two processes do without a study as one.
    """
    with (
        tempfile.TemporaryDirectory() as folder,
        local_workers(1, threads=1) as one,
        local_workers(2, threads=1) as two,
    ):
        stores = (Path(folder) / f"{number}.zarr" for number in count())
        ways: dict[str, Callable[[int], object]] = {
            "the verb": lambda n: _on_one_core(lambda: rm.lyapunov(*_case(), **_options(n))),
            "here": lambda n: _on_one_core(lambda: _sweep(n, next(stores))),
            "one worker": lambda n: _sweep(n, next(stores), one),
            "two workers": lambda n: _sweep(n, next(stores), two),
        }
        times: dict[str, list[float]] = {name: [] for name in ways}
        gains: list[float] = []
        for way in ways.values():
            way(_QUICK_SIDE)
        for repeat in range(_REPEATS):
            plan.say(f"studies: round {repeat + 1} of {_REPEATS}")
            for name, way in ways.items():
                begin = time.perf_counter()
                way(side)
                times[name].append(time.perf_counter() - begin)
            gains.append(_gain_of_two_processes(two, side))
    seconds = {name: statistics.median(each) for name, each in times.items()}
    return seconds, statistics.median(gains)


def _gain_of_two_processes(client: Any, side: int) -> float:
    """How many times as much two processes compute in a time as one of them alone."""

    def seconds(processes: list[str]) -> float:
        begin = time.perf_counter()
        client.gather([
            client.submit(_quarter_of_the_verb, side, workers=[one], pure=False)
            for one in processes
        ])  # fmt: skip
        return time.perf_counter() - begin

    both = sorted(client.scheduler_info(n_workers=-1)["workers"])
    return 2.0 * seconds(both[:1]) / seconds(both)


def _quarter_of_the_verb(side: int) -> None:
    """The verb on every fourth row of the grid, in the parts in which tasks compute it."""
    options = _options(side)
    rows = options["over"]["b"][::4]
    for begin in range(0, len(rows), _ROWS_AT_ONCE):
        part = options["over"] | {"b": rows[begin : begin + _ROWS_AT_ONCE]}
        rm.lyapunov(*_case(), over=part, periods=_PERIODS)


def _on_one_core(work: Callable[[], object]) -> object:
    with one_core():
        return work()


def _case() -> tuple[rm.Actuator, rm.SineSquared]:
    return rm.Actuator(dissipation=rm.Rayleigh(0.1)), rm.SineSquared(0.4, 1.25)


def _options(side: int) -> dict[str, Any]:
    over = {"b": np.linspace(0.2, 0.9, side), "omega": np.linspace(0.8, 1.6, side)}
    return {"over": over, "periods": _PERIODS}


def _sweep(side: int, store: Path, client: Any = None) -> object:
    options = _options(side)
    return rm.sweep(*_case(), options.pop("over"), "lyapunov", store=store, client=client,
                    **options)  # fmt: skip


def _memory(plan: Plan, side: int) -> dict[str, float]:
    """Peak of the resident memory of a process that fills a store, in bytes."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", __spec__.name, str(side), str(Path(folder) / "s.zarr")]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
    plan.say(f"studies: memory of {side} x {side} points")
    return {"points": side**2, "peak": json.loads(done.stdout)}


def main(side: int, path: Path) -> None:
    """Fill a store as the command does, without reading it whole."""
    from remanent.studies.sweep.run import run_here, writable_store
    from remanent.studies.sweep.study import Study

    options = _options(side)
    study = Study("lyapunov", *_case(), options.pop("over"), options)
    with writable_store(path, study) as store:
        run_here(store)
    print(json.dumps(peak()))


if __name__ == "__main__":
    main(int(sys.argv[1]), Path(sys.argv[2]))
