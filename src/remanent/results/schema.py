"""Every variable of every Dataset, with its unit, symbol and meaning.

The table itself is ``variables.csv`` beside this file, a line for each variable.  Everything
inside the package is dimensionless: lengths of time in ``sqrt(rho L^2 / mu)``, stresses in
``mu``, energies in ``mu`` per reference volume.  Units follow UDUNITS, so ``"1"`` is
dimensionless and ``"rad"`` is an angle; as time has no unit, an angular frequency is in
``rad`` (radians per unit of tau).
"""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np

from remanent._errors import InputError, shortened_repr
from remanent._status import Status
from remanent.models.variable_text import VariableText

__all__ = [
    "DESCRIPTIONS",
    "FLAG_MEANINGS",
    "Description",
    "QuantityKind",
    "describe",
    "flag_attributes",
    "is_described",
]


class QuantityKind(Enum):
    """How a quantity turns to SI; see :mod:`remanent.results.si`."""

    NONE = "none"
    TIME = "time"
    RATE = "rate"
    SQUARED_RATE = "square of a rate"
    FREQUENCY = "frequency"
    LOAD = "load"
    ROOT_LOAD = "root of load"
    STRESS = "stress"
    OWN_FIELD = "own field"
    COUPLING = "thermoelastic coupling"
    VISCOSITY = "viscosity"
    ENERGY_DENSITY = "energy density"
    ENTROPY_DENSITY = "entropy density"
    TEMPERATURE = "temperature"
    SHEAR_MODULUS = "shear modulus"
    DENSITY = "density"
    REMANENCE = "remanence"


@dataclass(frozen=True)
class Description:
    """What a variable of a Dataset is: one row of the table.

    Attributes
    ----------
    name : str
        The name in the API and in files.
    units : str
        UDUNITS text; ``"1"`` where dimensionless.
    long_name : str
        The meaning in a few words, for axes.
    symbol : str
        LaTeX for use between dollar signs.
    dims : tuple of str
        The dimension a variable has of its own, beside those of ``over``; empty
        where it has none (one value per trajectory) or is a coordinate.
    kind : Kind
        How it turns to SI.
    """

    name: str
    units: str
    long_name: str
    symbol: str
    dims: tuple[str, ...] = ()
    kind: QuantityKind = QuantityKind.NONE

    def attributes(self) -> dict[str, str]:
        """Attributes ``units``, ``long_name`` and ``symbol`` of a Dataset variable."""
        return {"units": self.units, "long_name": self.long_name, "symbol": self.symbol}


#: The file with the table.
_TABLE_FILE_NAME: Final = "variables.csv"


def _read_table() -> dict[str, Description]:
    """The rows of the file by name; ``#`` begins a comment, blanks after commas align it."""
    text = Path(__file__).with_name(_TABLE_FILE_NAME).read_text(encoding="utf-8")
    lines = (line for line in text.splitlines() if not line.startswith("#"))
    return {
        row["name"]: Description(
            row["name"],
            row["units"],
            row["long_name"],
            row["symbol"],
            tuple(row["dims"].split()),
            QuantityKind(row["kind"] or QuantityKind.NONE),
        )
        for row in csv.DictReader(lines, skipinitialspace=True)
    }


#: Every row by name.
DESCRIPTIONS: Final[Mapping[str, Description]] = MappingProxyType(_read_table())

#: Dimensions of points at which other rows have a value, ``fold_m`` for example.
_POINT_PREFIX_MEANINGS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "special": "special point",
        "fold": "fold",
        "snap": "dynamic threshold",
        "branch_point": "branch point",
    }
)

#: Variables whose values are numbered meanings, with the meanings in order of code from 0.
FLAG_MEANINGS: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    dict.fromkeys(("status", "resonance_status"), tuple(code.meaning for code in sorted(Status)))
)


def describe(name: str, own: Mapping[str, VariableText] = MappingProxyType({})) -> Description:
    """Look a variable up.

    Besides the rows themselves, the table describes by rule:

    * ``initial.<state>``, the initial value of a state variable;
    * ``special_<name>``, ``fold_<name>``, ``branch_point_<name>``, ``snap_<name>``, a row at a
      special point of a branch, at a fold of equilibria, where branches of them cross, at the
      dynamic threshold of a snap;
    * ``dissipation.0.eta`` and the like, the row without the number, and ``loads.0``, an entry
      of the row;
    * ``<name>_error``, the estimated error of a row, in the same unit;
    * any other dotted name, a dimensionless field of the user's own part.

    Of a system of the user's own, names that it has come first, and rows speak of its observable
    in place of the thickness stretch.

    Parameters
    ----------
    name : str
        Name of a variable or coordinate.
    own : mapping of name to VariableText, optional
        What a system of the user's own says of its variables.

    Returns
    -------
    Description

    Raises
    ------
    InputError
        Nothing in the table describes that name.

    Examples
    --------
    >>> describe("omega").units
    'rad'
    >>> describe("dissipation.0.eta").long_name
    'viscosity (0)'
    >>> describe("amplitude_error").long_name
    'estimated error: thickness stretch amplitude'
    """
    if own:
        return _describe_own_system(name, own)
    if name in DESCRIPTIONS:
        return DESCRIPTIONS[name]
    for rule in (
        _describe_initial,
        _describe_prefixed,
        _describe_numbered,
        _describe_error,
        _describe_own_part,
    ):
        description = rule(name)
        if description is not None:
            return description
    raise InputError(
        "name",
        must="be a variable of the schema",
        got=shortened_repr(name),
        why="Every variable of a Dataset has a unit, a meaning and a symbol.",
        fix="Add a line to remanent/results/variables.csv.",
    )


def is_described(name: str, own: Mapping[str, VariableText] = MappingProxyType({})) -> bool:
    """Whether the table describes a name, by a row or by rule."""
    try:
        describe(name, own)
    except InputError:
        return False
    return True


def flag_attributes(name: str) -> dict[str, object]:
    """CF attributes ``flag_values`` and ``flag_meanings`` of a flag variable, else nothing."""
    if name not in FLAG_MEANINGS:
        return {}
    meanings = FLAG_MEANINGS[name]
    return {
        "flag_values": np.arange(len(meanings), dtype=np.int8),
        "flag_meanings": " ".join(meanings),
    }


def _describe_initial(name: str) -> Description | None:
    base = name.removeprefix("initial.")
    if base == name or (base not in DESCRIPTIONS and _describe_numbered(base) is None):
        return None
    row = describe(base)
    return replace(
        row, name=name, long_name=f"initial {row.long_name}", symbol=f"{row.symbol}(0)", dims=()
    )


def _describe_prefixed(name: str) -> Description | None:
    prefix = next((one for one in _POINT_PREFIX_MEANINGS if name.startswith(f"{one}_")), None)
    if prefix is None:
        return None
    row = describe(name.removeprefix(f"{prefix}_"))
    return replace(
        row,
        name=name,
        long_name=f"{row.long_name} at the {_POINT_PREFIX_MEANINGS[prefix]}",
        dims=(prefix,),
    )


def _describe_numbered(name: str) -> Description | None:
    entry = re.fullmatch(r"(\w+)\.(\d+)", name)
    if entry is not None and entry[1] in DESCRIPTIONS:
        row = DESCRIPTIONS[entry[1]]
        return replace(
            row, name=name, long_name=f"{row.long_name} ({entry[2]})",
            symbol=f"{row.symbol.removesuffix('_i')}_{{{entry[2]}}}",
        )  # fmt: skip
    match = re.fullmatch(r"(\w+)\.(\d+)\.(\w+)", name)
    if match is None or f"{match[1]}.{match[3]}" not in DESCRIPTIONS:
        return None
    row = DESCRIPTIONS[f"{match[1]}.{match[3]}"]
    index = f"^{{({match[2]})}}" if "_" in row.symbol else f"_{{{match[2]}}}"
    return replace(
        row, name=name, long_name=f"{row.long_name} ({match[2]})", symbol=row.symbol + index
    )


def _describe_error(name: str) -> Description | None:
    base = name.removesuffix("_error")
    if base == name:
        return None
    row = DESCRIPTIONS.get(base) or _describe_prefixed(base)
    if row is None:
        return None
    return replace(
        row,
        name=name,
        long_name=f"estimated error: {row.long_name}",
        symbol=rf"\delta({row.symbol})",
    )


def _describe_own_part(name: str) -> Description | None:
    part, *rest = name.split(".")
    if not rest or part not in {"material", "dissipation", "heat", "magnet", "initial", "drive"}:
        return None
    words = name.replace(".", " ").replace("_", " ")
    last = [one for one in (part, *rest) if not one.isdigit()][-1]
    index = f"_{{{rest[-1]}}}" if rest[-1].isdigit() else ""
    return Description(name, "1", words, rf"\mathrm{{{last.replace('_', ' ')}}}{index}")


#: Rows of which a user gives the unit, and no name.
_ROWS_IN_OWN_UNITS: Final = frozenset({"time", "energy"})
#: What rows say of an actuator's observable, and its symbol.
_ACTUATOR_OBSERVABLE: Final = ("thickness stretch", r"\lambda_3")


def _describe_own_system(name: str, own: Mapping[str, VariableText]) -> Description:
    """A variable of a result of a system of the user's own."""
    if name in own and name not in _ROWS_IN_OWN_UNITS:
        return _own_row(name, own[name])
    for prefix, words in (("initial.", "initial {}"), *_POINT_PREFIXES_WITH_WORDS):
        base = name.removeprefix(prefix)
        if base != name and _is_own(base.removesuffix("_error"), own):
            row = _describe_own_system(base, own)
            dims = () if prefix == "initial." else (prefix.removesuffix("_"),)
            return replace(row, name=name, long_name=words.format(row.long_name), dims=dims)
    load, _, field = name.partition(".")
    if field and load in own:
        row = describe(field)
        words = row.long_name.replace("magnetic ", "")
        units = {key: text.units for key, text in own.items()} | {"load": own[load].units}
        return replace(
            row,
            name=name,
            long_name=f"{words} of the {own[load].long_name}",
            units=_units_of_kinds(units).get(row.kind, row.units),
            symbol=rf"{row.symbol}_{{{own[load].symbol}}}",
            kind=QuantityKind.NONE,
        )
    base = name.removesuffix("_error")
    if base != name and base in own:
        row = _own_row(base, own[base])
        return replace(
            row,
            name=name,
            long_name=f"estimated error: {row.long_name}",
            symbol=rf"\delta({row.symbol})",
        )
    return _in_words_of_system(describe(name), own)


#: The symbol of a load that has no other.
_NO_SYMBOL_OF_LOAD: Final = r"\mathrm{load}"


def _is_own(name: str, own: Mapping[str, VariableText]) -> bool:
    """Whether a name is that of one's own variable, or of a field of the drive of a load."""
    load, _, field = name.partition(".")
    return name in own or (load in own and field in DESCRIPTIONS)


#: What results put before names, and how the words then read.
_POINT_PREFIXES_WITH_WORDS: Final = tuple(
    (f"{prefix}_", f"{{}} at the {words}") for prefix, words in _POINT_PREFIX_MEANINGS.items()
)


def _own_row(name: str, text: VariableText) -> Description:
    return Description(name, text.units, text.long_name, text.symbol, ("time",))


def _units_of_kinds(units: Mapping[str, str]) -> dict[QuantityKind, str]:
    """Units of rows by their kind, where units of time, energy and the load are given."""
    time = units.get("time", "1")
    per_time = {} if time == "1" else {
        QuantityKind.RATE: f"{time}-1",
        QuantityKind.SQUARED_RATE: f"{time}-2",
        QuantityKind.FREQUENCY: f"rad {time}-1",
    }  # fmt: skip
    return {
        QuantityKind.ENERGY_DENSITY: units.get("energy", "1"),
        QuantityKind.TIME: time,
        QuantityKind.LOAD: units.get("load", "1"),
        **per_time,
    }


def _in_words_of_system(row: Description, own: Mapping[str, VariableText]) -> Description:
    """A row of the table in the words and units of a system of the user's own."""
    words, symbol = _ACTUATOR_OBSERVABLE
    observable, units = own.get("observable"), row.units
    long_name = row.long_name.replace(" per reference volume", "").replace("magnetic load", "load")
    if observable is not None and words in long_name:
        long_name = long_name.replace(words, observable.long_name)
        row = replace(row, symbol=row.symbol.replace(symbol, observable.symbol))
        units = observable.units
    of_load = own["load"].symbol if "load" in own else _NO_SYMBOL_OF_LOAD
    if row.name.split("_")[-1] == "m" and of_load != _NO_SYMBOL_OF_LOAD:
        row = replace(row, symbol=of_load)
    own_units = _units_of_kinds({name: text.units for name, text in own.items()})
    return replace(
        row,
        long_name=long_name,
        units=own_units.get(row.kind, units),
        kind=QuantityKind.NONE,
    )
