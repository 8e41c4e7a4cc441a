"""``remanent export``: the equations of a study in another tool's language."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import click

from remanent._errors import InputError
from remanent.cli.arguments import DescribedArgument


@click.command()
@click.argument(
    "study", cls=DescribedArgument, type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="The study file, whose system and drive are written.",
)  # fmt: skip
@click.option(
    "--to", "language", required=True, metavar="LANGUAGE",
    help="One of matlab, python, julia, auto07p, c, javascript.",
)  # fmt: skip
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    help="The folder to write into, or the file where the language has one only; the current "
    "folder by default.",
)
def export(study: Path, language: str, out: Path | None) -> None:
    """Write the equations of motion for another tool.

    No file is replaced.
    """
    from remanent.studies.export.export import export as export_equations
    from remanent.studies.sweep.study_file import read_study

    described = read_study(study).study
    if described.drive is None:
        raise InputError(
            "STUDY",
            must="have a table [drive]",
            got=str(study),
            why="The load as a function of time is a part of the equations.",
            fix='Add it, for example with kind = "Constant" and m = 0.',
        )
    files = export_equations(described.system, described.drive, language)
    for path in write_new_files(files, out):
        click.echo(str(path))


def write_new_files(files: Mapping[str, str], out: Path | None) -> list[Path]:
    """Write files where there are none of their names yet.

    Parameters
    ----------
    files : mapping of str to str
        Texts by names.
    out : pathlib.Path or None
        The file itself where there is one and this is no folder, else the folder; None for the
        current folder.

    Returns
    -------
    list of pathlib.Path
        What was written.
    """
    paths = _paths(files, out)
    for path in paths.values():
        if path.exists():
            raise InputError(
                "--out",
                must="name files that are not there yet",
                got=str(path),
                why="Nothing is written over.",
                fix="Pass another name, or remove the file.",
            )
    for name, path in paths.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("x", encoding="utf-8") as file:
            file.write(files[name])
    return list(paths.values())


def _paths(files: Mapping[str, str], out: Path | None) -> dict[str, Path]:
    if out is not None and len(files) == 1 and not out.is_dir():
        return dict.fromkeys(files, out)
    folder = Path() if out is None else out
    if folder.exists() and not folder.is_dir():
        raise InputError(
            "--out",
            must=f"be a folder for {', '.join(files)}",
            got=str(out),
            why="The language takes several files.",
            fix="Pass the name of a folder; it is made if missing.",
        )
    return {name: folder / name for name in files}
