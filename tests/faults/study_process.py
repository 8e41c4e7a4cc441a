"""A process that fills the store of a small study, for tests that kill it."""

from __future__ import annotations

import hashlib
import importlib
import os
import subprocess
import sys
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

import remanent as rm
from remanent.studies.sweep import dask_engine
from remanent.studies.sweep.run import run_here, writable_store
from remanent.studies.sweep.sample import sample_on
from remanent.studies.sweep.study import Study

ROOT = Path(__file__).parents[2]


def study(points: int = 5) -> Study:
    """Periodic orbits, in chunks of eight points."""
    return Study(
        "periodic_orbits",
        rm.Actuator(dissipation=rm.Rayleigh(0.1)),
        rm.SineSquared(0.4, 1.25),
        {"b": np.linspace(0.2, 0.9, points), "omega": np.linspace(1.0, 2.0, 16)},
        {"state_box": {"stretch": [0.8, 1.6]}},
    )


def content(path: Path) -> dict[str, str]:
    """A digest of every file of a store but locks."""
    return {
        file.relative_to(path).as_posix(): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in path.rglob("*")
        if file.is_file() and file.suffix != ".lock" and file.name != "identity"
    }


def computed_points(path: Path) -> int:
    """Points of a store that have a status; 0 where there is no store yet."""
    try:
        return int((rm.load(path).status != 0).sum())
    except Exception:  # a store that is being made
        return 0


def start(
    path: Path, environment: Mapping[str, str] = MappingProxyType({}), **settings: Any
) -> subprocess.Popen[str]:
    """A process that fills a store: ``workers=2``, ``part="2/4"``, ``points=24``."""
    words = [f"{name}={value}" for name, value in settings.items()]
    return subprocess.Popen(
        [sys.executable, "-m", "tests.faults.study_process", str(path), *words],
        stderr=subprocess.PIPE,
        text=True,
        env={
            **os.environ,
            **environment,
            "PYTHONPATH": os.pathsep.join([str(ROOT / "src"), str(ROOT)]),
        },
        start_new_session=True,
    )


def main(
    path: Path, points: str = "5", workers: str = "", part: str = "1/1", seconds: str = ""
) -> None:
    """Fill the store at a path; the process ids of workers go to a file beside it."""
    index, count = map(int, part.split("/"))
    with ExitStack() as stack:
        if not workers:
            if "REMANENT_TEST_BAD_POINT" in os.environ:
                importlib.import_module("tests.faults.bad_point")
            store = stack.enter_context(writable_store(path, study(int(points)), (index, count)))
            run_here(store, (index, count))
            return
        client = stack.enter_context(dask_engine.local_workers(int(workers)))
        store = stack.enter_context(
            writable_store(path, study(int(points)), (index, count), sample_on(client))
        )

        def report(_state: object) -> None:
            running = client.cluster.workers.values()
            ids = [worker.process.pid for worker in running if worker.process is not None]
            written = path.with_suffix(".workers.new")
            written.write_text(" ".join(map(str, ids)))
            written.replace(path.with_suffix(".workers"))  # so that it is read whole

        dask_engine.run_on_workers(
            store, client, (index, count), report, float(seconds) if seconds else None
        )


if __name__ == "__main__":
    main(Path(sys.argv[1]), **dict(word.split("=") for word in sys.argv[2:]))
