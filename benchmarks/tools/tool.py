"""What the rows need to know of a tool."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from importlib.util import find_spec
from typing import Protocol

from benchmarks.jobs import Job
from remanent._typing import FloatArray


@dataclass(frozen=True)
class Answer:
    """Values, array (trajectory, value), and the seconds they took."""

    values: FloatArray
    seconds: float


#: ``run(omegas, setting)``.
Run = Callable[[FloatArray, float], Answer]


def clocked(compute: Callable[[FloatArray, float], FloatArray]) -> Run:
    """Values with the time of the wall clock."""

    def run(omegas: FloatArray, setting: float) -> Answer:
        begin = time.perf_counter()
        values = compute(omegas, setting)
        return Answer(values, time.perf_counter() - begin)

    return run


class Source(Protocol):
    """Where a tool comes from."""

    def missing(self) -> str:
        """Why it cannot run here and how to install it, in one line; empty if it can."""

    def version(self) -> str:
        """Of what is installed."""


#: Installs every peer that is a Python package, from a checkout.
INSTALL_PEERS = "pip install -e '.[bench]' -c constraints.txt"


@dataclass(frozen=True)
class Package:
    """A Python package that the extra ``bench`` of this one names."""

    name: str

    def missing(self) -> str:
        if find_spec(self.name):
            return ""
        return f"{self.name} is not installed; install it with `{INSTALL_PEERS}`"

    def version(self) -> str:
        return version(self.name)


#: Half decades from 1e-5 to 1e-15, loosest first.
TOLERANCES = tuple(10.0 ** (-k / 2) for k in range(10, 31))


@dataclass(frozen=True)
class Tool:
    """A way to do the work.

    Attributes
    ----------
    key, name
        In results; for readers.
    gives
        "extremes", the largest and smallest thickness stretch, or "end", the last one.
    build
        Writes the work for the tool.
    settings
        What may be chosen to meet an error, cheapest first: tolerances or resolutions.
    setting_name
        What they are.
    sample
        How many frequencies the slow are timed on; 0 for all.
    compiles
        Whether the first run is slower than the next.
    """

    key: str
    name: str
    source: Source
    gives: str
    build: Callable[[Job], Run]
    settings: tuple[float, ...] = TOLERANCES
    setting_name: str = "tolerance"
    sample: int = 0
    compiles: bool = True

    def omegas(self, job: Job) -> FloatArray:
        """The frequencies it is timed on."""
        return job.omegas[job.subset][self.checked(job)] if self.sample else job.omegas

    def checked(self, job: Job) -> slice:
        """Of the frequencies with a reference, those that its error is measured on."""
        return slice(0, None, job.checked // self.sample) if self.sample else slice(None)
