"""Measures: whose fields, which arguments, and which errors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm

BODY, DRIVE = rm.Actuator(dissipation=rm.Rayleigh(0.1)), rm.SineSquared(0.4, 1.25)
AT = {"c": [1.0, 1.01]}


@pytest.mark.parametrize(
    ("verb", "options", "name"),
    [
        (rm.lyapunov, {"periods": 100}, "exponent"),
        (rm.frequency_response, {"omega": np.linspace(1.0, 1.5, 6), "duration": 30.0}, "resonance"),
        (rm.simulate, {"times": [1.0, 2.0]}, "stretch"),
    ],
)
def test_a_function_that_picks_a_variable_has_its_error(
    verb: Callable[..., Any], options: dict[str, Any], name: str
) -> None:
    """By name or by function: the same measure, and the same error."""
    named, picked = (
        rm.Measure(verb, BODY, DRIVE, of=of, **options).at(AT) for of in (name, lambda ds: ds[name])
    )
    for one, other in zip(named, picked, strict=True):
        np.testing.assert_allclose(other, one, rtol=1e-6)
    assert (named[1] > 0.0).all()


def _made(value: float, error: float) -> Callable[..., xr.Dataset]:
    """A verb whose result has given numbers, each with its error."""

    def verb(_: rm.Actuator, *, over: Any = None) -> xr.Dataset:
        count = len(next(iter(over.values())))
        rows = np.tile([value, 2.0 * value, -value], (count, 1))
        return xr.Dataset(
            {
                "x": (("sample", "k"), rows),
                "x_error": (("sample", "k"), np.full_like(rows, error)),
                "exact": (("sample",), np.arange(count)),
                "bare": (("sample",), np.ones(count)),
            }
        )

    return verb


@pytest.mark.parametrize(
    ("of", "expected"),
    [
        (lambda ds: ds.x.isel(k=1), 0.1),
        (lambda ds: 3.0 * ds.x.isel(k=0), 0.3),
        (lambda ds: ds.x.mean("k"), 0.1),
        (lambda ds: ds.x.max("k") - ds.x.min("k"), 0.2),
        (lambda ds: ds.x.isel(k=0) - ds.x.isel(k=1), 0.2),
        (lambda ds: ds.x.isel(k=0) ** 2, 2.0 * 5.0 * 0.1 + 0.1**2),
        (lambda ds: ds.x.isel(k=0) + ds.exact, 0.1),
        (lambda ds: ds.x.isel(k=0) + ds.bare, np.nan),
        (lambda ds: ds.x_error.isel(k=0), np.nan),
    ],
)
def test_errors_are_carried_through_functions(
    of: Callable[[xr.Dataset], Any], expected: float
) -> None:
    """Sums of errors times slopes; NaN where a number without an error enters."""
    _, error = rm.Measure(_made(5.0, 0.1), BODY, of=of).at(AT)
    np.testing.assert_allclose(error, expected, rtol=1e-9)


def test_no_error_is_not_zero() -> None:
    """A number alone has no error: what is made of it has none either, and says so."""

    def natural(actuator: rm.Actuator) -> float:
        return float(rm.equilibria(actuator).natural_frequency[0])

    found = rm.sensitivity(natural, rm.Actuator(), parameters="c")
    assert np.isnan(found.value_error)
    assert np.isnan(found.derivative_error).all()
    assert "states no error" in found.attrs["reason"]
    placed = rm.design(rm.Measure(natural, rm.Actuator()), 2.4, "c")
    assert np.isnan(placed.reached_error).all()
    assert np.isnan(placed.solution_error).all()
    spread = rm.uncertainty(
        natural, rm.Actuator(), parameter_ranges={"c": (0.9, 1.1)}, samples=32, quantiles=[0.5]
    )
    assert "states no error" in spread.attrs["errors"]


def test_a_verb_for_one_set_of_values_has_them_in_its_system_and_its_drive() -> None:
    """Law: each value goes to the field of its name, of the body or of the drive."""

    def product(body: rm.Actuator, drive: rm.SineSquared) -> float:
        return 1e4 * body.c + 100.0 * drive.b + drive.omega

    columns = {"omega": [1.0, 2.0], "c": [0.5, 0.25], "b": [0.1, 0.7]}
    values = rm.Measure(product, BODY, DRIVE).values_at(columns)
    np.testing.assert_allclose(values, [5011.0, 2572.0], rtol=1e-14)
    only = rm.Measure(product, BODY, drive=DRIVE).values_at({"omega": [3.0]})
    np.testing.assert_allclose(only, [1e4 + 40.0 + 3.0], rtol=1e-14)


def test_unknown_arguments_are_refused_at_once() -> None:
    """A misspelt option, and one that is missing, before anything is computed."""
    with pytest.raises(rm.InputError, match="tolerence"):
        rm.Measure(rm.lyapunov, BODY, DRIVE, periods=100, tolerence=1e-9)
    with pytest.raises(rm.InputError, match="drive"):
        rm.Measure(rm.lyapunov, BODY)


class _Other:
    """A system that is no actuator, with one field."""

    load_names = ("load",)
    scales = None
    conservative = is_time_reversible = True

    def __init__(self, stiffness: float = 4.0) -> None:
        self.stiffness = stiffness

    def parameter_values(self) -> dict[str, float]:
        return {"stiffness": self.stiffness}

    def with_parameter(self, name: str, value: float) -> _Other:
        assert name == "stiffness"
        return _Other(value)

    def _unused(self, *_: Any, **__: Any) -> Any:
        raise NotImplementedError

    where_dissipative = parameter_rules = equation_structure = where_invalid = _unused
    where_admissible = describe_coordinate_limits = needs_load_rate = _unused
    warn_if_implausible = replace = variable_texts = _unused


def test_any_system_is_found() -> None:
    """sqrt(k) of a spring of one's own: its elasticity is 1/2."""

    def frequency(spring: _Other) -> xr.Dataset:
        return xr.Dataset({"value": spring.stiffness**0.5, "value_error": 1e-12})

    found = rm.sensitivity(frequency, _Other(), parameters="stiffness")
    np.testing.assert_allclose(found.elasticity, 0.5, rtol=1e-9)
    assert abs(float(found.derivative[0]) - 0.25) <= float(found.derivative_error[0])


def test_physical_sizes_are_fields_of_every_actuator() -> None:
    """omega_n goes with the root of modulus over density, without a verb that takes `over`."""

    def natural(actuator: rm.Actuator) -> float:
        return float(rm.equilibria(actuator).natural_frequency[0])

    names = ["shear_modulus", "density", "remanence"]
    found = rm.sensitivity(natural, rm.Actuator(), parameters=names)
    np.testing.assert_allclose(found.elasticity, [0.5, -0.5, 0.0], atol=1e-9)
