"""Units in and out."""

from __future__ import annotations

import inspect
from typing import Any

import numpy as np
import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from remanent._errors import InputError
from remanent.models.actuator import Actuator
from remanent.models.scaling import VACUUM_PERMEABILITY, Scales

FILM: dict[str, Any] = {
    "shear_modulus": "100 kPa",
    "density": "2000 kg/m^3",
    "half_length": "5 mm",
    "half_thickness": "0.5 mm",
    "remanence": "143 mT",
}


def test_the_realistic_set() -> None:
    """m of 140 mT is about 0.16, c is 0.01, the unit of time 0.707 ms."""
    film = Actuator.from_si(**FILM)
    assert film.c == pytest.approx(0.01, rel=1e-14)
    assert film.load("140 mT") == pytest.approx(
        0.143 * 0.14 / (1e5 * VACUUM_PERMEABILITY), rel=1e-14
    )
    assert film.load("140 mT") == pytest.approx(0.16, rel=0.01)
    assert film.scales is not None
    assert film.scales.time_unit == pytest.approx(0.707e-3, rel=1e-3)
    assert film.temperature == film.reference_temperature == 293.0


def test_a_misspelt_size_is_named() -> None:
    """Whatever `from_si` takes is listed for a word that it does not know, the closest first."""
    taken = set(inspect.signature(Actuator.from_si).parameters) - {"parts"}
    taken |= {"material", "dissipation", "heat", "magnet"}
    with pytest.raises(InputError, match="Did you mean `remanence`") as refused:
        Actuator.from_si(**{**FILM, "remanance": "143 mT"})
    listed = str(refused.value).partition("Name one of its fields: ")[2].rstrip(".")
    assert set(listed.split(", ")) == taken


def test_force_gives_the_nominal_stress() -> None:
    """S = P/(4 L H mu)."""
    film = Actuator.from_si(**FILM, force="1 N")
    assert film.prestress == pytest.approx(1.0 / (4 * 5e-3 * 5e-4 * 1e5), rel=1e-14)


def test_temperatures_may_be_in_degrees() -> None:
    """Degrees Celsius become kelvins."""
    film = Actuator.from_si(**FILM, temperature="76.85 degC", reference_temperature="293 K")
    assert film.temperature == pytest.approx(350.0, rel=1e-14)


def test_scales_survive_replace_and_do_not_take_part_in_equality() -> None:
    """Scales stay with a changed copy; actuators of equal numbers are equal with other scales."""
    film = Actuator.from_si(**FILM)
    assert film.replace(temperature=350.0).scales == film.scales
    assert film == Actuator(c=film.c)
    assert "scales" not in repr(film)


def test_pint_quantities_of_any_registry() -> None:
    """A quantity converts the same whichever registry made it, arrays too."""
    registry: Any = pint.UnitRegistry()
    film = Actuator.from_si(**{**FILM, "shear_modulus": registry.Quantity(1.0, "bar")})
    assert film.c == pytest.approx(0.01, rel=1e-14)
    load = np.asarray(film.load("140 mT"))
    fields = film.load(registry.Quantity(np.array([0.0, 140.0]), "mT"))
    np.testing.assert_allclose(np.asarray(fields), [0.0, 1.0] * load, rtol=1e-14)


def test_frequencies_count_cycles_or_radians() -> None:
    """Hertz and revolutions are cycles, of 2 pi radians each."""
    film = Actuator.from_si(**FILM)
    turned = [film.frequency(text) for text in ("3 kHz", "180000 rpm")]
    assert turned == pytest.approx([film.frequency(f"{2 * np.pi * 3000.0!r} rad/s")] * 2, rel=1e-14)


@given(st.floats(1.0, 1e9), st.floats(1.0, 1e5), st.floats(1e-6, 1.0), st.floats(1e-6, 10.0))
def test_round_trips(modulus: float, density: float, length: float, remanence: float) -> None:
    """Within 1e-14 for load, frequency, time and stress (law: Reversal and scaling)."""
    film = Actuator.from_si(
        shear_modulus=f"{modulus!r} Pa",
        density=f"{density!r} kg/m^3",
        half_length=f"{length!r} m",
        half_thickness=f"{length!r} m",
        remanence=f"{remanence!r} T",
        force="2.5 N",
    )
    assert film.scales is not None
    factors = film.scales.si_factors()
    assert film.load("0.14 T") * factors["load_T"] == pytest.approx(0.14, rel=1e-14)
    assert film.frequency("50 Hz") * factors["frequency_hz"] == pytest.approx(50.0, rel=1e-14)
    assert film.time("3 s") * factors["time_s"] == pytest.approx(3.0, rel=1e-14)
    area = 4.0 * length * length
    assert isinstance(film.prestress, float)
    assert film.prestress * factors["stress_pa"] * area == pytest.approx(2.5, rel=1e-14)


def test_without_a_remanence_there_is_no_scale_of_loads() -> None:
    """Loads cannot be converted without a remanence, and the message says so."""
    scales = Scales(shear_modulus=1e5, density=2e3, half_length=5e-3)
    assert "load_T" not in scales.si_factors()
    given_up = Actuator.from_si(**{k: v for k, v in FILM.items() if k != "remanence"})
    with pytest.raises(InputError, match="`remanence` must be given to convert magnetic loads"):
        given_up.load("140 mT")


def test_a_dimensionless_actuator_converts_nothing() -> None:
    """Without scales each conversion says how to make an actuator that has them."""
    for convert, text in (("load", "1 mT"), ("frequency", "1 Hz"), ("time", "1 s")):
        with pytest.raises(InputError, match="`actuator` must be made by"):
            getattr(Actuator(), convert)(text)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"density": "5 kPa"}, "`density` must have a unit of the dimension of kg/m\\^3"),
        ({"density": "5 wibble"}, "`density` must have a unit of the dimension of kg/m\\^3"),
        ({"density": 5.0}, "`density` must be a quantity with a unit"),
        ({"density": "2000"}, "`density` must be a quantity with a unit"),
        ({"density": ""}, "`density` must be a quantity with a unit"),
        ({"density": "__import__('os')"}, "`density` must be a quantity with a unit"),
        ({"density": "1 __import__('os')"}, "`density` must have a unit"),
        ({"density": "1 kg/m^3 + ("}, "`density` must have a unit"),
        ({"half_length": "-5 mm"}, "`half_length` must be greater than 0 and finite; got '-5 mm'"),
        ({"half_length": "0 mm"}, "`half_length` must be greater than 0 and finite"),
        ({"half_thickness": "1e400 mm"}, "`half_thickness` must be a finite number of m"),
        ({"shear_modulus": "0 Pa"}, "`shear_modulus` must be greater than 0"),
        ({"remanence": "-143 mT"}, "`remanence` must be greater than 0"),
        ({"temperature": "-300 degC"}, "`temperature` must be a finite number greater than 0"),
        ({"colour": "red"}, "`colour` must be a field of Actuator.from_si"),
    ],
)
def test_bad_quantities_are_explained(changes: dict[str, Any], message: str) -> None:
    """The message names the quantity, and says which dimension it must have."""
    with pytest.raises(InputError, match=message):
        Actuator.from_si(**{**FILM, **changes})


def test_many_values_are_refused_where_one_is_meant() -> None:
    """An array in place of one quantity is refused by name."""
    many = pint.UnitRegistry().Quantity(np.array([1.0, 2.0]), "kPa")
    with pytest.raises(InputError, match="`shear_modulus` must be a single quantity"):
        Actuator.from_si(**{**FILM, "shear_modulus": many})


@pytest.mark.parametrize("text", ["50 1/s", "3 mT", "fast"])
def test_ambiguous_frequencies_are_refused(text: str) -> None:
    """A unit that counts neither cycles nor radians is refused."""
    with pytest.raises(InputError, match="`frequency` must be a"):
        Actuator.from_si(**FILM).frequency(text)
