"""The picture and the page of the coverage study, from what was measured."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from remanent.plots import style

#: Reported over true error up to which a bound counts as useful.
LARGEST_USEFUL_RATIO = 100.0
#: Coverage that is asked.
ASKED_COVERAGE = 0.995
#: Heading of a table.
_HEADING = """\
| {0} | trajectories | to the end | covered | at least | covered up to the horizon | median ratio |
|---|---:|---:|---:|---:|---:|---:|
"""


def draw(results: Mapping[str, Any], path: Path) -> Figure:
    """Reported against true errors, and the share of them covered by decade of tolerance."""
    with style.context():
        figure = Figure(figsize=(style.DOUBLE_COLUMN_WIDTH_INCHES, 3.1), layout="constrained")
        left, right = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
        _errors(left, np.array(results["points"], dtype=float))
        _coverage(right, results["decades"], results["total"])
        footer = f"seed {results['seed']}   remanent {results['remanent']}   {results['reference']}"
        figure.supxlabel(footer, x=0.01, ha="left", fontsize=6.0, color=style.FAINT_COLOUR)
    style.save_figure(figure, path)
    return figure


def _errors(ax: Axes, points: np.ndarray[Any, np.dtype[np.float64]]) -> None:
    ends = np.array([1e-16, 1e-3])
    true, reported = np.clip(10.0**points.T, *ends)
    covered = true <= reported
    ax.plot(true[covered], reported[covered], ".", ms=1.6, mew=0.0, alpha=0.6,
            color=style.OKABE_ITO_COLOURS["blue"], rasterized=True)  # fmt: skip
    ax.plot(true[~covered], reported[~covered], "x", ms=4.0, mew=0.9, clip_on=False,
            color=style.OKABE_ITO_COLOURS["vermillion"], label="not covered")  # fmt: skip
    ax.plot(ends, ends, "-", color=style.INK_COLOUR, lw=0.8)
    ax.plot(
        ends, LARGEST_USEFUL_RATIO * ends, color=style.INK_COLOUR, lw=0.8, ls=style.LINE_STYLES[1]
    )
    ax.set(xscale="log", yscale="log", xlim=ends, ylim=ends)
    ax.set(xlabel="true error", ylabel="reported error")
    style.set_panel_title(ax, "a", f"{true.size} trajectories")
    on_line: Any = {"rotation": 45.0, "rotation_mode": "anchor", "transform_rotates_text": True}
    on_line["fontsize"] = 7.5
    ax.text(1.5e-15, 0.8e-15, "equal", va="top", **on_line)
    # Points lie below the word.
    on_line["path_effects"] = [withStroke(linewidth=2.0, foreground=ax.get_facecolor())]
    ax.text(1.5e-16, 2.2e-14, "100 times", va="bottom", **on_line)


def _coverage(ax: Axes, decades: Mapping[str, Any], total: Mapping[str, Any]) -> None:
    powers = np.array([int(name[2:]) for name in decades])
    missed = np.array([100.0 * (1.0 - row["coverage"]) for row in decades.values()])
    worst = np.array([100.0 * (1.0 - row["coverage_at_least"]) for row in decades.values()])
    ax.bar(powers + 0.5, missed, width=0.7, color=style.OKABE_ITO_COLOURS["blue"])
    ax.errorbar(powers + 0.5, missed, yerr=[0.0 * worst, worst - missed], fmt="none",
                ecolor=style.INK_COLOUR, elinewidth=0.8, capsize=2.0)  # fmt: skip
    missed_limit = 100.0 * (1.0 - ASKED_COVERAGE)
    ax.axhline(missed_limit, color=style.INK_COLOUR, lw=0.8, ls=style.LINE_STYLES[1])
    ax.text(powers[0] + 0.1, missed_limit, "asked", va="bottom", fontsize=7.5)
    ticks = np.arange(powers[0], powers[-1] + 2, 2)
    ax.set_xticks(ticks, [f"$10^{{{k}}}$" for k in ticks])
    ax.set(xlabel="tolerance", ylabel="not covered (%)", xlim=(powers[0], powers[-1] + 1))
    ax.set_ylim(0.0, 1.25 * max(missed_limit, worst.max()))
    style.set_panel_title(ax, "b", f"covered in all: {100.0 * total['coverage']:.2f} %")


def write_page(results: Mapping[str, Any], path: Path) -> None:
    """Tables in MyST, to be included in a page of the documentation."""
    total = results["total"]
    parts = [
        "<!-- Written by `python -m benchmarks.coverage`; do not edit. -->\n",
        f"Of {total['cases']} random trajectories {_percent(total['ok'])} met the tolerance to "
        f"their end. The reported error covered the true one in {_percent(total['coverage'])} of "
        f"these (at least {_percent(total['coverage_at_least'])} at 95 % confidence) and was "
        f"{total['median_ratio']:.1f} times as large at the median. The true errors are "
        f"differences from {results['reference']}.\n",
        "```{figure} /results/coverage.svg\n"
        ":alt: Left, points of reported against true errors, with lines where they are equal and "
        "where the reported one is a hundred times as large; right, a bar and a limit for each "
        "decade of the tolerance\n\n"
        "Reported against true errors, and the share of trajectories whose reported error was\n"
        "smaller than the true one, by decade of the tolerance, with limits at 95 % confidence.\n"
        "```\n",
        _table("tolerance", {_decade(name): row for name, row in results["decades"].items()}),
        _table("drive", results["drives"]),
        _table("slenderness c", {_decade(n): row for n, row in results["slenderness"].items()}),
    ]
    if results["uncovered"]:
        parts.append(_uncovered(results["uncovered"]))
    path.write_text("\n".join(parts))


def _table(what: str, rows: Mapping[str, Any]) -> str:
    lines = [
        f"| {name} | {row['cases']} | {_percent(row['ok'])} | {_percent(row['coverage'])} "
        f"| {_percent(row['coverage_at_least'])} | {_percent(row['coverage_up_to_horizon'])} "
        f"| {row['median_ratio']:.1f} |\n"
        for name, row in rows.items()
    ]
    return _HEADING.format(what) + "".join(lines)


def _uncovered(rows: list[dict[str, Any]]) -> str:
    lines = [
        "| not covered | drive | c | tolerance | status | reported | true |\n",
        "|---|---|---:|---:|---|---:|---:|\n",
    ]
    lines += [
        f"| `{r['case']}` | {r['kind']} | {r['c']:.2g} | {r['tolerance']:.1e} | {r['status']} "
        f"| {r['reported']:.1e} | {r['true']:.1e} |\n"
        for r in rows
    ]
    return "`python -m benchmarks.coverage --one CASE` measures one of these again.\n\n" + "".join(
        lines
    )


def _decade(name: str) -> str:
    low = int(name[2:])
    return f"10{_raised(low)} to 10{_raised(low + 1)}"


def _raised(power: int) -> str:
    return str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def _percent(share: float | None) -> str:
    return "–" if share is None else f"{100.0 * share:.2f} %"
