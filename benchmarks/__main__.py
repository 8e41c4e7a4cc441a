"""The command: ``python -m benchmarks [ROW ...] [--quick] [--write-docs]``."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable
from typing import Any

import click
from rich.console import Console

from benchmarks import page, store, tables
from benchmarks.machine import busy
from benchmarks.rows import (
    biaxial,
    branch,
    chart,
    growth,
    kernel,
    lyapunov,
    precision,
    start,
    work,
)
from benchmarks.rows.plan import Plan

#: In the order they run: the first compiles what later ones find in memory.
ROWS: dict[str, Callable[[Plan], dict[str, Any]]] = {
    "response": lambda plan: work.measure(plan, "response"),
    "film": lambda plan: work.measure(plan, "film"),
    "kernel": kernel.measure,
    "branch": branch.measure,
    "lyapunov": lyapunov.measure,
    "chart": chart.measure,
    "biaxial": biaxial.measure,
    "start": start.measure,
    "growth": growth.measure,
    "precision": lambda plan: {n: precision.measure(plan, n) for n in ("response", "film")},
}
_TABLES: dict[str, Callable[[Any], tables.Table]] = {
    "kernel": tables.kernel,
    "start": tables.start,
    "branch": tables.branch,
    "lyapunov": tables.lyapunov,
    "chart": tables.chart,
    "biaxial": tables.biaxial,
    "response": tables.work,
    "film": tables.work,
    "growth": tables.growth,
}


@click.command()
@click.argument("rows", nargs=-1, type=click.Choice(list(ROWS)))
@click.option("--quick", is_flag=True, help="Small sizes, to try the code; nothing is written.")
@click.option("--write-docs", is_flag=True, help="Write results and page, even with --quick.")
def main(rows: tuple[str, ...], quick: bool, write_docs: bool) -> None:
    """Measure ROWS, all by default, and write their results and the page of the results."""
    console = Console(highlight=False, log_path=False, width=_width())
    found: dict[str, dict[str, Any]] = {}
    before, plan = busy(), Plan(quick, console.log)
    for row in [row for row in ROWS if not rows or row in rows]:
        found[row] = store.described(_measured(row, plan), quick=quick, busy=before)
        if row in _TABLES:
            console.print(_TABLES[row](found[row]["data"]).drawn())
        if not quick or write_docs:
            store.save(row, found[row])
    console.print(tables.asked(found).drawn())
    if not quick or write_docs:
        everything = {row: found.get(row) or store.load(row) for row in ROWS}
        written = page.write({row: result for row, result in everything.items() if result})
        console.print(f"wrote {written.name}")


def _width() -> int | None:
    """Of the terminal; enough for the tables where there is none."""
    return None if sys.stdout.isatty() else 150


def _measured(row: str, plan: Plan) -> dict[str, Any]:
    """One row, with nothing in the cache of kernels, so that compiling is seen."""
    kept = os.environ.get("REMANENT_CACHE_DIR")
    with tempfile.TemporaryDirectory() as empty:
        os.environ["REMANENT_CACHE_DIR"] = empty
        try:
            return ROWS[row](plan)
        finally:
            del os.environ["REMANENT_CACHE_DIR"]
            if kept is not None:
                os.environ["REMANENT_CACHE_DIR"] = kept


if __name__ == "__main__":
    main()
