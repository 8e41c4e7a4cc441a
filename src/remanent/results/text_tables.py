"""Tables in text files of any origin: encoding, delimiter, decimal sign, headings, units."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any, Final

import pandas as pd

from remanent._errors import InputError, error_sentence, shortened_repr

__all__ = ["read_text_table"]

#: Most bytes that a table may have.
_MAX_BYTES: Final = 2**30
#: Delimiters in the order in which they are preferred; a blank stands for any blanks.
_DELIMITERS: Final = (",", ";", "\t", "|", " ")
#: What begins a line of comment.
_COMMENT_SIGNS: Final = ("#", "%")
#: Lines from which the form of the table is told.
_SAMPLE_LINES: Final = 200
#: Longest line among them that is looked at, in characters.
_MAX_LINE_CHARACTERS: Final = 100_000
#: Words for a value that is missing.
_MISSING_WORDS: Final = ("", "nan", "na", "n/a", "#n/a", "null", "none", "-", "--")
#: A number with a point or a comma before its decimals.
_NUMBER_PATTERNS: Final = {
    ".": re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?|[+-]?inf(inity)?", re.IGNORECASE),
    ",": re.compile(r"[+-]?(\d+,?\d*|,\d+)([eEdD][+-]?\d+)?|[+-]?inf(inity)?", re.IGNORECASE),
}
_REMEDY: Final = (
    "Write a row of headings, then rows of numbers, with commas, semicolons or tabs between them."
)


@dataclass(frozen=True)
class _Form:
    """How a table is written.

    Attributes
    ----------
    delimiter, decimal : str
    first_row : int
        Number of the line with the first row of numbers.
    fit : int
        Cells of the sample that are numbers, less those that are none.
    """

    delimiter: str
    decimal: str
    first_row: int
    fit: int


def read_text_table(path: Path, argument: str = "data") -> dict[str, Any]:
    """Columns by heading, of a file with a row of headings and rows of numbers.

    Lines before the headings are passed over; a row of units below them joins them.

    Parameters
    ----------
    path : pathlib.Path
        The file: UTF-8, UTF-16 or Latin-1.
    argument : str
        What the message calls it.

    Returns
    -------
    dict of str to pandas.Series

    Raises
    ------
    InputError
        A file that cannot be read or holds no such table.
    """
    try:
        lines = _decoded(path).splitlines()
        form = _form(lines)
        headings = _headings(lines, form)
        return _columns(lines, form, headings)
    except (OSError, ValueError, OverflowError, csv.Error) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            argument,
            must="be a readable CSV or MAT file",
            got=shortened_repr(str(path)),
            why=error_sentence(error),
            fix="Check the path." if isinstance(error, OSError) else _REMEDY,
        ) from error


def _decoded(path: Path) -> str:
    if path.is_dir():
        raise ValueError("It is a folder")
    if path.stat().st_size > _MAX_BYTES:
        raise ValueError(f"It has more than {_MAX_BYTES} bytes")
    data = path.read_bytes()
    if data[:2] in {b"\xff\xfe", b"\xfe\xff"}:
        return data.decode("utf-16")
    if data[1:2] == b"\0" or data[:1] == b"\0":  # UTF-16 without a mark: every other byte is 0
        return data.decode("utf-16-le" if data[1:2] == b"\0" else "utf-16-be")
    if data[:2] == b"PK":
        raise ValueError("It is a spreadsheet or an archive; save the sheet as CSV")
    if b"\0" in data[:10_000]:
        raise ValueError("It holds no text")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _form(lines: Sequence[str]) -> _Form:
    """The delimiter and the decimal sign by which most lines are rows of numbers."""
    sample = [line[:_MAX_LINE_CHARACTERS] for line in lines[:_SAMPLE_LINES]]
    forms = [
        form
        for delimiter in _DELIMITERS
        for decimal in (".", ",")
        if decimal != delimiter and (form := _form_with(sample, delimiter, decimal)) is not None
    ]
    if not forms:
        raise ValueError("It has no rows of at least two numbers")
    return max(forms, key=lambda form: form.fit)


def _form_with(sample: Sequence[str], delimiter: str, decimal: str) -> _Form | None:
    """The rows that a table has if it is written so; None where it has none."""
    number = _NUMBER_PATTERNS[decimal]
    first_row, width, count = -1, 0, 0
    for k, line in enumerate(sample):
        if _is_comment(line):
            continue
        cells = _split(line, delimiter)
        numeric = sum(bool(number.fullmatch(cell)) for cell in cells)
        if first_row < 0 and numeric >= 2 and 2 * numeric >= len(cells):
            first_row, width = k, len(cells)
        if first_row >= 0 and len(cells) == width:
            count += 2 * numeric - len(cells)
    return None if first_row < 0 else _Form(delimiter, decimal, first_row, count)


def _headings(lines: Sequence[str], form: _Form) -> list[str]:
    """One heading for each column; one of a row of units joins them."""
    width = len(_split(lines[form.first_row], form.delimiter))
    above = [k for k in range(form.first_row) if lines[k].strip().strip("".join(_COMMENT_SIGNS))]
    rows = [_split(_without_sign(lines[k]), form.delimiter) for k in above[-2:]]
    if form.delimiter == " ":  # headings of several words, set apart by more blanks than one
        wider = [re.split(r"\s{2,}|\t", _without_sign(lines[k])) for k in above[-2:]]
        rows = [w if len(w) == width else row for row, w in zip(rows, wider, strict=True)]
    if not rows:
        raise ValueError("It has no row of headings above its numbers")
    if len(rows[-1]) != width:
        hint = (
            "; commas before decimals need semicolons between the numbers"
            if form.delimiter == "," and width == 2 * len(rows[-1])
            else ""
        )
        raise ValueError(
            f"Its rows have {width} cells, and the line above them has {len(rows[-1])}{hint}"
        )
    if len(rows) == 2 and len(rows[0]) == width and all(map(_is_unit, rows[1])):
        return [f"{word} [{unit.strip('[](){}')}]" if unit else word
                for word, unit in zip(rows[0], rows[1], strict=True)]  # fmt: skip
    return rows[-1]


def _is_unit(cell: str) -> bool:
    """Whether a cell below a heading is a unit: nothing, in brackets, or short."""
    return not cell or cell[0] + cell[-1] in {"[]", "()", "{}"} or len(cell) <= 3


def _columns(lines: Sequence[str], form: _Form, headings: Sequence[str]) -> dict[str, Any]:
    body = "\n".join(line for line in lines[form.first_row :] if not _is_comment(line))
    table = pd.read_csv(
        StringIO(body),
        sep=r"\s+" if form.delimiter == " " else form.delimiter,
        decimal=form.decimal,
        header=None,
        names=range(len(headings)),
        index_col=False,
        comment="#",
        skipinitialspace=True,
        na_values=list(_MISSING_WORDS),
        low_memory=False,
    )
    # A delimiter at the end of each line makes a column of nothing.
    kept = [k for k, word in enumerate(headings) if word or not table[k].isna().all()]
    named = [headings[k] or f"column {k + 1}" for k in kept]
    if len(set(named)) < len(named):
        twice = next(name for name in named if named.count(name) > 1)
        raise ValueError(f"Two of its columns are called {shortened_repr(twice)}")
    return {name: table[k] for name, k in zip(named, kept, strict=True)}


def _is_comment(line: str) -> bool:
    return not line.strip() or line.lstrip().startswith(_COMMENT_SIGNS)


def _without_sign(line: str) -> str:
    return line.strip().lstrip("".join(_COMMENT_SIGNS)).strip()


def _split(line: str, delimiter: str) -> list[str]:
    if delimiter == " ":
        return line.split()
    cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
    return [cell.strip() for cell in cells]
