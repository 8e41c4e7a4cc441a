"""How a grid is cut: into chunks of the store, and tasks of whole chunks."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import product

from remanent.studies.sweep.grid import Grid, GridPart
from remanent.studies.sweep.study import SEARCHING_VERBS, Study

#: Points in a chunk of the store, at least.
_POINTS_PER_CHUNK = 512
_POINTS_PER_CHUNK_OF_SEARCHES = 8
#: Chunks of a large grid, at least.  Beyond that they are larger, as each is a file for every
#: variable, until one takes about half a second on one core: so many oscillations, or searches.
_MANY_CHUNKS = 32
_OSCILLATIONS_PER_CHUNK = 100_000
_SEARCHES_PER_CHUNK = 32
#: Oscillations of a motion where the study does not say how long it is.
_USUAL_OSCILLATIONS = 200
#: No more chunks than this in a grid.
_MAX_CHUNK_COUNT = 16384
#: No more bytes of one variable than this in a chunk, unless a single point has them.
_MAX_CHUNK_BYTES = 2**24


@dataclass(frozen=True)
class Chunking:
    """A grid in chunks, each of which belongs to one task.

    Attributes
    ----------
    grid : Grid
    shape : tuple of int
        Points of a chunk along each dimension.
    """

    grid: Grid
    shape: tuple[int, ...]

    @cached_property
    def counts(self) -> tuple[int, ...]:
        """Chunks along each dimension."""
        sizes = zip(self.grid.shape, self.shape, strict=True)
        return tuple(math.ceil(size / step) for size, step in sizes)

    @property
    def chunk_count(self) -> int:
        """Chunks of the grid."""
        return math.prod(self.counts)

    @cached_property
    def task_axis(self) -> int:
        """The dimension along which neighbouring chunks make one task."""
        several = [axis for axis, count in enumerate(self.counts) if count > 1]
        return several[-1] if several else 0

    def part_of(self, chunk: tuple[int, ...], chunks: int = 1) -> GridPart:
        """The points of a chunk, or of several along the axis of tasks."""
        return tuple(
            slice(k * step, min((k + (chunks if axis == self.task_axis else 1)) * step, size))
            for axis, (k, step, size) in enumerate(
                zip(chunk, self.shape, self.grid.shape, strict=True)
            )
        )

    def chunks(self) -> Iterator[tuple[int, ...]]:
        """Indices of all chunks, in order."""
        return product(*(range(count) for count in self.counts))

    def chunks_of(self, first: tuple[int, ...], count: int) -> list[tuple[int, ...]]:
        """Indices of the chunks of a task."""
        axis = self.task_axis
        return [(*first[:axis], first[axis] + k, *first[axis + 1 :]) for k in range(count)]

    def is_at_end(self, chunk: tuple[int, ...]) -> bool:
        """Whether no further chunk follows along the axis of tasks."""
        return chunk[self.task_axis] == self.counts[self.task_axis] - 1


def chunking(study: Study, bytes_per_point: int) -> Chunking:
    """The chunks of a study: they depend on the study alone, so that equal studies are equal files.

    Parameters
    ----------
    study : Study
    bytes_per_point : int
        Of the largest variable.
    """
    verb, grid = study.verb, study.grid
    if verb in SEARCHING_VERBS:
        least, most = _POINTS_PER_CHUNK_OF_SEARCHES, _SEARCHES_PER_CHUNK
    else:
        least, most = _POINTS_PER_CHUNK, int(_OSCILLATIONS_PER_CHUNK / _oscillations(study))
    points = max(least, min(grid.point_count // _MANY_CHUNKS, most))
    points = max(points, math.ceil(grid.point_count / _MAX_CHUNK_COUNT))
    points = max(1, min(points, _MAX_CHUNK_BYTES // max(bytes_per_point, 1)))
    shape = [1] * len(grid.shape)
    for axis in range(len(grid.shape) - 1, -1, -1):
        shape[axis] = max(1, min(grid.shape[axis], points // math.prod(shape)))
    return Chunking(grid, grid.shape if study.needs_whole_grid else tuple(shape))


def _oscillations(study: Study) -> float:
    """About how many a motion of a study makes, by how long it is; at least one."""
    for name, share in (("periods", 1.0), ("duration", 1.0 / (2.0 * math.pi))):
        length = study.options.get(name)
        if isinstance(length, int | float):
            return max(share * length, 1.0)
    return _USUAL_OSCILLATIONS
