"""The actuator as a value: fields, parameters, structure, and what it refuses."""

from __future__ import annotations

import subprocess
import sys
import warnings
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from remanent._errors import InputError, InputWarning
from remanent.models.actuator import Actuator
from remanent.models.dissipation import Rayleigh, Zener
from remanent.models.magnet import Magnet
from remanent.models.materials.named import NeoHookean
from remanent.models.temperature_shift import WLF


def test_defaults_are_those_of_the_paper() -> None:
    """An actuator without arguments is that of the reproduced article."""
    assert Actuator().parameter_values() == {
        "c": 1.0,
        "temperature": 293.0,
        "reference_temperature": 293.0,
        "prestress": 0.0,
        "material.entropic_fraction": 1.0,
        "magnet.temperature_coefficient": 0.0,
    }


def test_parameters_of_every_element_are_named_in_order() -> None:
    """Each element has its number in the names of its parameters."""
    names = list(Actuator(dissipation=(Rayleigh(0.1), Rayleigh(0.2))).parameter_values())
    assert names[4:7] == ["material.entropic_fraction", "dissipation.0.eta", "dissipation.1.eta"]


def test_numbers_do_not_change_the_structure_and_choices_do() -> None:
    """The structure depends on which parts there are, and not on their numbers."""
    plain = Actuator()
    assert (
        Actuator(c=0.1, material=NeoHookean(0.5)).equation_structure() == plain.equation_structure()
    )
    assert (
        Actuator(magnet=Magnet(law="rotation")).equation_structure() != plain.equation_structure()
    )
    assert Actuator(dissipation=Rayleigh(0.1)).equation_structure() != plain.equation_structure()
    assert Actuator(dissipation=Rayleigh(0.1)).equation_structure() != (
        Actuator(dissipation=(Rayleigh(0.1), Rayleigh(0.1))).equation_structure()
    )


def test_structure_is_plain() -> None:
    """The structure holds nothing but tuples, text and integers, so that it can be a key."""

    def plain(item: object) -> bool:
        return all(map(plain, item)) if isinstance(item, tuple) else isinstance(item, str | int)

    assert plain(Actuator(dissipation=Rayleigh(0.1)).equation_structure())


def test_one_element_may_stand_by_itself() -> None:
    """One element, a list of one and a tuple of one are the same."""
    expected = Actuator(dissipation=(Rayleigh(0.1),))
    assert Actuator(dissipation=Rayleigh(0.1)) == expected
    assert Actuator(dissipation=[Rayleigh(0.1)]) == expected


def test_replace_gives_a_changed_copy() -> None:
    """The first actuator stays as it is, and the copy equals one that is built so."""
    first = Actuator()
    second = first.replace(temperature=350)
    assert (first.temperature, second.temperature) == (293.0, 350.0)
    assert second == Actuator(temperature=350.0)
    assert hash(second) == hash(Actuator(temperature=350.0))


def test_unknown_fields_are_refused() -> None:
    """The message names the field that is unknown, and lists those that there are."""
    with pytest.raises(InputError, match="`temprature` must be a field of Actuator"):
        Actuator().replace(temprature=350.0)
    with pytest.raises(InputError, match="Name one of its fields: c, temperature"):
        Actuator().with_parameter("dissipation.0.eta", 0.1)


@pytest.mark.parametrize(
    "name",
    ["c", "prestress", "material.entropic_fraction", "dissipation.1.eta"],
)
def test_any_parameter_can_be_changed_by_its_name(name: str) -> None:
    """One parameter changes, and no other."""
    actuator = Actuator(dissipation=(Rayleigh(0.1), Rayleigh(0.2)))
    changed = actuator.with_parameter(name, 0.75)
    expected = {**actuator.parameter_values(), name: 0.75}
    assert changed.parameter_values() == expected


RULES: list[tuple[dict[str, Any], str]] = [
    ({"c": 0.0}, "`c` must be a finite number greater than 0; got 0.0. It is the square of"),
    ({"c": np.nan}, "`c` must be a finite number greater than 0; got nan"),
    ({"temperature": -5.0}, "`temperature` must be a finite number greater than 0; got -5.0"),
    ({"temperature": 0}, "`temperature` must be .*; got 0. It is an absolute temperature"),
    ({"reference_temperature": np.inf}, "`reference_temperature` must be .*; got inf"),
    ({"prestress": np.nan}, "`prestress` must be a finite number; got nan"),
    ({"prestress": (0.0, np.nan)}, "`prestress_2` must be a finite number; got nan"),
    ({"prestress": (0.0, 1.0, 2.0)}, "`prestress` must be one number or a pair of them"),
    ({"prestress": "1"}, "`prestress` must be one real number; got '1'"),
    ({"prestress": np.zeros(3)}, "`prestress` must be one number or a pair of them"),
    ({"edges": (1.0, 0.0)}, "`edges_2` must be a finite number greater than 0; got 0.0"),
    ({"edges": (1.0,)}, "`edges` must be one number or a pair of them"),
    ({"c": True}, "`c` must be one real number; got True"),
    ({"c": 10**400}, "`c` must be a finite number greater than 0; got 1000"),
    ({"heat": 1.0}, "`heat` must be a Heat; got 1.0"),
    ({"material": "rubber"}, "`material` must be a Material; got 'rubber'"),
    ({"magnet": None}, "`magnet` must be a Magnet; got None"),
    ({"dissipation": 0.1}, "`dissipation` must be a Dissipation; got 0.1"),
    ({"dissipation": (Rayleigh(0.1), 2)}, "`dissipation.1` must be a Dissipation; got 2"),
]


@pytest.mark.parametrize(("fields", "message"), RULES)
def test_bad_fields_are_explained(fields: dict[str, Any], message: str) -> None:
    """The message names the field, and says what it must be."""
    with pytest.raises(InputError, match=message):
        Actuator(**fields)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Rayleigh(-0.1), "`eta` must be a finite number, at least 0; got -0.1"),
        (lambda: NeoHookean(1.1), "`entropic_fraction` must be a finite number from 0 to 1"),
        (lambda: Magnet(np.inf), "`temperature_coefficient` must be a finite number; got inf"),
        (lambda: Magnet(law="spin"), "`law` must be one of 'deformation-gradient', 'rotation'"),
        (
            lambda: Magnet(law=3),  # type: ignore[arg-type]
            "`law` must be one of",
        ),
    ],
)
def test_bad_parts_are_explained(make: Any, message: str) -> None:
    """The message names the field of the part, and says what it must be."""
    with pytest.raises(InputError, match=message):
        make()


def test_temperatures_in_degrees_are_suspected() -> None:
    """A temperature that is likely in degrees Celsius draws a warning."""
    with pytest.warns(InputWarning, match="`temperature` is below 100 K"):
        Actuator(temperature=25.0)
    with pytest.warns(InputWarning, match="`reference_temperature` is below 100 K"):
        Actuator(reference_temperature=20.0)


def test_hot_magnets_are_pointed_out() -> None:
    """Beyond the rating of its magnet an actuator draws a warning, and otherwise none."""
    with pytest.warns(InputWarning, match="rating of plain NdFeB"):
        Actuator(temperature=400.0, magnet=Magnet(-0.001))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Actuator(temperature=400.0)
        Actuator(temperature=350.0, magnet=Magnet(-0.001))


def test_a_batch_is_warned_of_once() -> None:
    """Many suspicious values draw one warning."""
    with pytest.warns(InputWarning) as caught:
        Actuator().warn_if_implausible({"temperature": np.array([20.0, 30.0, 300.0])})
    assert len(caught) == 1


NUMBERS = st.floats(allow_nan=True, allow_infinity=True)


@given(
    name=st.sampled_from(list(Actuator(dissipation=(Rayleigh(0.1),)).parameter_values())), x=NUMBERS
)
def test_batch_check_agrees_with_single_check(name: str, x: float) -> None:
    """A batch marks as invalid exactly the values that a single actuator refuses."""
    actuator = Actuator(dissipation=(Rayleigh(0.1),))
    invalid = actuator.where_invalid({name: np.array([x, 1.0])})
    assert invalid.tolist() == [refused(actuator, name, x), False]


def refused(actuator: Actuator, name: str, value: float) -> bool:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)
        try:
            actuator.with_parameter(name, value)
        except InputError:
            return True
    return False


def test_a_batch_broadcasts() -> None:
    """Parameters of different shapes are judged on their common shape."""
    bad = Actuator().where_invalid(
        {"c": np.array([[1.0], [-1.0]]), "temperature": np.array([300.0, np.nan, 200.0])}
    )
    assert bad.tolist() == [[False, True, False], [True, True, True]]


def test_where_a_shift_of_temperature_has_no_value_nothing_is_valid() -> None:
    """Law: the law of Williams, Landel and Ferry has a pole at T0 - c2, where motion freezes."""
    block = Actuator(dissipation=Zener(1.0, 2.0, shift=WLF(8.0, 50.0)))
    cold = {"temperature": np.array([293.0, 243.1, 243.0, 230.0])}
    assert block.where_invalid(cold).tolist() == [False, False, True, True]
    assert not Actuator().where_invalid(cold).any()


def test_building_an_actuator_needs_neither_sympy_nor_pint() -> None:
    """Heavy packages are imported when they are needed, and not before."""
    script = (
        "import sys, remanent as rm\n"
        "rm.Actuator(dissipation=rm.Rayleigh(0.1)); rm.SineSquared(0.4, 1.25).period\n"
        "assert not {'sympy', 'pint', 'scipy', 'xarray'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
