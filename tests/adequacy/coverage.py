"""Lines and branches that the tests run, by package: ``python -m tests.adequacy.coverage``.

Reads what ``make coverage`` recorded.  Lines and branches are counted together: of all lines
that hold a statement and all ways out of a branch, the share that some test took.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from datetime import date
from pathlib import Path
from typing import Any, Final

import click
from coverage import Coverage

from benchmarks import store
from benchmarks.machine import environment
from tests.adequacy.core import PACKAGE, ROOT, is_core, package_of
from tests.adequacy.durations import MEASURED

#: What the numeric core must reach.
LEAST_SHARE_OF_CORE: Final = 0.95
_COUNTED: Final = ("num_statements", "covered_lines", "num_branches", "covered_branches")


@click.command()
@click.option("--save", is_flag=True, help="Keep the table among the results of benchmarks.")
def main(save: bool) -> None:
    """Print the table, and fail where the core is not covered."""
    table = shares(_summaries(MEASURED / "coverage"))
    for name, row in table.items():
        lines = f"{row['covered_lines']:5} of {row['num_statements']:5} lines"
        branches = f"{row['covered_branches']:5} of {row['num_branches']:5} branches"
        click.echo(f"{name:14}{row['share']:8.2%}   {lines}   {branches}")
    if save:
        about = {"date": str(date.today()), "environment": environment()}
        store.save("tests/lines", {**about, "packages": table})
    sys.exit(table["numeric core"]["share"] < LEAST_SHARE_OF_CORE)


def shares(summaries: dict[str, dict[str, int]]) -> dict[str, dict[str, Any]]:
    """The counts of the files of each package, of the core and of all, and the share covered."""
    packages = sorted({package_of(file) for file in summaries})
    groups: dict[str, Iterable[str]] = {
        name: [file for file in summaries if package_of(file) == name] for name in packages
    }
    groups["numeric core"] = [file for file in summaries if is_core(file)]
    groups["in all"] = list(summaries)
    return {name: _sum(summaries[file] for file in files) for name, files in groups.items()}


def _sum(summaries: Iterable[dict[str, int]]) -> dict[str, Any]:
    rows = list(summaries)
    counts = {key: sum(row[key] for row in rows) for key in _COUNTED}
    parts = counts["num_statements"] + counts["num_branches"]
    covered = counts["covered_lines"] + counts["covered_branches"]
    return {"share": covered / parts if parts else 1.0, **counts}


def _summaries(data_file: Path) -> dict[str, dict[str, int]]:
    """What coverage.py counts in each file, named relative to the package."""
    measured = Coverage(data_file=str(data_file))
    measured.load()
    report = data_file.with_suffix(".json")
    measured.json_report(outfile=str(report), include=[f"{ROOT / PACKAGE}/*"])
    files = json.loads(report.read_text("utf-8"))["files"]
    prefix = f"{PACKAGE.as_posix()}/"
    return {
        Path(path).as_posix().partition(prefix)[2]: entry["summary"]
        for path, entry in files.items()
    }


if __name__ == "__main__":
    main()
