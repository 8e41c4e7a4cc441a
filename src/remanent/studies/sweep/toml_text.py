"""The text of a study file as plain data, of bounded size."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable, Iterator, Sequence
from datetime import date, time
from pathlib import Path
from typing import Any, Final

from remanent._errors import RemanentError, error_sentence
from remanent.studies.sweep.faults import Fault, KeyPath, StudyFileError, shown

#: Largest file, in bytes.
MAX_FILE_BYTES: Final = 2**20
#: Most tables and lists within each other.
MAX_DEPTH: Final = 12
#: Longest text of one value, in characters.
MAX_TEXT_CHARACTERS: Final = 4000
#: Longest name, in characters.
_MAX_KEY_CHARACTERS: Final = 200
#: Largest integer that floats hold exactly, as all smaller ones.
_LARGEST_INTEGER: Final = 2**53
#: Keys of more parts than this take a parser long; the parts are bounded to be found in one pass.
_LONG_KEY: Final = re.compile(r"(?<![\w\"'-])(?:[\w\"'-]{1,200}[ \t]*\.[ \t]*){33}")
#: Where the parser found an error, at the end of its message.
_PLACE_PATTERN: Final = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)$")
_SYNTAX_REMEDY: Final = (
    "Write one `key = value` a line, text in quotes, true and false in small letters; "
    "`remanent new` writes a file to start from."
)


def read_document(path: Path) -> dict[str, Any]:
    """The tables of a file.

    Parameters
    ----------
    path : pathlib.Path

    Returns
    -------
    dict

    Raises
    ------
    StudyFileError
        The file is too large, no text in UTF-8, or no TOML; a line is named.
    RemanentError
        It cannot be read.
    """
    try:
        with path.open("rb") as file:
            content = file.read(MAX_FILE_BYTES + 1)
    except OSError as error:
        raise RemanentError(f"{path}: {error_sentence(error)}") from error
    if len(content) > MAX_FILE_BYTES:
        raise _refused(
            path,
            f"be at most {MAX_FILE_BYTES // 1024} KiB",
            "more",
            "A study is a few lines; values that follow a rule are written as ranges.",
            "Write { from = ..., to = ..., count = ... } in place of a long list.",
        )
    return _parsed(path, _decoded(path, content))


def _decoded(path: Path, content: bytes) -> str:
    """Text in UTF-8, with or without a mark of byte order before it."""
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise _refused(
            path,
            "be text in UTF-8",
            f"the byte 0x{content[error.start]:02x} in line {line}",
            "TOML is written in UTF-8.",
            "Save it as UTF-8 in the editor.",
        ) from None


def _parsed(path: Path, text: str) -> dict[str, Any]:
    long_key = _LONG_KEY.search(text)
    if long_key is not None:
        line = text.count("\n", 0, long_key.start()) + 1
        raise _nested_error(path, f"a key of many parts in line {line}")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise _syntax_error(path, text, str(error)) from None
    except RecursionError:
        raise _nested_error(path, "a list or table of more") from None
    except ValueError as error:  # a number of too many digits, or a day that is none
        raise _refused(
            path, "hold numbers of ordinary length", error_sentence(error),
            "They are numbers of floating point.", "Write them in at most 17 digits.",
        ) from None  # fmt: skip


def _syntax_error(path: Path, text: str, message: str) -> StudyFileError:
    lines = text.split("\n")
    found = _PLACE_PATTERN.search(message)
    number = int(found[1]) if found and found[1] else len(lines)
    line = lines[min(number, len(lines)) - 1].strip()
    said = _PLACE_PATTERN.sub("", message).rstrip(".")
    twice = "Cannot overwrite" in said or "twice" in said or "mutate" in said
    fix = "Each table and each key stands once: remove or rename one." if twice else _SYNTAX_REMEDY
    got = shown(line) if line else "the end of the line"
    return _refused(path, "be TOML", got, f"{said}.", fix, line=number)


def _nested_error(path: Path, got: str) -> StudyFileError:
    return _refused(
        path, f"have at most {MAX_DEPTH} tables and lists within each other", got,
        "No part of a study has more.", "Write it with fewer.",
    )  # fmt: skip


def _refused(
    path: Path, must: str, got: str, why: str, fix: str, line: int | None = None
) -> StudyFileError:
    where: KeyPath = () if line is None else (f"line {line}",)
    return StudyFileError(path.name, [Fault(where, must, got, why, fix)])


def faults_of_values(document: dict[str, Any]) -> list[Fault]:
    """Values that no study has, wherever they stand: dates, NaN, infinity, long texts."""
    return [fault for path, value in _entries(document) if (fault := _fault_of_value(path, value))]


def _entries(document: dict[str, Any]) -> Iterator[tuple[KeyPath, Any]]:
    """Every value in a document, tables and lists too, with its place."""
    waiting: list[tuple[KeyPath, Any]] = [((), document)]
    while waiting:
        path, value = waiting.pop()
        if path:
            yield path, value
        if len(path) > MAX_DEPTH:
            continue
        if isinstance(value, dict):
            waiting += [((*path, key), entry) for key, entry in reversed(value.items())]
        elif isinstance(value, list):
            waiting += [((*path, k), value[k]) for k in range(len(value) - 1, -1, -1)]


def _fault_of_value(path: KeyPath, value: Any) -> Fault | None:
    """What is wrong with a value wherever it stands; None where nothing is."""
    for wrong, must, got, why, fix in _RULES:
        if wrong(path, value):
            return Fault(path, must, got(value), why, fix)
    return None


_Test = Callable[[KeyPath, Any], bool]
#: For each rule what breaks it, the rule, what was found, the reason and the remedy.
_RULES: Final[Sequence[tuple[_Test, str, Callable[[Any], str], str, str]]] = (
    (
        lambda path, _: len(str(path[-1])) > _MAX_KEY_CHARACTERS,
        f"have names of at most {_MAX_KEY_CHARACTERS} characters",
        lambda _: "a longer one", "They are names of fields.", "Shorten it.",
    ),
    (
        lambda path, value: len(path) > MAX_DEPTH and isinstance(value, dict | list),
        f"have at most {MAX_DEPTH} tables and lists within each other",
        lambda _: "more", "No part of a study has more.", "Write it with fewer.",
    ),
    (
        lambda _, value: isinstance(value, date | time), "be a number, text, a list or a table",
        lambda value: f"the date or time {value}",
        "Times are counted from the start of a run.", 'Write a number, or for example "20 ms".',
    ),
    (
        lambda _, value: isinstance(value, float) and not math.isfinite(value),
        "be a finite number", str, "Nothing can be computed with it.", "Write a number.",
    ),
    (
        lambda _, value: isinstance(value, int) and abs(value) > _LARGEST_INTEGER,
        f"be an integer of at most {_LARGEST_INTEGER}", lambda _: "a larger one",
        "Larger integers are not kept exactly.", "Write a float, for example 1e20.",
    ),
    (
        lambda _, value: isinstance(value, str) and len(value) > MAX_TEXT_CHARACTERS,
        f"have at most {MAX_TEXT_CHARACTERS} characters", lambda value: str(len(value)),
        "No name, quantity or formula is longer.", "Shorten it.",
    ),
)  # fmt: skip
