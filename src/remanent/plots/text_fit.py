"""Text that fits: how wide it is, and where it is broken."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence

import matplotlib as mpl
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path

__all__ = ["broken_text", "points", "text_width", "wrapped_text"]


def points(size: object) -> float:
    """A size of letters in points, of a number or of a word such as ``medium``."""
    return float(FontProperties(size=size).get_size_in_points())  # type: ignore[arg-type]


def text_width(text: str, size: float) -> float:
    """Width of the longest line of a text in the font in force.

    Parameters
    ----------
    text : str
        With mathematics between dollar signs.
    size : float
        Of its letters, in points.

    Returns
    -------
    float
        In points.
    """
    font = FontProperties(family=mpl.rcParams["font.family"], size=size)
    return max(
        float(text_to_path.get_text_width_height_descent(line, font, ismath="$" in line)[0])
        for line in text.split("\n")
    )


def broken_text(text: str, room: float, size: float) -> str:
    """The text in one line, or in two or three of about one length where it is too wide.

    Parameters
    ----------
    text : str
        With mathematics between dollar signs, which is not broken.
    room : float
        Width that each line may have, in points.
    size : float
        Of its letters, in points.

    Returns
    -------
    str
        Where nothing fits, the text whose longest line is shortest.
    """
    words = _unbreakable_words(text)
    best = text
    for count in range(1, min(4, len(words) + 1)):
        best = min(_breaks(words, count), key=lambda lines: text_width(lines, size))
        if text_width(best, size) <= room:
            break
    return best


def wrapped_text(text: str, room: float, size: float, line_count: int) -> str:
    """A text in lines that are as full as they can be, cut with an ellipsis where it is longer.

    Parameters
    ----------
    text : str
        Without mathematics.
    room : float
        Width that each line may have, in points.
    size : float
        Of its letters, in points.
    line_count : int
        How many lines there may be.

    Returns
    -------
    str
    """
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if not lines[-1] or text_width(longer, size) <= room:
            lines[-1] = longer
        elif len(lines) < line_count:
            lines.append(word)
        else:
            while text_width(f"{lines[-1]} …", size) > room and " " in lines[-1]:
                lines[-1] = lines[-1].rpartition(" ")[0]
            lines[-1] += " …"
            break
    return "\n".join(lines)


def _unbreakable_words(text: str) -> list[str]:
    """Words, of which mathematics between dollar signs is one."""
    return re.findall(r"(?:\$[^$]*\$|[^\s$])+", text)


def _breaks(words: Sequence[str], count: int) -> list[str]:
    """Every way to write words in so many lines."""
    places = itertools.combinations(range(1, len(words)), count - 1)
    return [
        "\n".join(" ".join(words[a:b]) for a, b in itertools.pairwise((0, *cuts, len(words))))
        for cuts in places
    ]
