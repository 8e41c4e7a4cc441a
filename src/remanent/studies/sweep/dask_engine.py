"""Running a study on workers of Dask, here or on a cluster that writes to one file system."""

from __future__ import annotations

import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from remanent._errors import InputError, RemanentError, error_sentence
from remanent._extras import require_extra
from remanent._machine import (
    THREADS_VARIABLE,
    available_processor_count,
    keep_large_arrays_apart,
)
from remanent.studies.sweep.run import (
    Meter,
    ReportProgress,
    Task,
    chunks_of_share,
    next_size,
    next_task,
)
from remanent.studies.sweep.store import Store, open_store, require_same
from remanent.studies.sweep.tasks import TaskRunner

#: Tasks that are given out for each worker: one that runs and one that waits.
_TASKS_PER_WORKER: Final = 2
#: How often Dask itself tries a task whose worker died; after that it is given out anew.
_TRIES_BY_DASK: Final = 10
#: How often a task is given out anew before the run is given up.
_MAX_TRIES: Final = 10
#: After how long without a word a worker of this machine counts as lost, and how often lost
#: workers are replaced.  A worker that died is back much sooner, unless the machine is busy.
_LOST_AFTER_SECONDS: Final = 60.0
_REPLACED_EVERY_SECONDS: Final = 5.0


@contextmanager
def local_workers(count: int, threads: int | None = None) -> Iterator[Any]:
    """A client of `count` processes of this machine, which share its processors.

    Parameters
    ----------
    count : int
    threads : int, optional
        Of each process, by which it computes one task; by default all processors are used.

    Raises
    ------
    InputError
        More workers than processors.
    """
    require_extra("cluster", "a run on several workers")
    import dask
    from distributed import Client, LocalCluster

    processors = available_processor_count()
    if not 1 <= count <= processors:
        raise InputError(
            "workers",
            must=f"be from 1 to {processors}",
            got=count,
            why="Each worker needs a processor of its own.",
            fix="Leave it out for this process alone.",
        )
    settings = {
        "distributed.scheduler.allowed-failures": _TRIES_BY_DASK,
        "distributed.deploy.lost-worker-timeout": f"{_LOST_AFTER_SECONDS}s",
        "distributed.worker.memory.target": False,
        "distributed.worker.memory.spill": False,
        # Looking at what runs, and giving memory back at once, take a tenth of the time each;
        # looking at oneself many times a second keeps tasks from the interpreter.
        "distributed.worker.profile.enabled": False,
        "distributed.worker.memory.monitor-interval": "1s",
        "distributed.admin.tick.interval": "1s",
        "distributed.admin.system-monitor.interval": "5s",
        "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": None,
    }
    environment = {THREADS_VARIABLE: str(threads or max(1, processors // count))}
    with (
        dask.config.set(settings),
        LocalCluster(
            n_workers=count, threads_per_worker=1, env=environment,
            host="127.0.0.1", dashboard_address="127.0.0.1:0", silence_logs=50,
        ) as cluster,
        _lost_workers_replaced(cluster, count),
        Client(cluster) as client,
    ):  # fmt: skip
        yield client


@contextmanager
def _lost_workers_replaced(cluster: Any, count: int) -> Iterator[None]:
    """Keep the number of workers: Dask drops one that it lost, and starts none in its place."""
    from tornado.ioloop import PeriodicCallback

    async def start() -> None:
        callback.start()

    async def stop() -> None:
        callback.stop()

    callback = PeriodicCallback(lambda: cluster.scale(count), _REPLACED_EVERY_SECONDS * 1e3)
    cluster.sync(start)
    try:
        yield
    finally:
        cluster.sync(stop)


def worker_count(client: Any) -> int:
    """How many workers a client has now."""
    return len(client.scheduler_info(n_workers=-1)["workers"])


def run_on_workers(
    store: Store,
    client: Any,
    part: tuple[int, int] = (1, 1),
    report: ReportProgress | None = None,
    point_seconds: float | None = None,
) -> None:
    """Compute on the workers of a client what is missing of a share of a store.

    Parameters
    ----------
    store : Store
        As :func:`~remanent.studies.sweep.run.writable_store` lends it.
    client : distributed.Client
        Its workers must see the store under the same path.
    part : (int, int)
        I of N.
    report : callable, optional
        Told after each task.
    point_seconds : float, optional
        Cap on a point.

    Raises
    ------
    RemanentError
        A task failed in a way that trying again does not mend.
    """
    from distributed import as_completed

    meter = Meter(store, chunks_of_share(store, part), report)
    queue = _Queue(store, meter.missing)
    run, path = uuid.uuid4().hex, str(store.path.resolve())
    running: dict[Any, tuple[Task, int]] = {}

    def submit(task: Task, tries: int) -> Any:
        future = client.submit(
            compute_task, run, path, task.first, task.count, point_seconds, pure=False
        )
        running[future] = (task, tries)
        return future

    def wanted() -> int:
        return _TASKS_PER_WORKER * max(1, worker_count(client))

    first = [submit(task, 1) for task in queue.take(wanted(), wanted())]
    completed = as_completed(first, loop=client.loop)
    try:
        for future in completed:
            task, tries = running.pop(future)
            if future.status == "finished":
                meter.add(store.chunking.chunks_of(task.first, task.count))
                queue.learn(task, future.result())
            else:
                _require_worker_death(future, task, tries)
                completed.add(submit(task, tries + 1))
                continue
            for further in queue.take(wanted() - len(running), wanted()):
                completed.add(submit(further, 1))
    finally:
        client.cancel(list(running))


class _Queue:
    """Missing chunks in tasks, whose size follows how long the last ones took."""

    def __init__(self, store: Store, missing: list[tuple[int, ...]]) -> None:
        self._store, self._missing, self._position, self._size = store, missing, 0, 1

    def take(self, count: int, shares: int) -> Iterator[Task]:
        """The next tasks, smaller at the end, so that no worker is left with much alone.

        None is larger than one of so many `shares` of what is left.
        """
        for _ in range(count):
            left = len(self._missing) - self._position
            if not left:
                return
            size = max(1, min(self._size, left // shares))
            task = next_task(self._store, self._missing, self._position, size)
            self._position += task.count
            yield task

    def learn(self, task: Task, seconds: float) -> None:
        """A task took so long."""
        self._size = next_size(task.count, seconds)


#: The store that this process works on, by the run that it is for: a worker opens it once.
_opened: dict[str, Store] = {}


def compute_task(
    run: str, path: str, first: tuple[int, ...], count: int, point_seconds: float | None = None
) -> float:
    """Compute one task of the store at a path, in the process of a worker; the seconds it took.

    The name of the run tells the store from one that was at the same path before.
    """
    store = _opened.get(run)
    if store is None:
        _opened.clear()
        keep_large_arrays_apart()
        store = open_store(Path(path))
        require_same(store, store.study)
        if point_seconds is not None:
            # The cap is on computing: what has to be compiled is compiled before.
            store.study.result_of(store.sampled_part)
        _opened[run] = store
    begin = time.perf_counter()
    TaskRunner(store, point_seconds).compute(tuple(first), count)
    return time.perf_counter() - begin


def _require_worker_death(future: Any, task: Task, tries: int) -> None:
    """Raise unless a task ended with its worker, and may be tried again."""
    from distributed.scheduler import KilledWorker

    error = future.exception()
    if isinstance(error, KilledWorker) and tries < _MAX_TRIES:
        return
    raise RemanentError(
        f"Points from {task.first} on were given up: {error_sentence(error)} "
        "Run the study in one process to see why."
    ) from error


@contextmanager
def client_of(address: str) -> Iterator[Any]:
    """A client of a running scheduler.

    Raises
    ------
    InputError
        None answers at this address.
    """
    require_extra("cluster", "a run on a scheduler")
    from distributed import Client

    try:
        client = Client(address, timeout="10s", set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(
            "scheduler",
            must="be the address of a running dask scheduler",
            got=address,
            why=f"None answered: {str(error) or 'no reply'}.",
            fix='Start one by `dask scheduler`, and pass its address, such as "tcp://host:8786".',
        ) from error
    with client:
        yield client
