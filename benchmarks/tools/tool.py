"""What the rows need to know of a tool."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from importlib.util import find_spec

from benchmarks.jobs import Job
from remanent._typing import FloatArray

#: ``run(omegas, setting)`` gives values (trajectory, value).
Run = Callable[[FloatArray, float], FloatArray]

#: Half decades from 1e-5 to 1e-15, loosest first.
TOLERANCES = tuple(10.0 ** (-k / 2) for k in range(10, 31))


@dataclass(frozen=True)
class Tool:
    """A way to do the work.

    Attributes
    ----------
    name, package
        Of the row, and of what is installed.
    gives
        "extremes", the largest and smallest thickness stretch, or "end", the last one.
    settings
        What may be chosen to meet an error, cheapest first: tolerances or resolutions.
    setting_name
        What they are.
    build
        Writes the work for the tool.
    sample
        How many frequencies the slow are timed on; 0 for all.
    compiles
        Whether the first run is slower than the next.
    bound
        Whether an error comes with the values.
    """

    name: str
    package: str
    gives: str
    build: Callable[[Job], Run]
    settings: tuple[float, ...] = TOLERANCES
    setting_name: str = "tolerance"
    sample: int = 0
    compiles: bool = True
    bound: bool = False

    def missing(self) -> str:
        """Why it cannot run here; empty if it can."""
        return "" if find_spec(self.package) else f"{self.package} is not installed"

    def version(self) -> str:
        return version(self.package)

    def omegas(self, job: Job) -> FloatArray:
        """The frequencies it is timed on."""
        return job.omegas[job.subset][self.checked(job)] if self.sample else job.omegas

    def checked(self, job: Job) -> slice:
        """Of the frequencies with a reference, those that its error is measured on."""
        return slice(0, None, job.checked // self.sample) if self.sample else slice(None)
