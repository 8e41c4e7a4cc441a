"""What is wrong with a study file: each fault by itself, all of them in one message."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any, Final, TypeVar

from remanent._errors import InputError, RemanentError, shortened_repr

#: Where something stands in a file: the names of tables and keys, and the numbers of entries.
KeyPath = tuple[str | int, ...]
Key = TypeVar("Key", str, int)
Value = TypeVar("Value")

#: Tables within a table that have a heading of their own in a message.
_INNER_TABLES: Final = frozenset({("actuator", "si"), ("over", "sobol")})
#: Tables at the top of a file.
_TABLES: Final = frozenset({"actuator", "system", "drive", "over", "options"})
#: Longest rule and longest remedy that a line shows; some list the names that there are.
_MAX_CHARACTERS: Final = 900
#: Most faults that one message lists.
_MAX_LISTED: Final = 40
#: Words of remedies that speak of calls, and those for files.
_WORDS_OF_FILES: Final = (
    (", or pass a pint quantity", ""), (" to Actuator.from_si", " in [actuator.si]"),
    ("Pass remanence=", "Write remanence = "), ("Pass ", "Write "),
)  # fmt: skip
#: A mapping in a call, as in ``parameters={'delta': ...}``.
_NAMED_VALUE: Final = re.compile(r"(\w+)=\{'([\w.]+)': \.\.\.\}")
#: The name of an argument with the entry in brackets, as in ``over['omega']``.
_ENTRY_PATTERN: Final = re.compile(r"(\w+)\[(['\"]?)(.*?)\2\]")


@dataclass(frozen=True)
class Fault:
    """One fault.

    Attributes
    ----------
    path : KeyPath
        Where it is.
    must, got, why, fix : str
        As for :class:`~remanent.InputError`: the rule, what was found, the reason, the remedy.
    """

    path: KeyPath
    must: str
    got: str
    why: str
    fix: str

    @property
    def text(self) -> str:
        """One line that names table and key."""
        must, fix = (_shortened(part) for part in (self.must, self.fix))
        return f"{place(self.path)}: must {must}; got {self.got}. {self.why} {fix}"

    def below(self, *start: str | int) -> Fault:
        """The fault as it is seen from further up in the file."""
        return Fault((*start, *self.path), self.must, self.got, self.why, self.fix)


class FaultsError(ValueError):
    """What a table is refused for; those who read the table above collect it.

    It has no faults where others that are told already leave it open what the table says.
    """

    def __init__(self, faults: Iterable[Fault]) -> None:
        self.faults = tuple(faults)
        super().__init__("; ".join(fault.text for fault in self.faults))


def read_each(entries: Mapping[Key, Any], read: Callable[[Key, Any], Value]) -> dict[Key, Value]:
    """What each entry of a table or a list reads as.

    Parameters
    ----------
    entries : mapping of str or int to object
    read : callable
        Takes a key and its value, and raises `FaultsError` where that is not sound.

    Raises
    ------
    FaultsError
        The faults of all entries.
    """
    values: dict[Key, Value] = {}
    faults: list[Fault] = []
    for key, entry in entries.items():
        try:
            values[key] = read(key, entry)
        except FaultsError as error:
            faults += [fault.below(key) for fault in error.faults]
    if len(values) < len(entries):
        raise FaultsError(faults)
    return values


class StudyFileError(RemanentError, ValueError):
    """A study file is refused.

    Parameters
    ----------
    file : str
        Its name.
    faults : sequence of Fault
        At least one.
    """

    def __init__(self, file: str, faults: Sequence[Fault]) -> None:
        self.file, self.faults = file, tuple(faults)
        count = f"{len(faults)} faults" if len(faults) > 1 else "a fault"
        lines = [fault.text for fault in faults[:_MAX_LISTED]]
        if len(faults) > _MAX_LISTED:
            lines.append(f"and {len(faults) - _MAX_LISTED} more")
        super().__init__("\n".join([f"{file} has {count}:", *lines]))


def place(path: KeyPath) -> str:
    """Where something stands, in words: ``[drive] omega``, ``[actuator] dissipation.0.eta``."""
    if not path:
        return "the file"
    head = 2 if path[:2] in _INNER_TABLES else 1
    if path[0] not in _TABLES:
        return _shown_key(path)
    table, key = ".".join(map(str, path[:head])), _shown_key(path[head:])
    return f"[{table}] {key}" if key else f"[{table}]"


def shown(value: object) -> str:
    """A value about as the file has it, on one short line."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return f"a table with {', '.join(map(str, value)) or 'nothing in it'}"[:80]
    return shortened_repr(value)


def fault_of(error: InputError, table: Mapping[str, Any], title: str = "") -> Fault:
    """What a constructor said against the values of a table.

    Parameters
    ----------
    error : InputError
    table : mapping
        The table, by whose keys the name in the error is found.
    title : str
        Name of the table, which the error may have in place of a key.
    """
    path = _path_in(error.name, table, title)
    return Fault(path, error.must, _shortened(str(error.got), 200), error.why, in_file(error.fix))


def in_file(remedy: str) -> str:
    """A remedy that speaks of a call, as one of a file."""
    for called, written in _WORDS_OF_FILES:
        remedy = remedy.replace(called, written)
    return _NAMED_VALUE.sub(r'\1 = { "\2" = ... }', remedy)


def unknown_key_fault(key: str, known: Sequence[str], table: str, value: object) -> Fault:
    """A key that a table does not have, with the one that was probably meant."""
    return Fault(
        (key,),
        f"be a key of {table}",
        shown(value),
        "Unknown keys are refused so that a misspelling does not go unnoticed.",
        meant(key, known)
        + (f"Write one of its keys: {', '.join(known)}." if known else "Leave it out."),
    )


def meant(name: object, known: Sequence[str]) -> str:
    """A question after the name that was probably meant; nothing where none is close."""
    closest = get_close_matches(name, known, n=1) if isinstance(name, str) else []
    return f"Did you mean `{closest[0]}`? " if closest else ""


def first_of_each_place(faults: Iterable[Fault]) -> list[Fault]:
    """The faults without those that say something more of a place that has one already."""
    chosen: dict[KeyPath, Fault] = {}
    for fault in faults:
        above = (fault.path[:k] for k in range(len(fault.path) + 1))
        if not any(path in chosen for path in above):
            chosen[fault.path] = fault
    return list(chosen.values())


def _path_in(name: str, table: Mapping[str, Any], title: str) -> KeyPath:
    """Where a name that an error has stands in a table."""
    entry = _ENTRY_PATTERN.fullmatch(name)
    if entry is not None:
        return (entry[1], entry[3]) if entry[1] != title else (entry[3],)
    if name == title:
        return ()
    if name not in table:
        for key, content in table.items():
            if isinstance(content, Mapping) and name in content:
                return (key, name)
    return (name,)


def _shown_key(path: KeyPath) -> str:
    """Keys with dots between them; those with other characters are in quotes."""
    parts = (str(part) for part in path)
    return ".".join(part if part.isprintable() else repr(part) for part in parts)[:120]


def _shortened(text: str, length: int = _MAX_CHARACTERS) -> str:
    line = " ".join(text[: 10 * length].split())
    return line if len(line) <= length else f"{line[: length - 3]}..."
