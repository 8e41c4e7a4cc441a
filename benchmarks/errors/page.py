"""The picture and the page of the study of errors, from what was measured."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from benchmarks.coverage_page import LARGEST_USEFUL_RATIO
from benchmarks.errors.row import Promise
from remanent.plots import style

#: Panels beside each other.
COLUMNS = 4
#: Characters of a line of a title.
TITLE_WIDTH = 28
#: Cases that are asked of each row.
ASKED_CASES = 1000
#: Range of the axes.
ENDS = np.array([1e-16, 1e0])
#: Heading of a table.
_HEADING = """\
| number | error | cases | no error stated | covered | at least | damped | undamped | median ratio |
|---|---|---:|---:|---:|---:|---:|---:|---:|
"""


def draw(measured: Sequence[Mapping[str, Any]], path: Path) -> Figure:
    """Reported against true errors, a panel for each row."""
    height = -(-max(len(measured), 1) // COLUMNS)
    with style.context():
        figure = Figure(
            figsize=(style.DOUBLE_COLUMN_WIDTH_INCHES, 1.9 * height), layout="constrained"
        )
        axes = np.atleast_1d(figure.subplots(height, COLUMNS, sharex=True, sharey=True)).ravel()
        for ax, row in zip(axes, measured, strict=False):
            points = np.array(row["points"], dtype=float).reshape(-1, 2)
            true, reported = np.clip(10.0**points.T, *ENDS)
            covered = true <= reported
            ax.plot(true[covered], reported[covered], ".", ms=1.4, mew=0.0, alpha=0.6,
                    color=style.OKABE_ITO_COLOURS["blue"], rasterized=True)  # fmt: skip
            ax.plot(true[~covered], reported[~covered], "x", ms=2.5, mew=0.7,
                    color=style.OKABE_ITO_COLOURS["vermillion"], rasterized=True)  # fmt: skip
            ax.plot(ENDS, ENDS, "-", color=style.INK_COLOUR, lw=0.7)
            ax.plot(ENDS, LARGEST_USEFUL_RATIO * ENDS, color=style.INK_COLOUR, lw=0.7,
                    ls=style.LINE_STYLES[1])  # fmt: skip
            ax.set(xscale="log", yscale="log", xlim=ENDS, ylim=ENDS)
            ax.set_title(textwrap.fill(row["name"], TITLE_WIDTH), fontsize=6.5)
        for ax in axes[len(measured) :]:
            ax.set_axis_off()
        figure.supxlabel("true error", fontsize=8.0)
        figure.supylabel("reported error", fontsize=8.0)
    style.save_figure(figure, path)
    return figure


def write_page(measured: Sequence[Mapping[str, Any]], missing: Sequence[str], path: Path) -> None:
    """Tables in MyST, to be included in a page of the documentation.

    Parameters
    ----------
    measured : sequence of mapping
        Reports of rows.
    missing : sequence of str
        Names of rows that were not measured.
    path : Path
    """
    bounds = [row for row in measured if row["promise"] == Promise.BOUND.value]
    standard = [row for row in measured if row["promise"] == Promise.STANDARD.value]
    parts = [
        "<!-- Written by `python -m benchmarks.errors`; do not edit. -->\n",
        "Each error is compared with the true one, as heyoka.py "
        f"{version('heyoka')} in extended precision or a closed form has it.\n",
        "```{figure} /results/errors.svg\n"
        ":alt: Reported against true errors, one panel for each number that results carry\n\n"
        "Reported against true errors; crosses are not covered. The full line is equality, the\n"
        "dashed one a hundred times the true error.\n```\n",
        _HEADING + "".join(map(_line, bounds)),
    ]
    if standard:
        parts.append(
            "Standard errors promise that 68 % of the true errors are smaller.\n\n"
            + _HEADING
            + "".join(map(_line, standard))
        )
    if any(row["total"]["cases"] < ASKED_CASES for row in measured):
        parts.append(f"Rows with fewer than {ASKED_CASES} cases are of a shorter run.\n")
    if missing:
        parts.append(f"Not measured yet: {', '.join(missing)}.\n")
    path.write_text("\n".join(parts))


def _line(row: Mapping[str, Any]) -> str:
    total = row["total"]
    ratio = total["median_ratio"]
    return (
        f"| {row['name']} | `{row['variable']}` | {total['cases']} | {total['without']} "
        f"| {_percent(total['coverage'])} | {_percent(total['coverage_at_least'])} "
        f"| {_percent(row['damped']['coverage'])} | {_percent(row['undamped']['coverage'])} "
        f"| {'–' if ratio is None else f'{ratio:.1f}'} |\n"
    )


def _percent(share: float | None) -> str:
    return "–" if share is None else f"{100.0 * share:.2f} %"
