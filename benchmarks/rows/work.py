"""Frequency responses at equal achieved worst-case error, on one core.

Measured is the time of the wall clock per trajectory and unit of dimensionless time, in
microseconds, the median of repeats in which tools take turns.  Every tool is at its cheapest
setting whose worst error of the thickness stretch, over the frequencies with a reference
solution, is at most 1e-8.
"""

from __future__ import annotations

import statistics
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any

from benchmarks.accuracy import LIMIT, Accuracy, cheapest
from benchmarks.jobs import Job
from benchmarks.machine import one_core
from benchmarks.reference import Reference
from benchmarks.rows.plan import Plan
from benchmarks.tools import (
    diffrax_vmap,
    heyoka_batch,
    octave_ode45,
    ours,
    pynamicalsys_rk45,
    scipy_dop853,
)
from benchmarks.tools.tool import Run, Tool

#: Tools for every job.  The verb is first, so that the derivation of the field, which it shares
#: with the other, is in its time of compiling.
FAST = (ours.VERB, ours.FIXED, heyoka_batch.END, heyoka_batch.EXTREMES)
#: Tools for the response only.
SLOW = (
    diffrax_vmap.TOOL,
    scipy_dop853.TOGETHER,
    scipy_dop853.TOOL,
    pynamicalsys_rk45.TOOL,
    octave_ode45.TOOL,
)


@dataclass(frozen=True)
class _Ready:
    """A tool at the setting that it is timed with."""

    tool: Tool
    run: Run
    at: Accuracy


def measure(plan: Plan, name: str) -> dict[str, Any]:
    """All tools on one job; the slow ones on the response only."""
    job = plan.job(name)
    tools = (*FAST, *SLOW) if name == "response" else FAST
    with one_core():
        truth = plan.truth(job)
        ready = [_prepared(plan, tool, job, truth) for tool in tools if _present(plan, tool)]
        ready.extend(_steps_alone(ready))
        times = _times(plan, job, ready)
    return {
        "job": asdict(job),
        "limit": LIMIT,
        "unresolved": int((~truth.resolved).sum()),
        "repeats": plan.repeats,
        "tools": {entry.tool.key: _row(job, entry, times[entry.tool.key]) for entry in ready},
    }


def _present(plan: Plan, tool: Tool) -> bool:
    reason = tool.source.missing()
    if reason:
        plan.say(f"{tool.name}: left out, {reason}")
    return not reason


def _prepared(plan: Plan, tool: Tool, job: Job, truth: Reference) -> _Ready:
    run = tool.build(job)
    at = cheapest(tool, run, job, truth)
    plan.say(
        f"{job.name}: {tool.name}: {tool.setting_name} {at.setting:g}, "
        f"errors {at.median:.1e} and {at.worst:.1e}, {at.missing} missing"
    )
    return _Ready(tool, run, at)


def _steps_alone(ready: list[_Ready]) -> Iterator[_Ready]:
    """heyoka.py's motion without events, at the tolerance that its extremes need.

    What it would take if turns were found for nothing: the most favourable to it.
    """
    by_key = {entry.tool.key: entry for entry in ready}
    end, extremes = (by_key.get(tool.key) for tool in (heyoka_batch.END, heyoka_batch.EXTREMES))
    if end and extremes:
        name = "heyoka.py, batch, extremes at no cost"
        yield _Ready(replace(end.tool, key="heyoka-steps", name=name), end.run, extremes.at)


def _times(plan: Plan, job: Job, ready: list[_Ready]) -> dict[str, list[float]]:
    """Seconds of every repeat.  Tools take turns, so that all see the same machine."""
    times: dict[str, list[float]] = {entry.tool.key: [] for entry in ready}
    for repeat in range(plan.repeats):
        plan.say(f"{job.name}: timing, round {repeat + 1} of {plan.repeats}")
        for entry in ready:
            answer = entry.run(entry.tool.omegas(job), entry.at.setting)
            times[entry.tool.key].append(answer.seconds)
    return times


def _row(job: Job, entry: _Ready, seconds: list[float]) -> dict[str, Any]:
    count = entry.tool.omegas(job).size
    microseconds = 1e6 / count / job.window
    return {
        "name": entry.tool.name,
        "version": entry.tool.source.version(),
        "gives": entry.tool.gives,
        "setting_name": entry.tool.setting_name,
        "timed_on": count,
        "checked_on": job.checked if not entry.tool.sample else entry.tool.sample,
        "microseconds": statistics.median(seconds) * microseconds,
        "fastest": min(seconds) * microseconds,
        "slowest": max(seconds) * microseconds,
        "met": entry.at.met,
        **asdict(entry.at),
    }
