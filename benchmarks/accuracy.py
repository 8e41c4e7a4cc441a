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
class Accuracy:
    """Errors of a tool at one setting.

    Attributes
    ----------
    setting
        A tolerance or resolution.
    median, worst
        Error over the checked frequencies that have a value.
    missing
        How many of them have none.
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


def accuracy(tool: Tool, run: Run, job: Job, truth: Reference, setting: float) -> Accuracy:
    """Errors of a tool at one setting."""
    checked = tool.checked(job)
    omegas = job.omegas[job.subset][checked]
    answers = [run(omegas, setting) for _ in range(1 + tool.compiles)]
    error = truth.error(tool.gives, answers[-1].values, checked)
    compiling = max(answers[0].seconds - answers[-1].seconds, 0.0) if tool.compiles else 0.0
    errors = error[~np.isnan(error)]
    missing = error.size - errors.size
    if not errors.size:
        return Accuracy(setting, np.inf, np.inf, missing, compiling)
    return Accuracy(setting, float(np.median(errors)), float(errors.max()), missing, compiling)


def cheapest(tool: Tool, run: Run, job: Job, truth: Reference) -> Accuracy:
    """The cheapest setting within the limit, or the one with the smallest worst error.

    A tool that compiles anew for every setting is charged for one.
    """
    trials = list(_until_met(tool, run, job, truth))
    best = trials[-1] if trials[-1].met else min(trials, key=lambda t: (t.missing, t.worst))
    return replace(best, compiling=max(trial.compiling for trial in trials))


def _until_met(tool: Tool, run: Run, job: Job, truth: Reference) -> Iterator[Accuracy]:
    """Settings from the cheapest on, until one is within the limit."""
    for setting in tool.settings:
        trial = accuracy(tool, run, job, truth, setting)
        yield trial
        if trial.met:
            return
