"""The cheapest setting with which a tool's worst error stays within a limit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

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
        Error over the checked frequencies.
    compiling
        Seconds that the first run took more than the second.
    """

    setting: float
    median: float
    worst: float
    compiling: float


def achieved(tool: Tool, run: Run, job: Job, truth: Reference, setting: float) -> Achieved:
    """Errors of a tool at one setting."""
    checked = tool.checked(job)
    omegas = job.omegas[job.subset][checked]
    answers = [run(omegas, setting) for _ in range(1 + tool.compiles)]
    error = truth.error(tool.gives, answers[-1].values, checked)
    compiling = max(answers[0].seconds - answers[-1].seconds, 0.0) if tool.compiles else 0.0
    return Achieved(setting, float(np.median(error)), float(error.max()), compiling)


def settled(tool: Tool, run: Run, job: Job, truth: Reference) -> Achieved:
    """The cheapest setting within the limit, or the one with the smallest worst error.

    A tool that compiles anew for every setting is charged for one.
    """
    tried = list(_until_met(tool, run, job, truth))
    best = tried[-1] if tried[-1].worst <= LIMIT else min(tried, key=lambda one: one.worst)
    compiling = max(one.compiling for one in tried)
    return Achieved(best.setting, best.median, best.worst, compiling)


def _until_met(tool: Tool, run: Run, job: Job, truth: Reference) -> Iterator[Achieved]:
    for setting in tool.settings:
        found = achieved(tool, run, job, truth, setting)
        yield found
        if found.worst <= LIMIT:
            return
