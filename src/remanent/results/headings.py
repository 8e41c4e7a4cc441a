"""What the headings of a stranger's table mean."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from types import MappingProxyType
from typing import Final

from remanent._errors import shortened_repr
from remanent.results.schema import DESCRIPTIONS

__all__ = [
    "ABSCISSA_NAMES",
    "Heading",
    "canonical_name",
    "measurable_names",
    "suggestions",
    "variable_name",
]

#: What a measurement runs along.
ABSCISSA_NAMES: Final = ("time", "omega")
#: Variables of a response; those of a history lie along ``time`` in the table of variables.
_RESPONSE_NAMES: Final = ("amplitude", "maximum", "minimum")
#: Other words for some variables.
_SYNONYMS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "t": "time",
        "tau": "time",
        "f": "omega",
        "freq": "omega",
        "frequency": "omega",
        "angular_frequency": "omega",
        "thickness": "thickness_stretch",
        "thickness_rate": "thickness_stretch_rate",
    }
)
#: Variables of which a synonym is a length, so that it says something only with its unit.
_LENGTHS: Final = frozenset({"thickness", "thickness_rate"})
#: Endings of the names of standard deviations.
_ERROR_SUFFIX: Final = "_error"
#: Longest heading that is read, in characters.
_MAX_HEADING_CHARACTERS: Final = 200
#: Brackets in which a unit may stand.
_BRACKETS: Final[Mapping[str, str]] = MappingProxyType({"]": "[", ")": "(", "}": "{"})


@dataclass(frozen=True)
class Heading:
    """A heading: as it stands, without its unit, and the unit.

    Attributes
    ----------
    text : str
        As it stands in the table.
    words : str
        Without its unit.
    unit : str or None
        What stands in brackets at its end, or after a stroke: ``Time [ms]``, ``Time / ms``.
    has_unit : bool
        Whether it has a unit, or its values have one.
    """

    text: str
    words: str
    unit: str | None
    has_unit: bool

    @classmethod
    def of(cls, heading: object, *, has_unit: bool = False) -> Heading:
        """Split a heading; one that is too long is not read."""
        text = str(heading)[: _MAX_HEADING_CHARACTERS + 1].strip()
        if len(text) > _MAX_HEADING_CHARACTERS:
            return cls(shortened_repr(text), "", None, False)
        opening = text.find(_BRACKETS[text[-1]]) if text and text[-1] in _BRACKETS else -1
        if opening > 0:
            unit = text[opening + 1 : -1].strip()
            return cls(text, text[:opening].strip(), unit, unit not in {"", "1"})
        words, stroke, unit = (part.strip() for part in text.partition("/"))
        if stroke and unit and words:
            return cls(text, words, unit, unit != "1")
        return cls(text, text, None, has_unit)

    @property
    def spellings(self) -> set[str]:
        """What a caller may call it by."""
        return {self.text, self.words, self.canonical}

    @property
    def canonical(self) -> str:
        """In small letters, with underscores, as names of variables are written."""
        return canonical_name(self.words)

    @property
    def meaning(self) -> str | None:
        """The variable that it means by itself; None where it means none."""
        return variable_name(self.canonical, has_unit=self.has_unit)


def canonical_name(words: str) -> str:
    """Words in small letters with underscores, as names of variables are written."""
    return "_".join(words.replace("-", " ").replace("_", " ").lower().split())


def variable_name(canonical: str, *, has_unit: bool) -> str | None:
    """The variable that a name means, ``omega_error`` for ``frequency_error``; or None."""
    base = canonical.removesuffix(_ERROR_SUFFIX)
    suffix = canonical[len(base) :]
    if base in _LENGTHS and not has_unit:
        return None
    name = _SYNONYMS.get(base, base) + suffix
    return name if name in measurable_names() else None


def measurable_names() -> set[str]:
    """Names of the variables of a measurement, and of their standard deviations."""
    histories = {name for name, row in DESCRIPTIONS.items() if "time" in row.dims}
    bases = {*histories, *_RESPONSE_NAMES, *ABSCISSA_NAMES}
    return bases | {f"{name}{_ERROR_SUFFIX}" for name in bases}


def suggestions(headings: Iterable[Heading]) -> str:
    """What some headings can mean, as sentences; nothing where nothing is near."""
    known = sorted({*measurable_names(), *_SYNONYMS})
    told = []
    for heading in headings:
        if heading.meaning is not None:  # another column was chosen for it
            continue
        near = get_close_matches(heading.canonical, known, n=1, cutoff=0.7)
        if heading.canonical in _LENGTHS:
            told.append(f"{heading.text!r} needs its unit, as in '{heading.words} [mm]'.")
        elif near:
            told.append(f"Did you mean {near[0]!r} by {heading.text!r}?")
    return " ".join(told)
