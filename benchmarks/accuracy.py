"""The cheapest setting with which a tool's worst error stays within a limit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.jobs import Job
from benchmarks.reference import Reference
from benchmarks.tools.tool import Run, Tool

#: The worst error that every tool is brought to.
LIMIT = 1e-8


@dataclass(frozen=True)
class Achieved:
    """What one setting of a tool gives.

    Attributes
    ----------
    setting
        A tolerance or resolution.
    median, worst
        Error over the checked frequencies that have a value.
    missing
        How many have none.
    compiling
        Seconds that the first run took more than the second.
    """

    setting: float
    median: float
    worst: float
    missing: int
    compiling: float

    @property
    def met(self) -> bool:
        """Whether every error is within the limit."""
        return self.worst <= LIMIT and not self.missing


def achieved(tool: Tool, run: Run, job: Job, truth: Reference, setting: float) -> Achieved:
    """Errors of a tool at one setting."""
    checked = tool.checked(job)
    omegas = job.omegas[job.subset][checked]
    answers = [run(omegas, setting) for _ in range(1 + tool.compiles)]
    error = truth.error(tool.gives, answers[-1].values, checked)
    compiling = max(answers[0].seconds - answers[-1].seconds, 0.0) if tool.compiles else 0.0
    known = error[~np.isnan(error)]
    median, worst = (
        (float(np.median(known)), float(known.max())) if known.size else (np.inf, np.inf)
    )
    return Achieved(setting, median, worst, error.size - known.size, compiling)


def settled(tool: Tool, run: Run, job: Job, truth: Reference) -> Achieved:
    """The cheapest setting within the limit, or the one with the smallest worst error.

    A tool that compiles anew for every setting is charged for one.
    """
    tried = list(_until_met(tool, run, job, truth))
    best = tried[-1] if tried[-1].met else min(tried, key=lambda one: (one.missing, one.worst))
    return replace(best, compiling=max(one.compiling for one in tried))


def _until_met(tool: Tool, run: Run, job: Job, truth: Reference) -> Iterator[Achieved]:
    for setting in tool.settings:
        found = achieved(tool, run, job, truth, setting)
        yield found
        if found.met:
            return
