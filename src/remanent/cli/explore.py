"""``remanent explore``: a page in the browser that follows sliders, or one file of it."""

from __future__ import annotations

import threading
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from remanent._extras import require_extra
from remanent.cli.arguments import DescribedArgument

if TYPE_CHECKING:
    from remanent.web.explorer import Opened

#: The port where nobody chooses another.
_PORT: Final = 8766


@click.command()
@click.argument(
    "source", cls=DescribedArgument, required=False, type=click.Path(exists=True, path_type=Path),
    help="A study file, whose system and drive the page shows, or the store of a study; without it "
    "the page begins with an example.",
)  # fmt: skip
@click.option(
    "--port", type=click.IntRange(0, 65535), default=_PORT, show_default=True,
    help="The port of the page on this machine; 0 for any that is free.",
)  # fmt: skip
@click.option("--no-browser", is_flag=True, help="Only print the address.")
@click.option(
    "--host", default="127.0.0.1", show_default=True,
    help="An address at which other machines reach the page, with a token.",
)  # fmt: skip
@click.option(
    "--save", type=click.Path(dir_okay=False, path_type=Path), metavar="PAGE.html",
    help="Write the page as one file that works without a server, and end.",
)  # fmt: skip
def explore(source: Path | None, port: int, no_browser: bool, host: str, save: Path | None) -> None:
    """Open a page with sliders in the browser.

    Ctrl-C ends it.
    """
    require_extra("web", "the explorer")
    from remanent.web.opening import open_source

    opened = open_source(source)
    if save is not None:
        click.echo(str(_saved(opened, save)))
        return
    _serve(opened, host, port, opens_browser=not no_browser)


def _serve(opened: Opened, host: str, port: int, *, opens_browser: bool) -> None:
    """Serve the page until Ctrl-C."""
    from remanent.web.access import Access
    from remanent.web.explorer import Explorer
    from remanent.web.listening import listening_socket

    listener = listening_socket(host, port)
    access = Access.at(host, listener.getsockname()[1])
    explorer = Explorer(opened)  # its first process starts beside what is imported below
    try:
        click.echo(f"{access.address}  (Ctrl-C ends it)")
        if opens_browser:  # it waits for an answer until there is one
            threading.Thread(target=webbrowser.open, args=(access.address,), daemon=True).start()
        from remanent.web.app import make_app
        from remanent.web.guard import Guard
        from remanent.web.serving import serve

        serve(Guard(make_app(explorer), access), listener)
    except KeyboardInterrupt:
        click.echo("The explorer has ended.", err=True)
    finally:
        explorer.close()


def _saved(opened: Opened, path: Path) -> Path:
    """Write the page of what was opened, with results computed here."""
    from rich.progress import BarColumn, Progress, TextColumn

    from remanent.web.saving import save_page

    with Progress(TextColumn("{task.description}"), BarColumn(), transient=True) as display:
        task = display.add_task("start", total=1.0)
        return save_page(
            opened,
            path,
            lambda stage, share: display.update(task, description=stage, completed=share),
        )
