"""What a notebook shows of a system, a part or a drive: formulas and numbers, as Markdown.

Notebooks of every kind typeset Markdown with its formulas, in the browser, in an editor and when
they are converted.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Any, Final

from remanent._checks import Rule
from remanent.derivation.letters import letter
from remanent.derivation.shown import LONGEST_FORMULA, formulas, letters_of
from remanent.models.drives.base import Drive
from remanent.models.scaling import Scales
from remanent.models.system import System
from remanent.results.schema import DESCRIPTIONS, describe, is_described

#: Longest formula that shares its line with others, in characters of LaTeX, and how many share it.
_LONGEST_SHORT_FORMULA: Final = 80
_SHORT_FORMULAS_PER_LINE: Final = 3
#: Most rows of a table of times and loads.
_MOST_ROWS: Final = 8
#: What stands in a table that would end a cell, and tags.
_ESCAPES: Final = str.maketrans({"|": r"\vert ", "<": r"\lt ", ">": r"\gt ", "$": ""})
#: Prefixes of the fields of parts by themselves, under which the table of variables has them.
_PART_PREFIXES: Final = ("", "material.", "dissipation.", "heat.", "magnet.")


def markdown(value: Any) -> str:
    r"""Formulas and numbers of a system, a part of a model or a drive.

    Parameters
    ----------
    value : System, Part or Drive

    Returns
    -------
    str
        Markdown with formulas between dollar signs.

    Examples
    --------
    >>> from remanent.models.drives.waves import Constant
    >>> print(markdown(Constant(0.2)))
    **Constant**
    <BLANKLINE>
    $$m(\tau) = m$$
    <BLANKLINE>
    | | number | value | unit | meaning |
    |---|---|---:|---|---|
    | $m$ | `m` | 0.2 | 1 | magnetic load |
    """
    blocks = [f"**{type(value).__name__}**", *_formula_blocks(value), _table_of_numbers(value)]
    if isinstance(value, Drive):
        blocks += _period_and_pieces(value)
    scales = getattr(value, "scales", None)
    if isinstance(scales, Scales):
        blocks.append(_units_in_si(scales))
    return "\n\n".join(block for block in blocks if block)


def _formula_blocks(value: Any) -> Iterator[str]:
    """Formulas, those that are short several to a line."""
    short: list[str] = []
    for text in formulas(value):
        if len(text) <= _LONGEST_SHORT_FORMULA:
            short.append(text)
        elif len(text) <= LONGEST_FORMULA:
            yield f"$${text}$$"
        elif isinstance(value, System):
            yield "An equation of motion is too long to be shown here; `rm.equations` has it."
        else:
            yield f"The formula of ${text.partition(' = ')[0]}$ is too long to be shown here."
    for first in range(0, len(short), _SHORT_FORMULAS_PER_LINE):
        together = r", \qquad ".join(short[first : first + _SHORT_FORMULAS_PER_LINE])
        yield f"$${together}$$"


def _table_of_numbers(value: Any) -> str:
    """A row for each numeric field: letter, name, value, unit and meaning."""
    rules = value.parameter_rules()
    rows = [
        f"| ${symbol}$ | `{name}` | {number:.10g} | {unit} | {meaning} |"
        for name, number in value.parameter_values().items()
        for symbol, unit, meaning in [_described(value, name, rules[name])]
    ]
    head = ["| | number | value | unit | meaning |", "|---|---|---:|---|---|"]
    return "\n".join([*head, *rows]) if rows else ""


def _described(value: Any, name: str, rule: Rule) -> tuple[str, str, str]:
    """Letter, unit and meaning of a number, without what a table would take for its own."""
    own = value.variable_texts() if isinstance(value, System) else {}
    if name in own:
        text = own[name]
        symbol, unit, meaning = (
            one.translate(_ESCAPES) for one in (text.symbol, text.units, text.long_name)
        )
        return symbol, unit, meaning
    symbol = letters_of(value).get(name) or letter(name)
    full = next((p + name for p in _PART_PREFIXES if p + name in DESCRIPTIONS), name)
    row = describe(full) if is_described(full) else None
    if row is None or ("." in full and row.long_name == re.sub(r"[._]", " ", full)):
        # The table has no words for it; its rule has.
        return symbol, "1", rule.why.removeprefix("It is ").rstrip(".")
    return symbol, row.units, row.long_name


def _period_and_pieces(drive: Drive) -> Iterator[str]:
    """After which time the load repeats itself; instants and loads of one in pieces."""
    if drive.period is not None:
        yield f"The load repeats itself after {drive.period:.6g} in $\\tau$."
    times, loads = getattr(drive, "times", None), getattr(drive, "loads", None)
    if times is None or loads is None:
        return
    shown = list(zip(times, loads, strict=True))[:_MOST_ROWS]
    rows = [f"| {time:.6g} | {load:.6g} |" for time, load in shown]
    yield "\n".join([r"| $\tau_i$ | $m_i$ |", "|---:|---:|", *rows])
    if len(times) > len(shown):
        yield f"These are the first {len(shown)} of {len(times)} instants."


def _units_in_si(scales: Scales) -> str:
    """What one dimensionless unit is, of time, of stress and of the load."""
    sizes = [(r"\tau", "time", scales.time_unit, "s"), ("S", "stress", scales.shear_modulus, "Pa")]
    if scales.remanence is not None:
        sizes.append(("m", "magnetic load", scales.flux_density_unit, "T"))
    rows = [
        f"| ${symbol} = 1$ | {meaning} | {_with_prefix(size, unit)} |"
        for symbol, meaning, size, unit in sizes
    ]
    return "\n".join(["| | one unit of | is |", "|---|---|---:|", *rows])


def _with_prefix(size: float, unit: str) -> str:
    """A size with a unit whose prefix leaves one to three digits before the point."""
    power = min(max(math.floor(math.log10(size) / 3), -3), 3)
    return f"{size / 1000.0**power:.4g} {'nµm kMG'[power + 3].strip()}{unit}"
