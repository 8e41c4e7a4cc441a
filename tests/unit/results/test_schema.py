"""Laws of the table of variables."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.mathtext import MathTextParser

from remanent._errors import InputError
from remanent._status import Status
from remanent.results import schema
from remanent.results.schema import (
    DESCRIPTIONS,
    FLAG_MEANINGS,
    QuantityKind,
    describe,
    flag_attributes,
)

UNITS = {"1", "rad", "K", "K-1"}


@pytest.mark.parametrize("name", DESCRIPTIONS)
def test_every_row_has_unit_meaning_and_symbol(name: str) -> None:
    """Every variable has a unit of the house, a meaning in words and a LaTeX symbol."""
    row = DESCRIPTIONS[name]
    assert row.name == name
    assert row.units in UNITS
    assert re.fullmatch(r"[A-Za-z0-9 ,-]+", row.long_name)
    assert row.symbol


def test_every_name_has_one_line() -> None:
    """No name stands twice in the file, and no line has a column too few or too many."""
    text = Path(str(schema.__file__)).with_name("variables.csv").read_text("utf-8")
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    rows = list(csv.reader(lines, skipinitialspace=True))
    assert rows[0] == ["name", "units", "kind", "dims", "symbol", "long_name"]
    assert {len(row) for row in rows} == {6}
    assert [row[0] for row in rows[1:]] == list(DESCRIPTIONS)


@pytest.mark.parametrize("name", DESCRIPTIONS)
def test_every_symbol_can_be_typeset(name: str) -> None:
    """Every symbol is mathtext that matplotlib can set."""
    width, height, *_ = MathTextParser("path").parse(f"${DESCRIPTIONS[name].symbol}$")
    assert width > 0
    assert height > 0


def test_symbols_tell_the_coordinates_of_one_figure_apart() -> None:
    """Quantities that share a figure do not share a symbol."""
    motion = ["thickness_stretch", "thickness_stretch_rate", "stretch", "time", "energy"]
    forced = ["omega", "amplitude", "resonance", "b", "c", "temperature", "prestress"]
    together = motion + forced
    symbols = [DESCRIPTIONS[name].symbol for name in together]
    assert len(set(symbols)) == len(symbols)


def test_frequencies_and_temperatures_have_their_units() -> None:
    """Kind and unit agree."""
    assert {QuantityKind.TEMPERATURE, QuantityKind.FREQUENCY} <= {
        row.kind for row in DESCRIPTIONS.values()
    }
    for row in DESCRIPTIONS.values():
        assert (row.units == "K") == (row.kind is QuantityKind.TEMPERATURE), row.name
        if row.kind is QuantityKind.FREQUENCY:
            assert row.units == "rad", row.name


def test_an_error_has_the_unit_of_what_it_bounds() -> None:
    """`<name>_error` is described by rule, in the unit of `<name>`."""
    found = describe("resonance_error")
    assert (found.units, found.kind) == ("rad", QuantityKind.FREQUENCY)
    assert "resonance frequency" in found.long_name


@pytest.mark.parametrize(
    ("name", "units"),
    [
        ("material.jm", "1"),
        ("material.alpha_1", "1"),
        ("dissipation.0.eta", "1"),
        ("dissipation.1.relaxation_time", "1"),
        ("initial.stretch", "1"),
        ("initial.body_temperature", "K"),
    ],
)
def test_dotted_names_are_described(name: str, units: str) -> None:
    """Fields of the user's parts are described under the user's names."""
    found = describe(name)
    assert found.name == name
    assert found.units == units


def test_numbered_parts_have_different_symbols() -> None:
    """Two dashpots are told apart by their number."""
    assert describe("dissipation.0.eta").symbol != describe("dissipation.1.eta").symbol
    assert describe("dissipation.0.modulus").symbol != describe("dissipation.1.modulus").symbol
    assert describe("loads.0").symbol == "m_{0}"
    assert describe("material.moduli.1").symbol == r"\mathrm{moduli}_{1}"


@pytest.mark.parametrize("name", ["strech", "stretch_errors", "nonsense.eta", ""])
def test_an_unknown_name_is_refused(name: str) -> None:
    """A misspelt variable raises, and the message says where the table is."""
    with pytest.raises(InputError, match=r"results/variables\.csv"):
        describe(name)


def test_status_flags_are_those_of_the_integrator() -> None:
    """Code k of `status` means what the integrator means by k."""
    assert len(FLAG_MEANINGS["status"]) == len(Status)
    for code in Status:
        assert FLAG_MEANINGS["status"][code] == code.meaning
    found = flag_attributes("status")
    values, meanings = found["flag_values"], str(found["flag_meanings"]).split()
    assert isinstance(values, np.ndarray)
    assert values.dtype == np.int8
    assert len(meanings) == len(values)
