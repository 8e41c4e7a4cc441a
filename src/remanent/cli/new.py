"""``remanent new``: a commented study file to start from."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from string import Template

import click

from remanent._errors import InputError
from remanent.cli.arguments import DescribedArgument

#: Studies to start from, files in the folder of examples.
EXAMPLES = ("chart", "atlas")


def text_of_example(example: str, name: str) -> str:
    """An example, whose store has this name."""
    file = files("remanent.cli") / "examples" / f"{example}.toml"
    return Template(file.read_text(encoding="utf-8")).substitute(name=name)


@click.command()
@click.argument(
    "name", cls=DescribedArgument, default="study",
    help="The file is called NAME.toml, or study.toml where no name is given.",
)  # fmt: skip
@click.option(
    "--example", type=click.Choice(EXAMPLES), default=EXAMPLES[0], show_default=True,
    help="What to begin with: a small chart of regimes, or one for all temperatures, loads and "
    "frequencies.",
)  # fmt: skip
def new(name: str, example: str) -> None:
    """Write a commented study file to start from."""
    path = Path(name if name.endswith(".toml") else f"{name}.toml")
    if not path.stem.isprintable() or set('"\\') & set(path.stem):
        raise InputError(
            "NAME",
            must="be a name without quotes and backslashes",
            got=repr(name),
            why="The file names its store after it.",
            fix="Write for example `remanent new chart`.",
        )
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text_of_example(example, path.stem))
    except FileExistsError:
        raise InputError(
            "NAME",
            must="be a name that is free",
            got=str(path),
            why="The file is there already, and nothing is written over.",
            fix="Pass another name, or remove the file.",
        ) from None
    click.echo(f"Wrote {path}. Edit it, then run it with `remanent run {path}`.")
