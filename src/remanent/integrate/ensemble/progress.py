"""Who is told how much of the work is done."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

#: A function that is called with the share that is done, in [0, 1].
ProgressFunction: TypeAlias = Callable[[float], None]


def report_part_of_whole(
    report: ProgressFunction | None, part: slice, count: int
) -> ProgressFunction | None:
    """Report of the share done of a `part` of `count` equal pieces of work, as one of the whole."""
    if report is None:
        return None
    return lambda done: report((part.start + done * (part.stop - part.start)) / count)
