"""The commands for studies: run one, verify its store, show what is in it."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from remanent.cli.arguments import DescribedArgument

if TYPE_CHECKING:
    from remanent.studies.sweep.run import Progress, ReportProgress

#: Seconds between two lines of progress where the output is no terminal.
_SECONDS_BETWEEN_LINES = 5.0


class Share(click.ParamType[tuple[int, int]]):
    """A share of a study, ``I/N``."""

    name = "I/N"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        """Both numbers, with 1 <= I <= N."""
        if isinstance(value, tuple):
            return value
        index, slash, count = str(value).partition("/")
        numbers = slash and index.isdecimal() and count.isdecimal()
        if not numbers or not 1 <= int(index) <= int(count):
            self.fail(
                f"{value!r} is no share. Write I/N with I from 1 to N, such as 2/8.", param, ctx
            )
        return int(index), int(count)


@click.command()
@click.argument(
    "study", cls=DescribedArgument, type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="The study file.",
)  # fmt: skip
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    help="The store, a folder; by default the one that the file names.",
)
@click.option(
    "--dry-run", is_flag=True, help="Only show the plan: points, time, memory, disk space."
)
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    help="Compute in this many processes of their own, not in this one.",
)
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Compute on a Dask scheduler that runs already, as tcp://host:8786.",
)
@click.option(
    "--part", type=Share(), default="1/1", help="Compute share I of N only, for job arrays."
)
def run(
    study: Path,
    out: Path | None,
    dry_run: bool,
    workers: int | None,
    scheduler: str | None,
    part: tuple[int, int],
) -> None:
    """Compute a study; started again, it goes on where it stopped."""
    from remanent.studies.sweep.study_file import read_study

    described = read_study(study)
    if dry_run:
        from remanent.studies.sweep.plan import plan_study, text

        click.echo(text(plan_study(described.study)))
        return
    path = out or described.store
    if path is None:
        raise click.UsageError("The store has no name. Write `store` in the file, or pass --out.")
    if workers is not None and scheduler is not None:
        raise click.UsageError("Work goes to one place. Pass --workers or --scheduler, not both.")
    if described.point_seconds is not None and workers is None and scheduler is None:
        raise click.UsageError(
            "A cap on the time of a point, `point_seconds`, needs processes that can be ended. "
            "Pass --workers or --scheduler."
        )
    with _told_how_to_go_on(path), _progress() as report:
        _compute(described, path, part, workers, scheduler, report)
    click.echo(str(path))


def _compute(
    described: Any,
    path: Path,
    part: tuple[int, int],
    workers: int | None,
    scheduler: str | None,
    report: ReportProgress,
) -> None:
    from remanent.studies.sweep import run as runs

    if workers is None and scheduler is None:
        with runs.writable_store(path, described.study, part) as store:
            runs.run_here(store, part, report)
        return
    from remanent.studies.sweep import dask_engine
    from remanent.studies.sweep.sample import sample_on

    seconds = described.point_seconds
    clients = (
        dask_engine.local_workers(workers)
        if workers is not None
        else dask_engine.client_of(str(scheduler))
    )
    with clients as client:
        if not dask_engine.worker_count(client):
            click.echo(f"{scheduler} has no workers yet; this waits for the first.", err=True)
        take_sample = sample_on(client, seconds)
        with runs.writable_store(path, described.study, part, take_sample) as store:
            dask_engine.run_on_workers(store, client, part, report, seconds)


@contextmanager
def _told_how_to_go_on(path: Path) -> Iterator[None]:
    """Say what is kept where the run is broken off."""
    try:
        yield
    except (KeyboardInterrupt, SystemExit):
        click.echo(
            f"What was computed is kept in {path}; the same command goes on from there.", err=True
        )
        raise


@contextmanager
def _progress() -> Iterator[ReportProgress]:
    """A bar on a terminal, a line now and then elsewhere."""
    if not sys.stderr.isatty():
        yield _Lines()
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
    from rich.progress import Progress as Bar

    columns = (
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("points, {task.fields[rate]}"),
    )
    with Bar(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task("", total=None, rate="")

        def report(state: Progress) -> None:
            bar.update(task, total=state.total, completed=state.done, rate=_rate(state))

        yield report


class _Lines:
    """A line of progress now and then; it remembers when the last one was."""

    def __init__(self) -> None:
        self._last = float("-inf")

    def __call__(self, state: Progress) -> None:
        """Write a line, unless the last one was a moment ago."""
        now = time.monotonic()
        if state.done < state.total and now - self._last < _SECONDS_BETWEEN_LINES:
            return
        self._last = now
        click.echo(f"{state.done} of {state.total} points{_rate(state, ', ')}", err=True)


def _rate(state: Progress, before: str = "") -> str:
    """Points a second and the time left; nothing before the first task."""
    if not state.rate > 0.0:
        return ""
    left = round(state.seconds_left)
    hours, minutes = left // 3600, left // 60 % 60
    time_left = f"{hours} h {minutes} min" if hours else f"{minutes} min {left % 60} s"
    return f"{before}{state.rate:.3g} a second, {time_left} left"


@click.command()
@click.argument(
    "store", cls=DescribedArgument, type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="The folder with the results of a study.",
)  # fmt: skip
@click.option("--repair", is_flag=True, help="Compute again what is damaged or missing.")
def verify(store: Path, repair: bool) -> None:
    """Read a whole store, and say what is damaged or missing.

    The exit status is 0 when it is whole, 1 when damaged and 3 when incomplete.
    """
    from remanent.studies.sweep.verify import verify_store

    found = verify_store(store)
    click.echo(found.text)
    if repair and found.integrity:
        from remanent.studies.sweep.repair import repair_store

        with _progress() as report:
            repair_store(store, report)
        found = verify_store(store)
        click.echo(found.text)
    sys.exit(int(found.integrity))


@click.command()
@click.argument(
    "store", cls=DescribedArgument, type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="The folder with the results of a study.",
)  # fmt: skip
@click.option(
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    help="The picture: .png, .svg or .pdf; beside the store by default.",
)
def show(store: Path, out: Path | None) -> None:
    """Draw what a store holds so far."""
    from remanent.plots.overview import save_overview
    from remanent.results.files import load

    dataset = load(store)
    path = out or store.resolve().with_suffix(".png")
    save_overview(dataset, path)
    computed = int((dataset["status"] != 0).sum())
    click.echo(f"{path} ({computed} of {dataset['status'].size} points)")
