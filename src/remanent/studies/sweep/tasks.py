"""One task: the numbers of some whole chunks, computed and written."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from remanent._status import Status
from remanent.results.build import padding_of
from remanent.studies.sweep.attempts import MAX_FAILURES, Attempts, ended_after
from remanent.studies.sweep.grid import GridPart
from remanent.studies.sweep.joining import join_parts
from remanent.studies.sweep.store import Store

#: Reason of points that took their process down.
_FAILED_REASON = f"the process that computed this point ended {MAX_FAILURES} times"
_TIMEOUT_REASON = "the point took longer than the cap that was set"


@dataclass(frozen=True)
class TaskRunner:
    """Computes tasks of a store.

    Attributes
    ----------
    store : Store
    point_seconds : float or None
        The cap on a point; a process that exceeds it is killed, so that it must be a worker.
    """

    store: Store
    point_seconds: float | None = None

    @property
    def attempts(self) -> Attempts:
        """Marks of what was begun."""
        return Attempts(self.store.bookkeeping / "attempts")

    def compute(self, first: tuple[int, ...], count: int) -> int:
        """Compute the chunks of a task that are not there yet, and write them.

        Returns
        -------
        int
            Number of chunks that were computed.
        """
        chunks = self.store.chunking.chunks_of(first, count)
        part = self.store.chunking.part_of(first, count)
        missing = chunks
        if self.store.status_of(part).any():
            missing = [chunk for chunk in chunks if not self.store.computed(chunk)]
        if not missing:
            return 0
        names = [_chunk_name(chunk) for chunk in chunks]
        if len(missing) == count and not any(map(self.attempts.failures, names)):
            with self._mark(names, part):
                self.store.write(part, self.store.study.result_of(part))
            return count
        for chunk in missing:
            self._compute_chunk(chunk)
        return len(missing)

    def _compute_chunk(self, chunk: tuple[int, ...]) -> None:
        """One chunk; by single points where its process ended twice."""
        name, part = _chunk_name(chunk), self.store.chunking.part_of(chunk)
        if self.attempts.failures(name) < MAX_FAILURES - 1:
            with self._mark([name], part):
                self.store.write(part, self.store.study.result_of(part))
            return
        self.store.write(part, self._result_by_points(part))
        self.attempts.clear(name)

    def _result_by_points(self, part: GridPart) -> xr.Dataset:
        """The result of a chunk, each point by itself; points that fail thrice have none."""
        results: list[tuple[GridPart, xr.Dataset]] = []
        lost: list[tuple[GridPart, Status]] = []
        names: list[str] = []
        for point in self._points(part):
            name = f"point-{_name(tuple(s.start for s in point))}"
            names.append(name)
            if self.attempts.failures(name) >= MAX_FAILURES:
                stopped = self.attempts.was_stopped(name)
                lost.append((point, Status.TIMEOUT if stopped else Status.FAILED))
                continue
            with self._mark([name], point):
                results.append((_moved(point, part), self.store.study.result_of(point)))
        whole = _completed(self.store, part, results, [(_moved(p, part), s) for p, s in lost])
        for name in names:
            self.attempts.clear(name)
        return whole

    def _points(self, part: GridPart) -> Iterator[GridPart]:
        """Parts of one point each, or all that belongs together."""
        if self.store.study.needs_whole_grid:
            return iter([part])
        return product(*([slice(k, k + 1) for k in range(s.start, s.stop)] for s in part))

    @contextmanager
    def _mark(self, names: list[str], part: GridPart) -> Iterator[None]:
        """Marks while a part is computed, by a process that is killed where it takes too long."""
        with ExitStack() as stack:
            for name in names:
                stack.enter_context(self.attempts.begun(name))
            if self.point_seconds is not None:
                points = int(np.prod([s.stop - s.start for s in part]))
                seconds = self.point_seconds * points
                stack.enter_context(ended_after(seconds, lambda: self._say_stopped(names)))
            yield

    def _say_stopped(self, names: list[str]) -> None:
        """Leave a word for the process that finds the marks."""
        for name in names:
            self.attempts.mark_as_stopped(name)


def _chunk_name(chunk: tuple[int, ...]) -> str:
    return f"chunk-{_name(chunk)}"


def _name(place: tuple[int, ...]) -> str:
    return "-".join(map(str, place))


def _moved(point: GridPart, part: GridPart) -> GridPart:
    """A part of a grid as one of a part of it."""
    return tuple(
        slice(p.start - whole.start, p.stop - whole.start)
        for p, whole in zip(point, part, strict=True)
    )


def _completed(
    store: Store,
    part: GridPart,
    results: list[tuple[GridPart, xr.Dataset]],
    lost: list[tuple[GridPart, Status]],
) -> xr.Dataset:
    """Results of points joined, with a status and a reason for those that have none."""
    grid = store.study.grid.subset(part)
    if not results:
        results = [(grid.whole, _nothing(store, part))]
    joined = join_parts(grid, results)
    status = joined["status"].values.copy()
    dims = joined["status"].dims
    reason = _reasons(joined, grid.dims)
    for point, meaning in lost:
        slices = dict(zip(grid.dims, point, strict=True))
        status[tuple(slices.get(str(dim), slice(None)) for dim in dims)] = meaning
        text = _TIMEOUT_REASON if meaning is Status.TIMEOUT else _FAILED_REASON
        reason[
            {str(dim): slices[str(dim)] for dim in reason.dims if str(dim) in slices}
        ] = text  # fmt: skip
    return joined.assign(status=(dims, status, joined["status"].attrs), reason=reason)


def _reasons(joined: xr.Dataset, grid_dims: tuple[str, ...]) -> xr.DataArray:
    if "reason" in joined:
        return joined["reason"].astype("<U160")
    dims = [dim for dim in joined["status"].dims if dim in grid_dims]
    shape = [joined.sizes[dim] for dim in dims]
    return xr.DataArray(np.full(shape, "", dtype="<U160"), dims=dims)


def _nothing(store: Store, part: GridPart) -> xr.Dataset:
    """A result without any number, for a part of the grid."""
    sizes = dict(zip(store.grid_dims, (s.stop - s.start for s in part), strict=True))
    variables: dict[str, Any] = {}
    for name in store.names:
        array = store.array(name)
        dims = array.metadata.dimension_names
        if (
            set(dims) & set(sizes)
            and name not in store.grid_dims
            and name not in store.length_names
        ):
            shape = [sizes.get(dim, have) for dim, have in zip(dims, array.shape, strict=True)]
            dtype = np.dtype("U1") if array.dtype.kind in "OT" else array.dtype
            variables[name] = xr.Variable(
                dims, np.full(shape, padding_of(dtype, name), dtype=dtype)
            )
    return xr.Dataset(variables)
