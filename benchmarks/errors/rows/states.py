"""States of motions, of sections and of the period map, against heyoka in extended precision."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

import remanent as rm
from benchmarks.errors.batches import Batch, random_batch
from benchmarks.errors.motion import Motion
from benchmarks.errors.period_map import LONG
from benchmarks.errors.row import Judged, Row
from remanent._typing import FloatArray

#: Cases of one call.
_CASES_PER_BATCH = 20
#: Periods of runs, at most.
_MAX_PERIODS = 12
#: Periods that pass before those of a sweep that are kept.
_DISCARDED = 20
#: States of one map that are judged together.
_STATES_PER_MAP = 10


def _judged(batch: Batch, case: str, reported: Any, true: Any, scale: Any) -> Judged:
    return Judged(case, batch.tolerance, batch.damped, float(reported), float(true), float(scale))


def _path(batch: Batch, k: int, periods: int) -> FloatArray:
    """Exact states of one case from rest, after 0, 1 ... periods, (period, 2), extended."""
    reference, states = batch.reference(k), [np.array([1, 0], dtype=LONG)]
    for _ in range(periods):
        states.append(reference.image(states[-1], 1)[0])
    return np.array(states)


def _states(rng: np.random.Generator) -> Iterator[Judged]:
    """The largest error of each motion at the ends of periods, from those of one length."""
    batch = random_batch(rng, _CASES_PER_BATCH)
    periods = int(rng.integers(1, _MAX_PERIODS))
    batch.over["omega"][:] = batch.over["omega"][0]  # they share their times
    times = np.arange(periods + 1) * np.pi / float(batch.over["omega"][0])
    found = rm.simulate(
        batch.system, batch.drive, times=times, over=batch.over, tolerance=batch.tolerance
    )
    for k in range(batch.count):
        one = found.isel(case=k)
        if int(one.status) != rm.Status.OK:
            continue
        exact = _path(batch, k, periods)
        case = f"{batch.described(k)}, periods={periods}"
        yield from _judged_path(batch, one, exact, case)
        # The load vanishes at the ends of periods, and with it the energy in the field.
        energy = Motion(batch.reference(k)).stored_energy(exact)
        off = np.abs(one.energy.values - energy).max()
        yield _judged(batch, f"{case}, energy", one.energy_error, off, np.abs(energy).max())


def _section(rng: np.random.Generator) -> Iterator[Judged]:
    """The largest error of each section: of states, and of what is observed of them."""
    batch = random_batch(rng, _CASES_PER_BATCH)
    periods = int(rng.integers(1, 2 * _MAX_PERIODS))
    found = rm.poincare_section(
        batch.system, batch.drive, periods=periods, over=batch.over, tolerance=batch.tolerance
    )
    for k in range(batch.count):
        one = found.isel(case=k)
        if int(one.status) != rm.Status.OK:
            continue
        case = f"{batch.described(k)}, periods={periods}"
        yield from _judged_path(batch, one, _path(batch, k, periods), case)


def _judged_path(batch: Batch, one: xr.Dataset, exact: FloatArray, case: str) -> Iterator[Judged]:
    """The largest errors of states along a path, and of what is observed of them."""
    x, v = exact.T
    columns = {
        "error": {"stretch": x, "stretch_rate": v},
        "thickness_stretch_error": {"thickness_stretch": x**-2},
        "thickness_stretch_rate_error": {"thickness_stretch_rate": -2 * v * x**-3},
    }
    for error, variables in columns.items():
        off = max(np.abs(one[name].values - values).max() for name, values in variables.items())
        size = max(np.abs(values).max() for values in variables.values())
        yield _judged(batch, f"{case}, {error}", one[error], off, size)


def _sweeps(rng: np.random.Generator) -> Iterator[Judged]:
    """The largest error of one period among those kept at each value of a sweep."""
    batch = random_batch(rng, _CASES_PER_BATCH)
    values = np.sort(rng.uniform(0.1, 1.0, 3))
    over = {name: column for name, column in batch.over.items() if name != "b"}
    found = rm.bifurcation_diagram(
        batch.system, batch.drive, "b", values, discard=_DISCARDED, keep=4, over=over,
        tolerance=batch.tolerance,
    )  # fmt: skip
    for k in range(batch.count):
        number = int(rng.integers(values.size))
        one = found.isel(case=k, b=number)
        if int(one.status) != rm.Status.OK:
            continue
        reference = batch.reference(k)
        reference = type(reference)(
            reference.drive, {**reference.values, "b": float(values[number])}
        )
        seen = np.column_stack([one.stretch.values, one.stretch_rate.values])
        images = np.array([reference.image(state, 1)[0] for state in seen[:-1]])
        case = f"{batch.described(k)}, swept to b={values[: number + 1].tolist()}"
        off = np.abs(seen[1:] - images).max()
        yield _judged(batch, case, one.local_error, off, np.abs(seen).max())


def _map(rng: np.random.Generator, name: str) -> Iterator[Judged]:
    """Entries of images or Jacobians of some states of one map."""
    batch = random_batch(rng, 1)
    values = batch.values(0)
    body = rm.Actuator(
        c=values["c"], temperature=values["temperature"], prestress=values["prestress"],
        dissipation=rm.Rayleigh(values["dissipation.0.eta"]) if batch.damped else (),
    )  # fmt: skip
    drive, periods = rm.SineSquared(values["b"], values["omega"]), int(rng.integers(1, 4))
    states = np.column_stack(
        [rng.uniform(0.7, 1.6, _STATES_PER_MAP), rng.uniform(-0.4, 0.4, _STATES_PER_MAP)]
    )
    found = rm.period_map(body, drive, orbit_period=periods, tolerance=batch.tolerance)(states)
    for k, state in enumerate(states):
        image, jacobian = batch.reference(0).image(state, periods)
        exact = image if name == "images" else jacobian
        off = np.abs(getattr(found, name)[k] - exact)
        error = getattr(found, f"{name}_error")[k]
        worst = np.unravel_index(int((off / error).argmax()), off.shape)
        case = f"{batch.described(0)}, orbit_period={periods}, state={state.tolist()}, {worst}"
        yield _judged(batch, case, error[worst], off[worst], abs(exact[worst]))


ROWS = (
    Row(
        "states of motions",
        "simulate: error, thickness_stretch_error, thickness_stretch_rate_error, energy_error",
        _states,
    ),
    Row(
        "states of sections",
        "poincare_section: error, thickness_stretch_error, thickness_stretch_rate_error",
        _section,
    ),
    Row("periods of sweeps", "bifurcation_diagram: local_error", _sweeps),
    Row("images of states", "period_map: images_error", lambda rng: _map(rng, "images")),
    Row("Jacobians of the period map", "period_map: jacobians_error",
        lambda rng: _map(rng, "jacobians")),
)  # fmt: skip
