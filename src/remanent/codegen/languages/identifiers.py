"""Names of a field as identifiers of a language."""

from __future__ import annotations

import re
from collections.abc import Iterable
from itertools import count

from remanent.codegen.languages.language import Language

#: Longest identifier, short of the 63 characters of MATLAB and Fortran.
_LONGEST = 50


def identifiers_of(
    names: Iterable[str], language: Language, taken: Iterable[str] = ()
) -> dict[str, str]:
    """An identifier for each name, as near to it as the language allows.

    Dots become underscores.  What is a reserved word, or is taken, gets a number after it.

    Parameters
    ----------
    names
        Names of a field, each different.
    language
        Whose identifiers they become.
    taken
        Identifiers that are in use already.
    """
    used = {_compared(one, language) for one in (*language.reserved_words, *taken)}
    found: dict[str, str] = {}
    for name in names:
        plain = re.sub(r"\W", "_", name, flags=re.ASCII)[:_LONGEST]
        if not re.match(r"[A-Za-z]", plain):
            plain = f"x{plain}"
        tried = (plain if k == 0 else f"{plain}_{k}" for k in count())
        found[name] = next(one for one in tried if _compared(one, language) not in used)
        used.add(_compared(found[name], language))
    return found


def _compared(identifier: str, language: Language) -> str:
    return identifier if language.has_case else identifier.lower()
