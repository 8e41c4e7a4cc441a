"""Laws of values as plain data."""

from __future__ import annotations

import json
import tomllib
from dataclasses import fields
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import remanent as rm
from remanent.models.plain import from_plain_data, to_plain_data
from tests.contracts.test_drives import DRIVES
from tests.contracts.test_elements import ELEMENTS
from tests.contracts.test_materials import MATERIALS

PARTS: dict[str, Any] = {
    **MATERIALS,
    **ELEMENTS,
    **DRIVES,
    "heat": rm.Heat(1e-3, 0.1),
    "magnet": rm.Magnet(-1e-3, "rotation", 0.163),
    "actuator": rm.Actuator(prestress=(0.1, 1 / 3), edges=(1, 2), heat=rm.Heat(), c=0.1),
}
POSITIVE = st.floats(min_value=1e-300, max_value=1e300, allow_subnormal=False)


@pytest.mark.parametrize("value", PARTS.values(), ids=PARTS.keys())
def test_every_kind_of_part_comes_back(value: Any) -> None:
    """Its plain data, through JSON, give it back, with the same repr and equations."""
    rebuilt = from_plain_data(json.loads(json.dumps(to_plain_data(value))))
    assert type(rebuilt) is type(value)
    assert rebuilt == value
    assert repr(rebuilt) == repr(value)
    assert rebuilt.equation_structure() == value.equation_structure()
    for field in fields(value):
        assert getattr(rebuilt, field.name) == getattr(value, field.name)


@given(POSITIVE, st.floats(allow_nan=False, allow_infinity=False), st.lists(POSITIVE, min_size=1))
def test_numbers_come_back_bit_for_bit(omega: float, m: float, loads: list[float]) -> None:
    """JSON writes the shortest decimal that is read as the same float."""
    sines = rm.Sines(loads, range(1, len(loads) + 1), omega, mean=m)
    rebuilt = from_plain_data(json.loads(json.dumps(to_plain_data(sines))))
    assert rebuilt.loads == sines.loads
    assert (rebuilt.omega.hex(), rebuilt.mean.hex()) == (sines.omega.hex(), sines.mean.hex())


def test_a_study_file_holds_the_same_table() -> None:
    """The tables of a TOML file, with their `kind`, are those of `to_plain_data`."""
    text = """
    kind = "Actuator"
    temperature = 350
    dissipation = [{ kind = "Rayleigh", eta = 0.05 }]
    material = { kind = "Gent", jm = 50 }
    """
    system = from_plain_data(tomllib.loads(text))
    assert system == rm.Actuator(
        temperature=350.0, dissipation=rm.Rayleigh(0.05), material=rm.Gent(50.0)
    )
    table = to_plain_data(system)
    assert table["material"] == {"kind": "Gent", "jm": 50.0, "entropic_fraction": 1.0}
    assert None not in table.values()


@pytest.mark.parametrize(
    ("table", "match"),
    [
        ({}, "`kind` must be one of Actuator"),
        ({"kind": "simulate"}, "'simulate'"),
        ({"kind": "Material"}, "'Material'"),
        ({"kind": "os.system"}, "os.system"),
        ({"kind": "Gent"}, "`jm` must be given for Gent"),
        ({"kind": "Gent", "jm": 50, "jn": 1}, "`jn` must be a field of Gent"),
        ({"kind": "Gent", "jm": -1}, "greater than 0"),
        ({"kind": "Actuator", "material": {"jm": 50}}, "`material` must be a Material"),
        ({"kind": "Actuator", "material": {"kind": "Rayleigh", "eta": 1}}, "be a Material"),
        ([], "`kind`"),
    ],
)
def test_wrong_tables_are_refused_in_words(table: Any, match: str) -> None:
    """Unknown kinds and fields, missing fields and broken rules raise, naming the field."""
    with pytest.raises(rm.InputError, match=match):
        from_plain_data(table)


def test_a_class_of_the_same_name_is_told_apart() -> None:
    """A class of somebody's own never stands for the public one."""
    own = type("Gent", (rm.Gent,), {})(50.0)
    kind = to_plain_data(own)["kind"]
    assert kind != "Gent"
    with pytest.raises(rm.InputError, match="of your own"):
        from_plain_data({"kind": kind, "jm": 50.0})


@pytest.mark.parametrize("value", [3.0, rm.Gent, None, {"kind": "Gent"}])
def test_only_values_of_a_model_have_a_table(value: Any) -> None:
    """A number or a class is no part of a model."""
    with pytest.raises(rm.InputError, match="plain data only"):
        to_plain_data(value)


@pytest.mark.parametrize("length", [3, 200])
def test_what_no_table_can_hold_is_shown_as_far_as_it_is_short(length: int) -> None:
    """A kind of a few characters is in the message whole, a long one up to an ellipsis."""
    kind = "k" * length
    with pytest.raises(rm.InputError) as refusal:
        from_plain_data({"kind": kind})
    text = str(refusal.value)
    assert (repr(kind) in text) == (length == 3)
    assert ("k…" in text) == (length == 200)
