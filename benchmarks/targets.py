"""What is asked of the engine, and whether the results give it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

#: Results by row.
Results = dict[str, dict[str, Any]]
_FIXED, _VERB = "remanent-fixed", "remanent"
#: The end only, or extremes as if they cost nothing: whichever is faster.
_HEYOKA = ("heyoka", "heyoka-steps")


@dataclass(frozen=True)
class Target:
    """One line of what is asked.

    Attributes
    ----------
    row
        Whose results it is judged by.
    work, against
        In words.
    value
        The number that counts, from the data of the row; may find nothing.
    least, aim
        To be reached, and to be reached later.
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
        found = results.get(target.row)
        yield Verdict(target, None if found is None else target.value(found["data"]))


def _faster(ours: str, *peers: str) -> Callable[[Any], float | None]:
    """How many times faster ours is than the fastest of some; nothing unless it is as exact."""

    def value(data: Any) -> float | None:
        tools = data["tools"]
        theirs = [tools[peer]["microseconds"] for peer in peers if peer in tools]
        a = tools.get(ours)
        return float(min(theirs) / a["microseconds"]) if a and a["met"] and theirs else None

    return value


def _seconds(numerator: str, denominator: str) -> Callable[[Any], float | None]:
    return lambda data: float(data["seconds"][numerator] / data["seconds"][denominator])


def _cold(data: Any) -> float | None:
    return float(data["seconds"]["first figure, cold"] - data["seconds"]["first figure"])


def _linear(data: Any) -> float | None:
    """Time of the last tenfold step, over ten."""
    before, last = data["rows"][-2:]
    more = last["trajectories"] / before["trajectories"]
    return float(last["seconds"] / before["seconds"] / more)


def _flat(data: Any) -> float | None:
    """Bytes beside the result that every further trajectory of the last step costs."""
    before, last = data["rows"][-2:]
    grown = last["beyond"] - before["beyond"]
    return float(grown / (last["trajectories"] - before["trajectories"]))


def _share(data: Any) -> float | None:
    """Of the kernel of frequency responses."""
    return 100.0 * float(data["kernels"]["extremes and bound"]["share"])


def _points(name: str) -> Callable[[Any], float | None]:
    return lambda data: data["auto"] and float(data["auto"] / data[name]["microseconds"])


def _chaos(data: Any) -> float | None:
    return data["peer"] and float(data["peer"]["microseconds"] / data["microseconds"])


_RESPONSE = "frequency response, one resolution, no bound"
TARGETS = (
    Target("response", _RESPONSE, "heyoka.py, per core", _faster(_FIXED, *_HEYOKA), 2.5, 10),
    Target("response", "the same with its error", "the same", _faster(_VERB, *_HEYOKA), 1.5, 5),
    Target("film", "the same, a film, c = 0.01", "the same", _faster(_VERB, *_HEYOKA), 1, 3),
    Target("response", _RESPONSE, "diffrax", _faster(_FIXED, "diffrax"), 12, 50),
    Target("response", _RESPONSE, "SciPy DOP853", _faster(_FIXED, "scipy"), 1500, 5000),
    Target("kernel", "arithmetic of the kernel", "a multiply–add loop", _share, 55, 80, " %"),
    Target("lyapunov", "Lyapunov exponents, a map", "pynamicalsys, per core", _chaos, 300, 1000),
    Target(
        "biaxial", "two directions with a Zener branch, extremes with error",
        "heyoka.py, per core, end only", _faster("remanent", "heyoka"), 1.5, 5,
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
