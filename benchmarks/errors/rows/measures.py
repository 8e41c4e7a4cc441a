"""Values, elasticities, designs and quantiles of measures, against heyoka and quadrature."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

import remanent as rm
from benchmarks.errors.row import Judged, Promise, Row, shared
from benchmarks.errors.rows.inference import (
    FIELDS,
    SAMPLES,
    STATISTICS_TIMES,
    STATISTICS_TOLERANCE,
    Body,
)
from remanent._typing import FloatArray

#: Nodes of the polynomial through an uncertain measure, in each of two fields.
_NODES = 16
#: Places in each field at which that polynomial is evaluated for a quantile.
_PLACES = 400


@shared
def _sensitivities(rng: np.random.Generator) -> Iterator[tuple[str, Judged]]:
    """The value of a stretch, and its elasticity by some fields."""
    body = Body.drawn(rng)
    fields = [str(field) for field in rng.choice(FIELDS, 2, replace=False)]
    found = rm.sensitivity(body.measure("stretch", times=body.times[-1:]), parameters=fields)
    found = found.isel(time=0)
    value = float(body.state({}, body.periods)[0])
    yield "value", body.judged(found.value_error, abs(float(found.value) - value), value)
    for field in fields:
        one = found.sel(field=field)
        slope = body.stretch_derivative(field)
        exact = slope * body.values[field] / value
        if np.isfinite(exact) and np.isfinite(one.elasticity):
            off = abs(float(one.elasticity) - exact)
            about = f"elasticity by {field}"
            yield "elasticity", body.judged(one.elasticity_error, off, abs(exact), about)


def _of(name: str) -> Callable[[np.random.Generator], Iterator[Judged]]:
    return lambda rng: (judged for what, judged in _sensitivities(rng) if what == name)


def _reached(rng: np.random.Generator) -> Iterator[Judged]:
    """What a design reaches: the stretch with the field that was found."""
    body = Body.drawn(rng)
    field = str(rng.choice(FIELDS))
    target = float(body.state({}, body.periods)[0])
    measure = body.measure(lambda ds: ds.stretch.isel(time=-1), times=body.times)
    guess = body.values[field] * (1.0 + rng.uniform(-0.01, 0.01))
    found = rm.design(measure, target, {field: guess})
    exact = float(body.state({field: float(found.solution[0])}, body.periods)[0])
    off = abs(float(found.reached[0]) - exact)
    yield body.judged(found.reached_error[0], off, exact, f"by {field} from {guess!r}")


def _quantiles(rng: np.random.Generator) -> Iterator[Judged]:
    """Of a stretch at some time under two uniform fields."""
    body = Body.drawn(rng)
    ranges = {
        str(field): (
            float(body.values[field] * (1.0 - rng.uniform(0.02, 0.3))),
            float(body.values[field] * (1.0 + rng.uniform(0.02, 0.3))),
        )
        for field in rng.choice(FIELDS, 2, replace=False)
    }
    measure = rm.Measure(
        rm.simulate, body.actuator, body.drive, of="stretch", times=STATISTICS_TIMES,
        tolerance=STATISTICS_TOLERANCE,
    )  # fmt: skip
    share = float(rng.uniform(0.2, 0.8))
    found = rm.uncertainty(
        measure, parameter_ranges=ranges, samples=SAMPLES, quantiles=[share],
        rng=int(rng.integers(2**31)),
    )  # fmt: skip
    k = int(rng.integers(len(STATISTICS_TIMES)))  # one: errors at all times are alike
    exact = float(np.quantile(_dense_values(measure, ranges)[..., k], share))
    off = abs(float(found.stretch[0, k]) - exact)
    about = f"{ranges}, quantile {share} at time {k}"
    yield body.judged(found.stretch_error[0, k], off, exact, about)


def _dense_values(measure: rm.Measure, ranges: dict[str, tuple[float, float]]) -> FloatArray:
    """A measure at evenly spread values of two fields, (place, place, time), by a polynomial."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    columns = [low + (high - low) * (nodes + 1.0) / 2.0 for low, high in ranges.values()]
    mesh = [each.ravel() for each in np.meshgrid(*columns, indexing="ij")]
    values = measure.values_at(dict(zip(ranges, mesh, strict=True))).values
    table = values.reshape(_NODES, _NODES, -1)
    degrees = np.arange(_NODES) + 0.5
    to_coefficients = np.polynomial.legendre.legvander(nodes, _NODES - 1) * weights[:, None]
    to_coefficients *= degrees
    places = (np.arange(_PLACES) + 0.5) / _PLACES * 2.0 - 1.0
    carry = np.polynomial.legendre.legvander(places, _NODES - 1) @ to_coefficients.T
    return np.asarray(np.einsum("ai,bj,ijt->abt", carry, carry, table, optimize=True))


ROWS = (
    Row("values of measures", "sensitivity: value_error", _of("value")),
    Row("elasticities by fields", "sensitivity: elasticity_error", _of("elasticity")),
    Row("measures that designs reach", "design: reached_error", _reached),
    Row(
        "quantiles under uncertain fields",
        "uncertainty: stretch_error",
        _quantiles,
        Promise.STANDARD,
    ),
)
