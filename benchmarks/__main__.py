"""The command: ``python -m benchmarks [ROW ...] [--quick] [--write-docs]``."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable
from typing import Any

import click
from rich.console import Console

from benchmarks import auto07p, page, store, tables, validation
from benchmarks.machine import busy
from benchmarks.rows import (
    biaxial,
    branch,
    chart,
    double_well,
    explorer,
    growth,
    kernel,
    lyapunov,
    precision,
    start,
    steps,
    studies,
    work,
)
from benchmarks.rows.plan import Plan
from benchmarks.tools import diffrax_vmap, heyoka_batch, octave_ode45, pynamicalsys_rk45
from benchmarks.tools.tool import Source

#: Rows in the order they run: the first compiles what later ones find in memory.
ROWS: dict[str, Callable[[Plan], dict[str, Any]]] = {
    "response": lambda plan: work.measure(plan, "response"),
    "film": lambda plan: work.measure(plan, "film"),
    "kernel": kernel.measure,
    "steps": steps.measure,
    "branch": branch.measure,
    "lyapunov": lyapunov.measure,
    "chart": chart.measure,
    "biaxial": biaxial.measure,
    "double_well": double_well.measure_response,
    "double_well_exponents": double_well.measure_exponents,
    "studies": studies.measure,
    "start": start.measure,
    "explorer": explorer.measure,
    "growth": growth.measure,
    "precision": lambda plan: {n: precision.measure(plan, n) for n in ("response", "film")},
}
#: What draws the table of a row on the terminal.
_TABLES: dict[str, Callable[[Any], tables.Table]] = {
    "kernel": tables.kernel,
    "start": tables.start,
    "explorer": tables.explorer,
    "steps": tables.steps,
    "branch": tables.branch,
    "lyapunov": tables.lyapunov,
    "chart": tables.chart,
    "biaxial": tables.at_equal_error,
    "double_well": tables.at_equal_error,
    "double_well_exponents": tables.at_equal_error,
    "response": tables.work,
    "film": tables.work,
    "growth": tables.growth,
    "studies": tables.studies,
}


#: What ours is measured against.
_PEERS: tuple[Source, ...] = (
    heyoka_batch.PACKAGE,
    diffrax_vmap.TOOL.source,
    pynamicalsys_rk45.TOOL.source,
    octave_ode45.SOURCE,
    auto07p.SOURCE,
)
#: Width of tables where there is no terminal.
_FILE_WIDTH = 150


@click.command()
@click.argument("rows", nargs=-1, type=click.Choice(list(ROWS)))
@click.option("--quick", is_flag=True, help="Small sizes, to try the code; nothing is written.")
@click.option("--write-docs", is_flag=True, help="Write results and page, even with --quick.")
def main(rows: tuple[str, ...], quick: bool, write_docs: bool) -> None:
    """Measure ROWS, all by default, and write their results and the page of the results."""
    # Without markup: "[bench]" in a command is no style.
    console = Console(highlight=False, log_path=False, markup=False, width=_width())
    results: dict[str, dict[str, Any]] = {}
    busy_before, plan = busy(), Plan(quick, console.log)
    for row in [row for row in ROWS if not rows or row in rows]:
        results[row] = store.described(_measured(row, plan), quick=quick, busy=busy_before)
        if row in _TABLES:
            console.print(_TABLES[row](results[row]["data"]).drawn())
        if not quick or write_docs:
            store.save(row, results[row])
    console.print(tables.targets(results).drawn())
    for line in missing_peers():
        console.print(line)
    if not quick or write_docs:
        everything = {row: results.get(row) or store.load(row) for row in ROWS}
        written = page.write({row: result for row, result in everything.items() if result})
        console.print(f"wrote {written.name} and {validation.write().name}")


def missing_peers() -> list[str]:
    """One line for each peer that cannot run here: why, and how to install it."""
    reasons = [source.missing() for source in _PEERS]
    return [f"peer left out: {reason}" for reason in reasons if reason]


def _width() -> int | None:
    """Width of the terminal; enough for the tables where there is none."""
    return None if sys.stdout.isatty() else _FILE_WIDTH


def _measured(row: str, plan: Plan) -> dict[str, Any]:
    """The data of a row, with nothing in the cache of kernels, so that compiling is seen."""
    folder = os.environ.get("REMANENT_CACHE_DIR")
    with tempfile.TemporaryDirectory() as empty:
        os.environ["REMANENT_CACHE_DIR"] = empty
        try:
            return ROWS[row](plan)
        finally:
            del os.environ["REMANENT_CACHE_DIR"]
            if folder is not None:
                os.environ["REMANENT_CACHE_DIR"] = folder


if __name__ == "__main__":
    main()
