"""Programs joined into one, and cut into stages, compute what they compute by themselves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import remanent as rm
from remanent._field import Program
from remanent.codegen.field import vector_field_for
from remanent.codegen.formula_program import joined_program
from remanent.codegen.languages.stages import staged_program

SYSTEMS: dict[str, Any] = {
    "actuator": rm.Actuator(material=rm.Gent(30.0)),
    "heat": rm.Actuator(dissipation=rm.Zener(0.5, 1.0), heat=rm.Heat()),
    "two wells": rm.LagrangianSystem.example(),
}


def run(program: Program, values: dict[str, float]) -> list[float]:
    given = [np.float64(values[name]) for name in program.input_names]
    return [float(x) for x in program(given, functions=np)]


@pytest.mark.parametrize("name", SYSTEMS)
def test_joined_and_staged_programs_give_the_same(name: str) -> None:
    """Law: outputs agree to rounding; stages read only what earlier ones give."""
    field = vector_field_for(SYSTEMS[name], rm.SineSquared(0.4, 1.25))
    parts = [field.rates, *field.observables.values()]
    rng = np.random.default_rng(5)
    values = {one: float(rng.uniform(0.9, 1.2)) for one in field.input_names}
    apart = [x for part in parts for x in run(part, values)]
    joined = joined_program(parts)
    np.testing.assert_allclose(run(joined, values), apart, rtol=1e-13, atol=1e-13)
    assert len(joined.instructions) < sum(len(part.instructions) for part in parts)

    time = {"drive_phase", *field.waveform_names}
    count = len(field.rates.output_slots)
    outputs = {"rates": range(count), "seen": range(count, len(apart))}
    staged = staged_program(joined, outputs, {*field.parameter_names}, time)
    assert set(staged.constants.input_names) <= {*field.parameter_names}
    assert set(staged.driven.input_names) <= {*staged.constant_names, *time}
    known = dict(values)
    known |= zip(staged.constant_names, run(staged.constants, known), strict=True)
    known |= zip(staged.driven_names, run(staged.driven, known), strict=True)
    for part in staged.moving.values():
        earlier = {*staged.constant_names, *staged.driven_names}
        assert set(part.input_names) <= {*field.state_names, *earlier}
    found = [*run(staged.moving["rates"], known), *run(staged.moving["seen"], known)]
    np.testing.assert_allclose(found, apart, rtol=1e-13, atol=1e-13)
    assert len(staged.moving["rates"].instructions) < len(field.rates.instructions)
