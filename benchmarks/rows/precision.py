"""Work against precision: error and time of several tools over their settings.

Measured is the fastest of a few runs on one core, in microseconds per trajectory and unit of
dimensionless time, against the worst and the median error of the thickness stretch.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from benchmarks.accuracy import accuracy
from benchmarks.jobs import Job
from benchmarks.machine import one_core
from benchmarks.reference import Reference
from benchmarks.rows.plan import Plan
from benchmarks.tools import heyoka_batch, ours, scipy_dop853
from benchmarks.tools.tool import Tool

#: Tools whose curves are drawn.
TOOLS = (ours.FIXED, ours.VERB, heyoka_batch.END, scipy_dop853.TOOL)
#: Loosest tolerance of a curve.
_LOOSEST = 1e-5
#: Tightest tolerance of a curve, and the error with which it ends.
_TIGHTEST = 1e-12
#: Worst error above which a setting is left out, since it tells nothing.
_LARGEST_ERROR = 1.0
#: Microseconds per trajectory and tau with which a curve ends, so that nobody waits for more.
_LONGEST_TIME = 30.0
#: A curve ends after so many settings none of which halves the error: rounding is all that is
#: left.
_SETTINGS_WITHOUT_GAIN = 4
#: Runs of a setting, of which the fastest counts; slow tools, timed on a sample, run once.
_REPEATS = 3


def measure(plan: Plan, name: str) -> dict[str, Any]:
    """Curves of one job."""
    job = plan.job(name)
    with one_core():
        truth = plan.truth(job)
        curves = {
            tool.key: {"name": tool.name, "gives": tool.gives, "points": points}
            for tool in TOOLS
            if not tool.source.missing() and (points := _points(plan, tool, job, truth))
        }
    return {"job": asdict(job), "curves": curves}


def _points(plan: Plan, tool: Tool, job: Job, truth: Reference) -> list[dict[str, float]]:
    """Error and time at each setting, the loosest first."""
    run = tool.build(job)
    omegas = tool.omegas(job)
    repeats = 1 if tool.sample else _REPEATS
    points = []
    for setting in _settings(plan, tool):
        at = accuracy(tool, run, job, truth, setting)
        if at.worst > _LARGEST_ERROR:
            continue
        seconds = min(run(omegas, setting).seconds for _ in range(repeats))
        microseconds = seconds / omegas.size / job.window * 1e6
        plan.say(
            f"{job.name}: {tool.name}, {setting:g}: {at.worst:.1e}, {at.missing} missing, "
            f"{microseconds:.3g} µs"
        )
        points.append({**asdict(at), "microseconds": microseconds})
        before = points[:-_SETTINGS_WITHOUT_GAIN]
        lately = points[-_SETTINGS_WITHOUT_GAIN:]
        if before and 2.0 * min(p["worst"] for p in lately) > min(p["worst"] for p in before):
            break
        if at.worst < _TIGHTEST or (microseconds > _LONGEST_TIME and not tool.sample):
            break
    return points


def _settings(plan: Plan, tool: Tool) -> list[float]:
    """Decades of a tolerance; every second resolution."""
    if tool.setting_name != "tolerance":
        return list(tool.settings[:: 4 if plan.quick else 2])
    decades = [s for s in tool.settings[::2] if _TIGHTEST * 0.9 < s < _LOOSEST * 1.1]
    return decades[:: 3 if plan.quick else 1]
