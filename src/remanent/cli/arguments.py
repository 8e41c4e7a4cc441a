"""Arguments of commands that say what they are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import click


class DescribedArgument(click.Argument):
    """An argument with a help text, as options have one.

    Click has such a text since version 8.5; with older ones, which are allowed, it stands among
    the options.

    Parameters
    ----------
    declarations : sequence of str
        Its name.
    help : str
        What it is, a sentence.
    **attributes : Any
        As for `click.Argument`.
    """

    def __init__(self, declarations: Sequence[str], *, help: str, **attributes: Any) -> None:
        super().__init__(declarations, **attributes)
        self.help = help

    def get_help_record(self, ctx: click.Context) -> tuple[str, str]:
        """Its name and its text."""
        return self.human_readable_name, str(self.help)
