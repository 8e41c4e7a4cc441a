"""What is asked of the engine, and whether the results give it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

#: Results by row.
Results = dict[str, dict[str, Any]]
#: Our tool at one resolution, without a bound.
_FIXED = "remanent-fixed"
#: Our tool through the public verb.
_VERB = "remanent"
#: heyoka.py with the end only, or with extremes as if they cost nothing: the faster counts.
_HEYOKA = ("heyoka", "heyoka-steps")


@dataclass(frozen=True)
class Target:
    """One line of what is asked.

    Attributes
    ----------
    row
        Name of the row whose results it is judged by.
    work, against
        In words.
    value
        The number that counts, from the data of the row; None where it was not measured.
    least, aim
        What has to be reached, and what to reach later.
    unit
        Written after numbers.
    larger
        Whether more is better.
    """

    row: str
    work: str
    against: str
    value: Callable[[Any], float | None]
    least: float
    aim: float | None
    unit: str = "×"
    larger: bool = True

    def met(self, value: float, limit: float) -> bool:
        return value >= limit if self.larger else value <= limit


@dataclass(frozen=True)
class Verdict:
    """A target and what was measured."""

    target: Target
    value: float | None

    @property
    def text(self) -> str:
        """``aim``, ``yes``, ``no`` or ``not measured``."""
        t = self.target
        if self.value is None:
            return "not measured"
        if t.aim is not None and t.met(self.value, t.aim):
            return "aim"
        return "yes" if t.met(self.value, t.least) else "no"


def verdicts(results: Results) -> Iterator[Verdict]:
    """Judge every target by the rows at hand."""
    for target in TARGETS:
        result = results.get(target.row)
        yield Verdict(target, None if result is None else target.value(result["data"]))


def _faster(ours: str, *peers: str) -> Callable[[Any], float | None]:
    """Time of the fastest peer over that of ours; None unless ours is as exact as asked."""

    def value(data: Any) -> float | None:
        tools = data["tools"]
        theirs = [tools[peer]["microseconds"] for peer in peers if peer in tools]
        tool = tools.get(ours)
        if not tool or not tool["met"] or not theirs:
            return None
        return float(min(theirs) / tool["microseconds"])

    return value


def _faster_than(peer: str, ours: str) -> Callable[[Any], float | None]:
    """Time of the fastest form of a peer over that of ours."""

    def value(data: Any) -> float | None:
        return _faster(ours, *(name for name in data["tools"] if name.startswith(peer)))(data)

    return value


def _seconds(numerator: str, denominator: str) -> Callable[[Any], float | None]:
    """Ratio of the times of two processes; None where one of them was left out."""

    def value(data: Any) -> float | None:
        seconds = data["seconds"]
        if numerator not in seconds or denominator not in seconds:
            return None
        return float(seconds[numerator] / seconds[denominator])

    return value


def _cold(data: Any) -> float | None:
    """Seconds that an empty cache of kernels adds to the first figure."""
    return float(data["seconds"]["first figure, cold"] - data["seconds"]["first figure"])


def _linear(data: Any) -> float | None:
    """Growth of time over growth of the number of trajectories, in the last step."""
    before, last = data["rows"][-2:]
    trajectories = last["trajectories"] / before["trajectories"]
    return float(last["seconds"] / before["seconds"] / trajectories)


def _flat(data: Any) -> float | None:
    """Bytes beside the result that every further trajectory of the last step costs."""
    before, last = data["rows"][-2:]
    bytes_more = last["beyond"] - before["beyond"]
    return float(bytes_more / (last["trajectories"] - before["trajectories"]))


def _share(data: Any) -> float | None:
    """Share of the multiply-add slots that the kernel of frequency responses fills, percent."""
    return 100.0 * float(data["kernels"]["extremes and bound"]["share"])


def _points(name: str) -> Callable[[Any], float | None]:
    """Time of a point of AUTO's over that of ours; None without AUTO."""
    return lambda data: data["auto"] and float(data["auto"] / data[name]["microseconds"])


def _excess(way: str) -> Callable[[Any], float | None]:
    """How much longer a study takes than its verb on one core, percent."""
    return lambda data: 100.0 * float(data["seconds"][way] / data["seconds"]["the verb"] - 1.0)


def _two_workers(data: Any) -> float | None:
    """Time of one worker over that of two."""
    return float(data["seconds"]["one worker"] / data["seconds"]["two workers"])


def _more_memory(data: Any) -> float | None:
    """Growth of the peak of memory from the small grid to the large one, percent."""
    small, large = data["memory"]
    return 100.0 * float(large["peak"] / small["peak"] - 1.0)


def _exponents(data: Any) -> float | None:
    """Time of pynamicalsys over ours, per trajectory and unit of tau; None without it."""
    return data["peer"] and float(data["peer"]["microseconds"] / data["microseconds"])


_RESPONSE = "frequency response, one resolution, no bound"
#: Everything that is asked, in the order of the page.
TARGETS = (
    Target("response", _RESPONSE, "heyoka.py, per core", _faster(_FIXED, *_HEYOKA), 2.5, 10),
    Target("response", "the same with its error", "the same", _faster(_VERB, *_HEYOKA), 1.5, 5),
    Target("film", "the same, a film, c = 0.01", "the same", _faster(_VERB, *_HEYOKA), 1, 3),
    Target("response", _RESPONSE, "diffrax", _faster(_FIXED, "diffrax"), 12, 50),
    Target(
        "response", _RESPONSE, "SciPy DOP853, one by one", _faster(_FIXED, "scipy"), 1500, 5000
    ),
    Target("kernel", "arithmetic of the kernel", "a multiply–add loop", _share, 55, 80, " %"),
    Target(
        "lyapunov", "Lyapunov exponents, a map", "pynamicalsys, per core", _exponents, 300, 1000
    ),
    Target(
        "biaxial", "two directions with a Zener branch, extremes with error",
        "heyoka.py, per core, end only", _faster("remanent", "heyoka"), 1.5, 5,
    ),
    Target(
        "double_well", "a system of one's own, one resolution, no bound",
        "heyoka.py, per core, end only",
        _faster_than("heyoka.py", "remanent, one resolution, no bound"), 2, 5,
    ),
    Target(
        "double_well", "the same with its error", "the same",
        _faster_than("heyoka.py", "remanent"), 2, 5,
    ),
    Target(
        "double_well_exponents", "its Lyapunov exponents", "heyoka.py, per core",
        _faster_than("heyoka.py", "remanent, once"), 2, 5,
    ),
    Target(
        "double_well_exponents", "the same with their error", "heyoka.py, per core, once",
        _faster_than("heyoka.py", "remanent"), 2, 5,
    ),
    Target("branch", "one branch, per point", "AUTO-07p", _points("one"), 1, 5),
    Target("branch", "64 branches together, per point", "AUTO-07p", _points("family"), 5, 20),
    Target(
        "growth", "ten times as many trajectories", "ten times the time", _linear, 1.1, None,
        larger=False,
    ),
    Target(
        "growth", "memory beyond the result", "8 bytes a trajectory", _flat, 8, None, " bytes",
        larger=False,
    ),
    Target("studies", "two local workers", "one", _two_workers, 1.9, None),
    Target(
        "studies", "two processes without a study", "one",
        lambda data: float(data["gain_of_two_processes"]), 1.9, None,
    ),
    Target(
        "studies", "tasks and files of a study, in this process", "its verb on one core",
        _excess("here"), 5, None, " % more", larger=False,
    ),
    Target(
        "studies", "the same, and messages, on one worker", "its verb on one core",
        _excess("one worker"), 5, None, " % more", larger=False,
    ),
    Target(
        "studies", "memory of a million points", "ten thousand", _more_memory, 10, None, " % more",
        larger=False,
    ),
    Target(
        "start", "`import remanent`", "`import numpy`",
        _seconds("import remanent", "import numpy"), 2, 1.3, larger=False,
    ),
    Target(
        "start", "first figure, kernels cached", "bare imports of Numba, xarray, pyplot",
        _seconds("first figure", "bare imports"), 1.5, 1.15, larger=False,
    ),
    Target(
        "start", "first figure, nothing cached", "the same with kernels cached",
        _cold, 6, 3, " s more", larger=False,
    ),
)  # fmt: skip
