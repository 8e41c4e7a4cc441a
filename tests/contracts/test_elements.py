"""What every dissipative element must satisfy; a new one joins by its example."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import remanent as rm
from remanent.models.dissipation import Dissipation
from tests.contracts.public import examples
from tests.repetitions import fast_and_slow

ELEMENTS: dict[str, Dissipation] = {
    **examples(Dissipation),
    "zener, WLF": rm.Zener(0.5, 0.7, rm.WLF(8.0, 200.0)),
    "zener, Arrhenius": rm.Zener(0.5, 0.7, rm.Arrhenius(6000.0)),
    "fluid, Arrhenius": rm.KelvinVoigt(0.1, rm.Arrhenius(6000.0)),
}
LOADS: dict[str, Any] = {"one": 0.2, "two": (0.2, -0.1)}
DRIVE = rm.SineSquared(0.4, 1.25)

every = pytest.mark.parametrize("element", ELEMENTS.values(), ids=ELEMENTS.keys())
both = pytest.mark.parametrize("load", fast_and_slow(LOADS, ("one",)))


@every
@both
def test_dissipation_is_never_negative_and_balances_the_energy(
    element: Dissipation, load: Any
) -> None:
    """Dissipated energy never falls, and closes the balance of energy within the error."""
    body = rm.Actuator(temperature=320.0, prestress=load, dissipation=element)
    ds = rm.energy_balance(body, DRIVE, duration=20.0)
    assert (np.diff(ds.dissipated_energy.values) >= -1e-12).all()
    assert float(ds.dissipated_energy[-1]) > 1e-4
    assert float(abs(ds.balance).max()) <= 20.0 * float(ds.error)


@pytest.mark.parametrize("element", fast_and_slow(ELEMENTS, ("Rayleigh", "Zener")))
def test_equal_loads_keep_stretches_equal(element: Dissipation) -> None:
    """One coordinate and two are the same motion, with the same energies."""
    names = ("energy", "thickness_stretch", "thickness_stretch_rate")
    one, two = (
        rm.simulate(rm.Actuator(prestress=load, dissipation=element), DRIVE, duration=15.0)
        for load in (0.2, (0.2, 0.2))
    )
    slack = 10.0 * float(one.error + two.error)
    for name in names:
        assert float(abs(one[name] - two[name]).max()) <= slack
    assert float(abs(one.stretch - two.stretch_2).max()) <= slack


@every
@both
def test_motion_comes_to_rest_at_an_equilibrium(element: Dissipation, load: Any) -> None:
    """Under a constant load a damped motion ends at the stable equilibrium."""
    body = rm.Actuator(temperature=320.0, prestress=load, dissipation=element)
    ds = rm.simulate(body, rm.Constant(0.16), times=[0.0, 400.0], tolerance=1e-8)
    at = rm.equilibria(body, 0.16)
    assert at.stability.values.tolist() == ["stable"]
    assert float(ds.thickness_stretch[-1]) == pytest.approx(
        float(at.equilibrium_stretch[0]), abs=1e-4
    )


@every
def test_numbers_of_the_element_can_be_varied(element: Dissipation) -> None:
    """Each number of the element varied by `over` gives the single run, bit for bit."""
    body = rm.Actuator(dissipation=element)
    numbers = {k: v for k, v in body.parameter_values().items() if k.startswith("dissipation")}
    assert f"dissipation.0.{element.strength_field_name}" in numbers
    for name, value in numbers.items():
        over = {name: [value, 1.5 * value]}
        many = rm.simulate(body, DRIVE, times=[0.0, 3.0], over=over)
        single = rm.simulate(body.with_parameter(name, 1.5 * value), DRIVE, times=[0.0, 3.0])
        assert float(many.stretch[1, -1]) == float(single.stretch[-1])


@every
def test_nothing_is_lost_where_the_strength_is_zero(element: Dissipation) -> None:
    """An element without strength leaves the undamped motion, within the errors of both."""
    name = f"dissipation.0.{element.strength_field_name}"
    body = rm.Actuator(dissipation=element).with_parameter(name, 0.0)
    assert not body.where_dissipative()
    ds = rm.simulate(body, DRIVE, duration=10.0)
    plain = rm.simulate(rm.Actuator(), DRIVE, duration=10.0)
    assert float(abs(ds.stretch - plain.stretch).max()) <= float(ds.error + plain.error)
