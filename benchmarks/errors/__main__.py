"""Measure every error that results carry, and write the page of them."""

from __future__ import annotations

import json
from pathlib import Path

import click

from benchmarks.errors.page import draw, write_page
from benchmarks.errors.row import all_rows, report

#: Results and pages are written below it.
ROOT = Path(__file__).parent.parent.parent


@click.command()
@click.option("--row", "names", multiple=True, help="Measure these only; part of a row's name.")
@click.option("--cases", "count", default=1000, help="Least number of each.")
@click.option("--seed", default=1, help="Of all random choices.")
@click.option("--redraw", is_flag=True, help="Only draw and write what was measured before.")
@click.option("--out", type=click.Path(path_type=Path), default=ROOT, help="Written below it.")
def main(names: tuple[str, ...], count: int, seed: int, redraw: bool, out: Path) -> None:
    """Measure the coverage of every error."""
    results = out / "benchmarks" / "results" / "errors"
    results.mkdir(parents=True, exist_ok=True)
    rows = all_rows()
    for row in rows:
        if redraw or (names and not any(name in row.name for name in names)):
            continue
        with click.progressbar(row.measured(count, seed), length=count, label=row.name) as bar:
            found = report(row, list(bar), seed)
        (results / f"{row.slug}.json").write_text(json.dumps(found) + "\n")
        click.echo(json.dumps(found["total"]))
    saved = [results / f"{row.slug}.json" for row in rows]
    measured = [json.loads(path.read_text()) for path in saved if path.exists()]
    missing = [row.name for row, path in zip(rows, saved, strict=True) if not path.exists()]
    pages = out / "docs" / "results"
    pages.mkdir(parents=True, exist_ok=True)
    draw(measured, pages / "errors.svg")
    write_page(measured, missing, pages / "errors.md")


if __name__ == "__main__":
    main()
