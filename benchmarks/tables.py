"""Results as tables of text, for the terminal and for the page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from rich.table import Table as Drawn

from benchmarks.targets import Results, verdicts


@dataclass(frozen=True)
class Table:
    """A heading for every column, and rows."""

    heading: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]

    def drawn(self) -> Drawn:
        """For the terminal."""
        drawn = Drawn(*self.heading)
        for row in self.rows:
            drawn.add_row(*row)
        return drawn

    def markdown(self) -> str:
        lines = [self.heading, tuple("---" for _ in self.heading), *self.rows]
        return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def number(x: float | None) -> str:
    """Three digits, without an exponent where that is short; a dash for what is missing."""
    if x is None:
        return "–"
    return f"{x:.0f}" if abs(x) >= 100 else f"{x:.3g}"


def error(x: float | None) -> str:
    """One digit; none where no error was measured."""
    return "none" if x is None else f"{x:.0e}"


def targets(results: Results) -> Table:
    """What is asked against what was measured."""
    heading = ("work", "against", "measured", "at least", "aim", "met")
    rows = []
    for verdict in verdicts(results):
        t = verdict.target
        aim = "" if t.aim is None else number(t.aim) + t.unit
        measured = "–" if verdict.value is None else number(verdict.value) + t.unit
        sign = "" if t.larger else "≤ "
        least = sign + number(t.least) + t.unit
        rows.append((t.work, t.against, measured, least, aim and sign + aim, verdict.text))
    return Table(heading, rows)


def work(data: Any) -> Table:
    """Tools on one job, the fastest first."""
    tools = data["tools"]
    ours = tools["remanent"]["microseconds"] if "remanent" in tools else None
    heading = ("tool", "version", "µs", "ratio", "median error", "worst error",
               "compiling, s", "setting")  # fmt: skip
    rows = [
        (
            one["name"], one["version"], number(one["microseconds"]),
            number(one["microseconds"] / ours if ours else None),
            error(one["median"]), error(one["worst"]) + _remark(one),
            number(one["compiling"]), _setting(one),
        )
        for one in sorted(tools.values(), key=lambda one: one["microseconds"])
    ]  # fmt: skip
    return Table(heading, rows)


def steps(data: Any) -> Table:
    """Steps over those of an oracle, and the factors of this."""
    heading = ("work", "trajectories", "tolerance", "resolution", "runs", "lanes", "companion",
               "together", "bound over error")  # fmt: skip
    rows = [
        (
            one["name"], str(one["trajectories"]), f"{one['tolerance']:.0e}",
            number(one["resolution"]), number(one["runs"]), number(one["lanes"]),
            number(data["companion"]), number(one["all"]), number(one["bound_over_error"]),
        )
        for one in data["rows"]
    ]  # fmt: skip
    return Table(heading, rows)


def _remark(one: Any) -> str:
    if one["missing"]:
        return f", {one['missing']} without a value"
    return "" if one["met"] else " (too large)"


def _setting(one: Any) -> str:
    exact = one["setting_name"] != "tolerance"
    return f"{one['setting']:.0f} {one['setting_name']}" if exact else f"{one['setting']:.1e}"


def kernel(data: Any) -> Table:
    """Operations of a step and lane, and the shares of the multiply-add loop."""
    heading = ("kernel", "method", "ns", "multiply–adds", "multiplications", "additions",
               "divisions", "share of slots", "share of operations")  # fmt: skip
    kinds = ("fma", "mul", "add", "div")
    rows = [
        (
            name, one["method"], number(one["nanoseconds"]),
            *(str(one["work"].get(kind, 0) // one["lanes"]) for kind in kinds),
            f"{one['share']:.0%}", f"{one['flops_share']:.0%}",
        )
        for name, one in data["kernels"].items()
    ]  # fmt: skip
    return Table(heading, rows)


def growth(data: Any) -> Table:
    """Time and memory by number of trajectories."""
    heading = ("trajectories", "s", "µs each", "result, MiB", "memory beyond it, MiB")
    rows = [
        (
            _grouped(one["trajectories"]),
            number(one["seconds"]), number(1e6 * one["seconds"] / one["trajectories"]),
            number(one["result"] / 2**20), number(one["beyond"] / 2**20),
        )
        for one in data["rows"]
    ]  # fmt: skip
    return Table(heading, rows)


def branch(data: Any) -> Table:
    """Time of a point, and how well orbits close."""
    heading = ("branches", "points", "µs a point", "worst closure of the one branch")
    rows = [
        (str(one["branches"]), str(one["points"]), number(one["microseconds"]), closure)
        for one, closure in ((data["one"], error(data["defect"])), (data["family"], ""))
    ]
    theirs = error(data["auto_defect"]) if data["auto"] else ""
    return Table(heading, [*rows, (data["auto_version"], "500", number(data["auto"]), theirs)])


def lyapunov(data: Any) -> Table:
    """Time of Lyapunov exponents, each program at equal error of a period."""
    tools = {"Remanent, two runs, with its error": (f"{data['side']} × {data['side']}", data)}
    if data["peer"]:
        tools[f"pynamicalsys {data['peer']['version']}"] = (
            str(data["peer"]["points"]),
            data["peer"],
        )
    rows = [
        (name, points, number(one["microseconds"]), error(one["tolerance"]), error(one["worst"]))
        for name, (points, one) in tools.items()
    ]
    heading = ("tool", "points", "µs per trajectory and τ", "tolerance", "worst error of a period")
    return Table(heading, rows)


def chart(data: Any) -> Table:
    """Time of a chart of regimes, and the shares of the regimes."""
    motions = data["side"] ** 2
    shares = ", ".join(f"{name} {100 * n / motions:.1f} %" for name, n in data["regimes"].items())
    rows = [(f"{data['side']} × {data['side']}", str(data["periods"]), number(data["seconds"]),
             number(data["processor_seconds"]), str(data["cores"]), shares)]  # fmt: skip
    heading = ("motions", "periods", "s", "s of processors", "cores", "regimes")
    return Table(heading, rows)


def at_equal_error(data: Any) -> Table:
    """Time of tools that are all as exact as asked."""
    rows = [
        (name, number(one["microseconds"]), error(one["worst"]), _setting(one))
        for name, one in data["tools"].items()
    ]
    return Table(("tool", "µs per trajectory and τ", "worst error", "setting"), rows)


def studies(data: Any) -> Table:
    """Time of a study by way of running, and memory by number of points."""
    seconds = data["seconds"]
    rows = [
        (f"{data['side']} × {data['side']}", name, number(one),
         number(one / seconds["the verb"]), "")
        for name, one in seconds.items()
    ]  # fmt: skip
    rows += [
        (_grouped(one["points"]), "here, both cores", "", "", number(one["peak"] / 2**20))
        for one in data["memory"]
    ]
    return Table(("points", "run", "s", "of the verb's time", "peak, MiB"), rows)


def _grouped(count: int) -> str:
    """A number with its thousands set apart."""
    return f"{count:,}".replace(",", "\N{NARROW NO-BREAK SPACE}")


def start(data: Any) -> Table:
    """Time of whole processes."""
    rows = [(name, number(seconds)) for name, seconds in data["seconds"].items()]
    return Table(("a new process", "s"), rows)


def explorer(data: Any) -> Table:
    """Time of the page's own engine."""
    rows = [
        (name, number(one["median"]), number(one["first"]), str(one["steps"]), error(one["error"]))
        for name, one in data["systems"].items()
    ]
    return Table(("system", "ms", "first run, ms", "steps in a period", "stated error"), rows)


def environment(results: Iterable[dict[str, Any]]) -> Table:
    """Hardware and versions; several where rows were measured apart."""
    values: dict[str, list[str]] = {}
    for result in results:
        for name, value in result["environment"].items():
            if value not in values.setdefault(name, []):
                values[name].append(value)
    return Table(("", ""), [(name, ", ".join(several)) for name, several in values.items()])
