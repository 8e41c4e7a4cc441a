"""Derivatives of straight-line code are derivatives; integrals are integrals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from remanent._field import Field
from remanent._typing import FloatArray
from remanent.codegen.field import vector_field_for
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Problem, Request
from remanent.integrate.variations import (
    LOG_PERIOD_PARAMETER_NAME,
    field_with_integrals,
    field_with_tangents,
    observable_derivatives,
)
from remanent.models.actuator import Actuator
from remanent.models.dissipation import Rayleigh
from remanent.models.drives.waves import SineSquared
from tests.unit.integrate.handmade import COSINE, SINE, Oscillator, Q, V, problem

A = sp.Symbol("a", real=True)
#: Every operation that a program may have.
EVERYTHING = Oscillator(
    sp.sin(A * Q) / (2 + Q**2) + sp.exp(-V) * SINE - sp.log(3 + Q) / sp.sqrt(2 + V) * sp.cos(V),
    {"a": 1.3},
)
STEP = 1e-25


def fields() -> list[Field]:
    damped = Actuator(dissipation=Rayleigh(0.1))
    return [EVERYTHING.field(), vector_field_for(damped, SineSquared(0.4, 1.2))]


def values_of(field: Field, rng: np.random.Generator) -> list[complex]:
    own = [300.0 * (1.0 + 0.2 * rng.random()) if "temperature" in name else rng.uniform(0.5, 1.5)
           for name in field.input_names]  # fmt: skip
    return [complex(x) for x in own]


@pytest.mark.parametrize("field", fields(), ids=["everything", "actuator"])
def test_tangents_are_complex_step_derivatives(field: Field) -> None:
    """w' = J w (+ df/dp, + f), against the complex step, to 8 ulp times condition.

    Law: Generated code.
    """
    rng = np.random.default_rng(5)
    n, p = len(field.state_names), field.parameter_names[0]
    carried = field_with_tangents(field, directions=2, parameters=(p, LOG_PERIOD_PARAMETER_NAME))
    for _ in range(50):
        base = values_of(field, rng)
        w = rng.normal(size=(4, n))
        real = [x.real for x in base]
        out = np.array(
            carried.rates([*real[: 1 + n], *w.ravel(), *real[1 + n :]], functions=np)
        ).reshape(5, n)
        np.testing.assert_allclose(out[0], field.rates(real, functions=np), rtol=1e-14)
        for k in range(4):
            moved = list(base)
            for i in range(n):
                moved[1 + i] += 1j * STEP * w[k, i]
            if k == 2:
                moved[field.input_names.index(p)] += 1j * STEP
            expected = np.imag(field.rates(moved, functions=np)) / STEP
            if k == 3:
                expected = expected + out[0]
            scale = np.abs(expected).max() + np.abs(out[0]).max()
            np.testing.assert_allclose(out[1 + k], expected, rtol=0, atol=200e-16 * 10 * scale)


@pytest.mark.parametrize("directions", [0, 1, 2, 4, 7])
@pytest.mark.parametrize("field", fields(), ids=["everything", "actuator"])
def test_observables_do_not_depend_on_what_is_carried_along(field: Field, directions: int) -> None:
    """All observables are bit for bit those of the field, however many tangents there are."""
    rng = np.random.default_rng(6)
    inputs = [x.real for x in values_of(field, rng)]
    n, p = len(field.state_names), field.parameter_names[0]
    carried = field_with_tangents(field, directions=directions, parameters=(p,))
    tangents = rng.normal(size=(directions + 1) * n)
    more = [*inputs[: 1 + n], *tangents, *inputs[1 + n :]]
    programs = [(field.observable_and_rates, carried.observable_and_rates)]
    programs += [(own, carried.observables[name]) for name, own in field.observables.items()]
    for own, same in programs:
        assert same(more, functions=np) == own(inputs, functions=np)


def test_derivatives_of_an_observable() -> None:
    """Derivatives by states and parameters are those of a complex step."""
    field = vector_field_for(Actuator(), SineSquared(0.4, 1.2))
    program = observable_derivatives(field, "energy", ("stretch", "stretch_rate", "c"))
    values = values_of(field, np.random.default_rng(2))
    found = program([x.real for x in values], functions=np)
    for name, got in zip(("stretch", "stretch_rate", "c"), found[1:], strict=True):
        moved = list(values)
        moved[field.input_names.index(name)] += 1j * STEP
        assert got == pytest.approx(np.imag(field.observables["energy"](moved, functions=np)[0])
                                    / STEP, rel=1e-12)  # fmt: skip


def carried(asked: Problem, field: Field, extra: FloatArray) -> Problem:
    return replace(asked, field=field, initial_states=np.hstack([asked.initial_states, extra]))


def test_tangents_of_a_linear_oscillator_are_its_matrix_exponential() -> None:
    """q'' = -w^2 q + sin 2 pi s: derivatives in closed form, also with respect to w."""
    w, end = 1.7, 5.0
    omega = sp.Symbol("w", real=True)
    asked = problem(Oscillator(-(omega**2) * Q + SINE, {"w": w}), (0.3, -0.2), end, period=1.0)
    field = field_with_tangents(asked.field, directions=2)
    out = integrate(
        carried(asked, field, np.array([[1.0, 0.0, 0.0, 1.0]])),
        Request(times=np.array([[end]])),
        tolerance=1e-11,
    )
    assert out.states is not None
    c, s = np.cos(w * end), np.sin(w * end)
    expected = [c, -w * s, s / w, c]
    np.testing.assert_allclose(out.states[0, 0, 2:], expected, atol=2e-11)


def test_the_period_enters_by_its_logarithm() -> None:
    """d state / d log period at fixed phase, against a difference of two runs."""
    oscillator = Oscillator(-Q - 0.2 * Q**3 + 0.4 * COSINE - 0.1 * V, {})

    def end(period: float, field: Field | None = None) -> FloatArray:
        asked = problem(oscillator, (1.0, 0.0), 3.0 * period, period=period)
        if field is not None:
            asked = carried(asked, field, np.zeros((1, 2)))
        out = integrate(asked, Request(strobe_cycles=3), tolerance=1e-12)
        assert out.states is not None
        return np.asarray(out.states[0, -1])

    field = field_with_tangents(problem(oscillator, (1.0, 0.0), 1.0).field, directions=0,
                    parameters=(LOG_PERIOD_PARAMETER_NAME,))  # fmt: skip
    h, period = 1e-4, 2.2
    difference = (end(period * np.exp(h)) - end(period * np.exp(-h))) / (2.0 * h)
    np.testing.assert_allclose(end(period, field)[2:], difference, atol=1e-6)


def test_an_integral_is_the_integral() -> None:
    """The integral of q for q = cos tau is sin tau."""
    asked = problem(Oscillator(-Q, {}), (1.0, 0.0), 20.0)
    field = field_with_integrals(asked.field, ["position"])
    assert field.state_names == ("q", "v", "integral.position")
    times = np.linspace(0.0, 20.0, 33)[None]
    out = integrate(carried(asked, field, np.zeros((1, 1))), Request(times=times), tolerance=1e-11)
    assert out.states is not None
    np.testing.assert_allclose(out.states[0, :, 2], np.sin(times[0]), atol=1e-11)
