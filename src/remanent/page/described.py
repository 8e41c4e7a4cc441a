"""Names, units, symbols and texts of what a page shows."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from inspect import getdoc
from typing import Any, Final

from remanent._checks import Rule
from remanent.models.variable_text import VariableText
from remanent.page.ranges import allowed_range, limits_of, range_of
from remanent.results.schema import describe, is_described

#: Units of observables that no table of results has.
_FURTHER_OBSERVABLES: Final[Mapping[str, tuple[str, str]]] = {
    "drive_power": (r"\dot W", "power of the magnetic load"),
    "dissipated_power": (r"\dot D", "dissipated power"),
    "heat_flow": (r"\dot Q", "heat given to the surroundings per time"),
    "entropy_flow": (r"\dot s_e", "entropy given to the surroundings per time"),
    "entropy_production": (r"\dot s_i", "entropy produced per time"),
}
#: The heading of the numbers in a docstring, and what begins an entry there.
_HEADING: Final = re.compile(r"^Parameters\n-+\n(.*?)(?=^\w[\w ]*\n-+\n|\Z)", re.M | re.S)
#: A formula in a docstring.
_FORMULA: Final = re.compile(r":math:`([^`]+)`")
_ENTRY: Final = re.compile(r"^(\w[\w, ]*?)(?: :.*)?\n((?:[ ]+.*\n?|\n)+)", re.M)


def described(name: str, own: Mapping[str, VariableText]) -> dict[str, str]:
    """Name, symbol, unit and meaning of a variable or a number.

    Parameters
    ----------
    name : str
        Its dotted name.
    own : mapping of name to VariableText
        What a system of one's own says of its variables.
    """
    if name in _FURTHER_OBSERVABLES and name not in own:
        symbol, text = _FURTHER_OBSERVABLES[name]
        return {"name": name, "symbol": symbol, "unit": "1", "text": text}
    if is_described(name, own):
        row = describe(name, own)
        return {"name": name, "symbol": row.symbol, "unit": row.units, "text": row.long_name}
    words = name.rpartition(".")[2].replace("_", " ")
    return {"name": name, "symbol": rf"\mathrm{{{words}}}", "unit": "1", "text": words}


def described_number(
    name: str,
    value: float,
    rule: Rule,
    own: Mapping[str, VariableText],
    owner: type | None,
    text_name: str | None = None,
) -> dict[str, Any]:
    """A number with all that a slider has to know of it.

    Parameters
    ----------
    name : str
        Its dotted name.
    value : float
    rule : Rule
        What it has to satisfy.
    own : mapping of name to VariableText
        What a system of one's own says of its variables.
    owner : type, optional
        The class of which it is a field.
    text_name : str, optional
        The name under which it is described, where that is another.
    """
    span = allowed_range(range_of(name, value, None if owner is None else owner.__name__), rule)
    return {
        **described(text_name or name, own),
        "name": name,
        "help": "" if owner is None else field_help(owner, name.rpartition(".")[2]),
        "value": value,
        "min": span.low,
        "max": span.high,
        "scale": span.scale,
        "rule": f"It must {rule.must}. {rule.why} {rule.fix}",
        "limits": limits_of(rule),
    }


def summary_of(cls: type) -> str:
    """The first sentence of what a class says of itself."""
    return plain_text((getdoc(cls) or cls.__name__).partition("\n")[0])


def field_help(cls: type, name: str) -> str:
    """What a class says of one of its fields, in one line; nothing where it says nothing."""
    return _field_helps(cls).get(name, "")


@cache
def _field_helps(cls: type) -> dict[str, str]:
    found = _HEADING.search(getdoc(cls) or "")
    if found is None:
        return {}
    return {
        name.strip(): plain_text(text)
        for names, text in _ENTRY.findall(found[1])
        for name in names.split(",")
    }


def plain_text(text: str) -> str:
    """A text of a docstring on one line, without its marks; formulas without TeX's."""
    words = _FORMULA.sub(lambda math: re.sub(r"[\\{}]", "", math[1]), " ".join(text.split()))
    words = re.sub(r":\w+:`~?(?:[\w.]*\.)?(\w+)`", r"\1", words)
    return words.replace("``", "").replace("`", "")
