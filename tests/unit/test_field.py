"""What a field says of its state variables: their roles, partners and values at rest."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import remanent as rm
from remanent._field import Field, Role, StateVariable
from remanent.codegen import reference
from remanent.codegen.field import vector_field_for
from remanent.integrate.variations import (
    field_with_integrals,
    field_with_tangents,
    transverse_field,
)

DRIVE = rm.Constant(0.0)
ACTUATORS: dict[str, rm.Actuator] = {
    "one coordinate": rm.Actuator(),
    "two coordinates": rm.Actuator(prestress=(0.0, 0.0)),
    "branches": rm.Actuator(dissipation=(rm.Zener(0.5, 2.0), rm.Zener(0.2, 0.1))),
    "everything": rm.Actuator(
        prestress=(0.0, 0.0), dissipation=rm.Zener(0.5, 2.0), heat=rm.Heat(exchange=0.1)
    ),
}


every = pytest.mark.parametrize("actuator", ACTUATORS.values(), ids=ACTUATORS.keys())


@every
def test_nothing_moves_at_rest(actuator: rm.Actuator) -> None:
    """Without loads, all rates vanish where each state variable has its value at rest."""
    field = vector_field_for(actuator, DRIVE)
    p = {**actuator.parameter_values(), **DRIVE.parameter_values()}
    y = np.array([[float(v.value_at_rest(p)) for v in field.variables]])
    rows = np.array([[p[name] for name in field.parameter_names]])
    np.testing.assert_allclose(
        reference.evaluate_rates(field, 0.0, y, rows, np.empty(0)), 0.0, atol=1e-15
    )


@pytest.mark.parametrize(
    ("name", "variables"),
    {"one coordinate": ["stretch"], "two coordinates": ["stretch_1", "stretch_2"]}.items(),
)
def test_the_thickness_is_computed_from_the_stretches(name: str, variables: list[str]) -> None:
    """Its rate is computed from their rates too."""
    field = vector_field_for(ACTUATORS[name], DRIVE)
    assert [field.state_names[k] for k in field.watched_variables] == variables
    behind_rate = {field.input_names[k] for k in field.observable_and_rates.inputs_behind(1)}
    assert behind_rate & {*field.state_names} == {*field.state_names}


@every
def test_every_coordinate_has_its_rate(actuator: rm.Actuator) -> None:
    """The rate of a coordinate is the state variable of that role that belongs to it."""
    field = vector_field_for(actuator, DRIVE)
    assert len(field.indices_of_roles(Role.COORDINATE)) == actuator.coordinate_count
    state = np.random.default_rng(1).uniform(0.9, 1.1, (1, len(field.state_names)))
    p = {**actuator.parameter_values(), **DRIVE.parameter_values()}
    rows = np.array([[p[name] for name in field.parameter_names]])
    rates = reference.evaluate_rates(field, 0.0, state, rows, np.empty(0))[0]
    for name in field.names_of_roles(Role.COORDINATE):
        (rate,) = (
            n for n in field.names_belonging_to(name) if field.state_variable(n).role is Role.RATE
        )
        assert rates[field.state_names.index(name)] == state[0, field.state_names.index(rate)]


def test_the_roles_of_a_full_state() -> None:
    """Names, roles, partners and rest of two coordinates, a branch and a temperature."""
    stretches = tuple(
        variable
        for i in (1, 2)
        for variable in (
            StateVariable(f"stretch_{i}", Role.COORDINATE, 1.0, positive=True),
            StateVariable(f"stretch_{i}_rate", Role.RATE, 0.0, f"stretch_{i}"),
        )
    )
    springs = tuple(
        StateVariable(
            f"dissipation.0.viscous_stretch_{i}", Role.INTERNAL, 1.0, f"stretch_{i}", True
        )
        for i in (1, 2)
    )
    warmth = StateVariable("body_temperature", Role.TEMPERATURE, "temperature", positive=True)
    field = vector_field_for(ACTUATORS["everything"], DRIVE)
    assert field.variables == (*stretches, *springs, warmth)
    assert field.load_names == ("load",)


@every
def test_roles_survive_storage_and_enter_the_fingerprint(actuator: rm.Actuator) -> None:
    """JSON keeps variables as they are; another value at rest makes another field."""
    field = vector_field_for(actuator, DRIVE)
    assert Field.from_json(field.to_json()).variables == field.variables
    first = replace(field.variables[0], rest=2.0)
    changed = replace(field, variables=(first, *field.variables[1:]))
    assert changed.fingerprint != field.fingerprint


@pytest.mark.parametrize(
    "wrong",
    [
        {"belongs_to": "no such variable"},
        {"rest": "no such parameter"},
    ],
)
def test_what_a_variable_names_exists(wrong: dict[str, Any]) -> None:
    """A partner is a state variable, and a name in `rest` is a parameter."""
    field = vector_field_for(rm.Actuator(), DRIVE)
    first = replace(field.variables[0], **wrong)
    with pytest.raises(ValueError, match="does not exist"):
        replace(field, variables=(first, *field.variables[1:]))


def test_variations_are_marked() -> None:
    """Derivatives and differences of the state belong to what they vary; integrals to nothing."""
    both = vector_field_for(ACTUATORS["two coordinates"], DRIVE)
    tangents = field_with_tangents(both, directions=2).variables[len(both.state_names) :]
    assert [v.belongs_to for v in tangents] == 2 * [*both.state_names]
    difference = transverse_field(
        both, {"stretch_1": "stretch_2", "stretch_1_rate": "stretch_2_rate"}
    )
    assert [v.belongs_to for v in difference.variables[2:]] == ["stretch_1", "stretch_1_rate"]
    assert {v.role for v in (*tangents, *difference.variables[2:])} == {Role.VARIATION}
    assert field_with_integrals(both, ["drive_power"]).variables[-1].role is Role.INTEGRAL
