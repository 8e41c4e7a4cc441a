"""How much is done, and how progress is told."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from benchmarks.jobs import JOBS, Job
from benchmarks.reference import Reference, reference


@dataclass(frozen=True)
class Plan:
    """Sizes of one run of the benchmarks, and where it tells its progress.

    Attributes
    ----------
    quick
        Small sizes, to try the code: the numbers mean little.
    say
        Prints a line.
    """

    quick: bool
    say: Callable[[str], None]

    @property
    def repeats(self) -> int:
        return 2 if self.quick else 5

    def job(self, name: str) -> Job:
        return JOBS[name].small() if self.quick else JOBS[name]

    def truth(self, job: Job) -> Reference:
        """The reference solution, computed once in a run."""
        return _truth(job, self.say)


@cache
def _truth(job: Job, say: Callable[[str], None]) -> Reference:
    say(f"{job.name}: reference solution of {job.checked} motions in extended precision")
    return reference(job)
