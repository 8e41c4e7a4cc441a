"""How units are spelt, and what is refused of them at once.

Law: Bad input.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from remanent import _units
from remanent._errors import InputError

#: Spellings of one quantity, with its unit in SI and its size there.
SPELLINGS = [
    ("2000 kg/m^3", "kg/m^3", 2000.0), ("2000 kg/m3", "kg/m^3", 2000.0),
    ("2000 kg m-3", "kg/m^3", 2000.0), ("2000 kg m^-3", "kg/m^3", 2000.0),
    ("2000 kg·m⁻³", "kg/m^3", 2000.0), ("2 g/cm³", "kg/m^3", 2000.0),
    ("2000 kg/m**3", "kg/m^3", 2000.0), ("3 kJ m-3", "J/m^3", 3000.0),
    ("20 Pa s", "Pa s", 20.0), ("20 Pa*s", "Pa s", 20.0), ("20 Pa·s", "Pa s", 20.0),
    ("5 N/mm2", "Pa", 5e6), ("0.1 MPa", "Pa", 1e5), ("1.9 kJ/(kg K)", "J/(kg K)", 1900.0),
    ("5 s-1", "1/s", 5.0), ("5 1/s", "1/s", 5.0), ("7 µm", "m", 7e-6), ("7 μm", "m", 7e-6),
    ("25 degC", "K", 298.15), ("25 °C", "K", 298.15), ("200 G", "T", 0.02),
    ("200 gauss", "T", 0.02), ("2 kG", "T", 0.2), ("800 Oe", "T", 0.08), ("2 kOe", "T", 0.2),
    ("100 kA/m", "T", 0.1256637061), ("143mT", "T", 0.143), (" 1e-1 T ", "T", 0.1),
]  # fmt: skip


@pytest.mark.parametrize(("text", "unit", "size"), SPELLINGS)
def test_units_are_understood_as_people_write_them(text: str, unit: str, size: float) -> None:
    """Powers with and without signs, products with and without dots, gauss and oersted."""
    assert _units.magnitude_in_unit("x", text, unit) == pytest.approx(size, rel=1e-9)


def test_lists_and_lengths_of_time_are_arrays() -> None:
    """A list of texts, and times of NumPy."""
    np.testing.assert_allclose(_units.magnitude_in_unit("x", ["5 ms", "6 ms"], "s"), [5e-3, 6e-3])
    np.testing.assert_allclose(_units.radians_per_second("x", ["1 Hz", "1 rad/s"]), [2 * np.pi, 1])
    ticks = np.array([1, 2], "m8[ms]")
    np.testing.assert_allclose(_units.magnitude_in_unit("x", ticks, "s"), [1e-3, 2e-3])


HOSTILE = ["1 T**9**9**9", "1 T^9^9", "1 T**99999", "1 " + "(" * 50_000, "1 " + "T*" * 50_000,
           "1" * 100_000 + " T", "1e400 T", " " * 100_000, "1 __import__('os')", "1 T.m",
           "1 9**9 T", "nan T", "T", "", "1", "1 T T T", []]  # fmt: skip


@pytest.mark.parametrize("text", HOSTILE, ids=range(len(HOSTILE)))
def test_what_is_no_quantity_is_refused_at_once(text: str) -> None:
    """Limits on length, depth and exponents (else this would never end); the message is short."""
    with pytest.raises(InputError) as caught:
        _units.magnitude_in_unit("x", text, "T")
    assert len(str(caught.value)) < 400


@given(text=st.text("1T*^/()- mk.²°G", max_size=30))
def test_any_text_is_a_quantity_or_refused(text: str) -> None:
    """No other exception, whatever is written."""
    try:
        value = _units.magnitude_in_unit("x", text, "T")
    except InputError:
        return
    assert np.isfinite(value)
