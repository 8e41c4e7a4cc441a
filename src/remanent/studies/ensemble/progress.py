"""What ``progress=`` means: a bar, a function to call, or silence."""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any, TypeAlias

from remanent._checks import shortened_repr
from remanent._errors import InputError
from remanent.integrate.ensemble.progress import ProgressFunction

__all__ = ["ProgressArgument", "ProgressFunction", "as_progress"]

#: What verbs accept as ``progress``.
ProgressArgument: TypeAlias = bool | ProgressFunction | None
#: Characters of a bar.
_BAR_WIDTH_CHARACTERS = 40


def as_progress(progress: ProgressArgument) -> ProgressFunction | None:
    """A function to call with the share that is done, or None.

    Parameters
    ----------
    progress : bool or callable or None
        True draws a bar: below the cell of a notebook, else on standard error, with Rich where
        it is installed; a function is called with the share in [0, 1]; None and False do nothing.

    Raises
    ------
    InputError
        If it is anything else.
    """
    if progress is None or progress is False:
        return None
    if progress is True:
        return _ProgressBar(_choose_bar_drawer())
    if callable(progress):
        return progress
    raise InputError(
        "progress",
        must="be True, False, None or a function of one number",
        got=shortened_repr(progress),
        why="It is told the share that is done, in [0, 1].",
        fix="Pass True for a bar.",
    )


class _ProgressBar:
    """A line that is written again as work goes on.

    Calling it changes the line, and what it remembers of it.  It needs no end: no thread runs
    and the terminal is in no other state than before, also where the work is broken off.
    """

    def __init__(self, draw: Callable[[float, str], None]) -> None:
        self._draw = draw
        self._drawn_percent = -1

    def __call__(self, done: float) -> None:
        """Draw the share that is done, if it looks different from before."""
        percent = int(100.0 * min(max(done, 0.0), 1.0))
        if percent != self._drawn_percent:
            self._drawn_percent = percent
            self._draw(percent / 100.0, "\n" if percent == 100 else "\r")


def _choose_bar_drawer() -> Callable[[float, str], None]:
    """How a bar is drawn: below a cell, by Rich where it is installed, else in plain text."""
    if _runs_in_notebook():
        return _cell_bar_drawer()
    try:
        from rich.console import Console
        from rich.progress_bar import ProgressBar
    except ImportError:
        return _draw_plain_bar
    console = Console(stderr=True)

    def draw(done: float, end: str) -> None:
        bar = ProgressBar(total=1.0, completed=done, width=_BAR_WIDTH_CHARACTERS)
        console.print(bar, f" {done:4.0%}", end=end, highlight=False)

    return draw


def _runs_in_notebook() -> bool:
    """Whether cells of a notebook show what is displayed; a shell in a terminal has no kernel."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return getattr(shell, "kernel", None) is not None


def _cell_bar_drawer() -> Callable[[float, str], None]:
    """A bar below the cell, which needs no widgets: one display, updated."""
    display = import_module("IPython.display").display
    shown: list[Any] = []

    def draw(done: float, _: str) -> None:
        percent = f"{done:.0%}"
        bar = {
            "text/html": f'<progress value="{done:.2f}" max="1"></progress> {percent}',
            "text/plain": _plain_bar(done),
        }
        if shown:
            shown[0].update(bar, raw=True)
        else:
            shown.append(display(bar, raw=True, display_id=True))

    return draw


def _draw_plain_bar(done: float, end: str) -> None:
    print(_plain_bar(done), end=end, file=sys.stderr, flush=True)


def _plain_bar(done: float) -> str:
    filled = round(_BAR_WIDTH_CHARACTERS * done)
    bar = "#" * filled + "-" * (_BAR_WIDTH_CHARACTERS - filled)
    return f"[{bar}] {done:4.0%}"
