"""Arguments in, one call, a line of progress, an exit code."""

from __future__ import annotations

import signal
import sys
from io import TextIOWrapper
from pathlib import Path
from types import FrameType
from typing import NoReturn

import click

from remanent._errors import RemanentError
from remanent._extras import require_extra
from remanent._machine import available_processor_count
from remanent.cli import studies
from remanent.cli.explore import explore
from remanent.cli.export import export
from remanent.cli.new import new

#: Share of all work that is done when the page is written.
_PROGRESS_BEFORE_PAGE = 0.95
#: Exit code of a program that the user interrupts, by convention of shells.
_INTERRUPTED_EXIT_CODE = 128 + signal.SIGINT
#: Exit code of a program that is asked to end, by convention of shells.
_TERMINATED_EXIT_CODE = 128 + signal.SIGTERM


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="remanent")
def commands() -> None:
    """Nonlinear oscillations of hard-magnetic soft actuators."""


@commands.command()
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("paper"),
    show_default=True,
    help="Folder for the page, the pictures and the data; made if missing.",
)
def paper(out: Path) -> None:
    """Compute the published figures again, and audit the claims.

    This takes a while; a bar shows how far it is.
    """
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    require_extra("paper", "the reproduction of the article")
    from remanent.report.paper import make_folders, reproduce, write_report

    make_folders(out)
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns) as display:
        task = display.add_task("start", total=1.0)

        def report(stage: str, share: float) -> None:
            display.update(task, description=stage, completed=share)

        reproduction = reproduce(report, processes=available_processor_count())
        report("page", _PROGRESS_BEFORE_PAGE)
        target = write_report(reproduction, out)
        report("done", 1.0)
    for v in reproduction.verdicts:
        click.echo(f"{v.claim.id:>4}  {v.verdict:<12}  {v.claim.statement}")
    click.echo(f"\n{target}")


for command in (new, studies.run, studies.verify, studies.show, export, explore):
    commands.add_command(command)


def main() -> None:
    """Run the command; expected failures are one line on standard error."""
    signal.signal(signal.SIGTERM, _exit_as_terminated)
    _write_what_the_console_knows()
    try:
        commands.main(standalone_mode=False)
    except click.ClickException as error:
        error.show()
        sys.exit(error.exit_code)
    except (click.exceptions.Abort, KeyboardInterrupt):
        click.echo("Interrupted.", err=True)
        sys.exit(_INTERRUPTED_EXIT_CODE)
    except (RemanentError, OSError) as error:
        click.echo(f"remanent: {error}", err=True)
        sys.exit(1)


def _write_what_the_console_knows() -> None:
    """Write a question mark for letters that the console does not know, as for λ.

    Standard error writes their numbers by itself.
    """
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")


def _exit_as_terminated(_signal: int, _frame: FrameType | None) -> NoReturn:
    """Leave as by an exception, so that everything that was started is ended."""
    sys.exit(_TERMINATED_EXIT_CODE)
