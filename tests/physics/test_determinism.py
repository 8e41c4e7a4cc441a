"""Determinism: bits that depend on the trajectory alone, for every drive."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from remanent._typing import FloatArray, IntArray
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Outcome, Request
from remanent.integrate.ensemble.work_sizes import DEFAULT_WORK_SIZES, WorkSizes
from remanent.models.drives.base import Drive
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.response.frequency_response import thickness_extremes_over_window
from tests.physics.independent import DRIVES, random_drive

COUNT, LONGEST = 20, 18.0
#: What is asked: states between steps, states after cycles, extremes.
ASKED = ("times", "strobe", "extremes")


def fields(rng: np.random.Generator) -> dict[str, FloatArray]:
    """Slender and stout, damped: resolutions from low to high."""
    return {
        "c": 10.0 ** rng.uniform(-3.0, 0.0, COUNT),
        "temperature": 293.0 * rng.uniform(0.5, 2.0, COUNT),
        "prestress": rng.uniform(-1.0, 2.0, COUNT),
        "dissipation.0.eta": 10.0 ** rng.uniform(-3.0, 0.0, COUNT),
    }


def run(
    drive: Drive,
    asked: str,
    which: IntArray,
    workers: int = 2,
    sizes: WorkSizes = DEFAULT_WORK_SIZES,
) -> list[Any]:
    """Everything that is answered of some of the trajectories, each as long as its own."""
    rng = np.random.default_rng(12)
    values, duration = fields(rng), rng.uniform(1.0, LONGEST, COUNT)
    over = {name: xr.DataArray(v[which], dims="case") for name, v in values.items()}
    body = rm.Actuator(dissipation=rm.Rayleigh(0.1))
    end = duration[which]
    request = {
        "times": Request(times=np.linspace(0.0, 1.0, 23) * end[:, None]),
        "strobe": Request(strobe_cycles=2),
        "extremes": Request(wants_extremes=True, extremes_begin=0.3 * end),
    }[asked]
    whole = initial_value_problem(lay_out_ensemble(body, drive, over), end)
    outcome = integrate(whole, request, tolerance=1e-8, workers=workers, sizes=sizes)
    found = columns(outcome)
    if asked == "strobe":
        # after its end a trajectory goes on for the sake of longer ones only
        own = np.floor(end / (2.0 * (drive.period or np.inf))).astype(int) + 1
        found[-1] = [row[:count] for row, count in zip(found[-1], own, strict=True)]
    return found


def columns(outcome: Outcome) -> list[Any]:
    names = ("maximum", "minimum", "error", "horizon", "status", "resolution")
    states = [] if outcome.states is None else [outcome.states]
    return [*(getattr(outcome, name) for name in names), *states]


def assert_same(found: list[Any], reference: list[Any], which: IntArray) -> None:
    for a, b in zip(found, reference, strict=True):
        for k, row in enumerate(which):
            np.testing.assert_array_equal(a[k], b[row])


def kinds() -> list[Any]:
    """Every drive with states, the periodic ones with everything."""
    pairs = [(kind, "times") for kind in DRIVES]
    pairs += [(kind, asked) for kind in (rm.Sine, rm.SineSquared) for asked in ASKED[1:]]
    return [pytest.param(*pair, id=f"{pair[0].__name__}-{pair[1]}") for pair in pairs]


@pytest.mark.parametrize(("kind", "asked"), kinds())
def test_bits_depend_on_nothing_but_the_trajectory(kind: type[Drive], asked: str) -> None:
    """Reordered, alone, in parts, by one thread, in small chunks: every bit the same.

    Law: Determinism.
    """
    drive = random_drive(kind, np.random.default_rng([7, DRIVES.index(kind)]), LONGEST)
    everybody = np.arange(COUNT)
    reference = run(drive, asked, everybody)
    mixed = np.random.default_rng(8).permutation(COUNT)
    for which in (mixed, mixed[:9], mixed[9:], mixed[:1]):
        assert_same(run(drive, asked, which), reference, which)
    assert_same(run(drive, asked, everybody, workers=1), reference, everybody)
    sizes = WorkSizes(fine_steps_per_chunk=1, samples_per_block=7)
    assert_same(run(drive, asked, everybody, workers=3, sizes=sizes), reference, everybody)


@pytest.mark.parametrize(("kind", "asked"), kinds())
def test_bits_do_not_depend_on_the_length_of_segments(kind: type[Drive], asked: str) -> None:
    """Determinism: a run cut into kernel calls of any length."""
    drive = random_drive(kind, np.random.default_rng([7, DRIVES.index(kind)]), LONGEST)
    everybody = np.arange(COUNT)
    reference = run(drive, asked, everybody)
    for steps in (64, 300):
        sizes = WorkSizes(min_fine_steps_per_segment=steps, max_fine_steps_per_segment=steps)
        assert_same(run(drive, asked, everybody, sizes=sizes), reference, everybody)


def answers(verb: str, drive: Drive, over: dict[str, Any]) -> xr.Dataset:
    """What a verb says of the motion under a drive."""
    body = rm.Actuator(dissipation=rm.Rayleigh(0.1))
    if verb == "simulate":
        return rm.simulate(body, drive, times=np.linspace(0.0, 30.0, 77), over=over)
    if verb == "crossings":
        return rm.crossings(body, drive, "thickness_stretch_rate", 0.0, duration=30.0, over=over)
    return rm.energy_balance(body, drive, duration=30.0, over=over)


@pytest.mark.parametrize("drive", [rm.Sine(0.5, 3.0, 0.1), rm.Constant(0.2)], ids=["sine", "level"])
@pytest.mark.parametrize(
    "verb", ["simulate", "crossings", pytest.param("energy_balance", marks=pytest.mark.slow)]
)
def test_verbs_do_not_depend_on_the_size_of_over(verb: str, drive: Drive) -> None:
    """Determinism: one case, 8 cases, and 2048 cases of ``over`` agree bit for bit."""
    count = 2048
    rng = np.random.default_rng(4)
    values = {
        "c": 10.0 ** rng.uniform(-3.0, 0.0, count),
        "temperature": 293.0 * rng.uniform(0.5, 2.0, count),
        "prestress": rng.uniform(-1.0, 2.0, count),
    }

    def over(rows: IntArray) -> dict[str, Any]:
        return {name: xr.DataArray(v[rows], dims="case") for name, v in values.items()}

    large = answers(verb, drive, over(np.arange(count)))
    order = rng.permutation(count)
    for rows in (order[:8], order[8:9]):
        small = answers(verb, drive, over(rows))
        # The table of crossings is as wide as the longest row needs.
        select: dict[Hashable, Any] = {name: slice(0, n) for name, n in small.sizes.items()}
        xr.testing.assert_equal(small, large.isel({**select, "case": rows}))


def test_verbs_are_deterministic_in_any_order() -> None:
    """Determinism: reversed values of ``over`` give the reversed results, bit for bit."""
    rng = np.random.default_rng(3)
    values = fields(rng)
    body, drive = rm.Actuator(dissipation=rm.Rayleigh(0.1)), rm.SineSquared(0.9, 1.3)

    def answered(step: int) -> xr.Dataset:
        over = {name: xr.DataArray(v[::step], dims="case") for name, v in values.items()}
        return rm.frequency_response(body, drive, [0.8, 1.6], duration=12.0, over=over)

    there, back = answered(1), answered(-1)
    for name in ("maximum", "minimum", "amplitude_error", "status", "horizon"):
        there_values = there[name].transpose("case", "omega").values
        np.testing.assert_array_equal(there_values[::-1], back[name].transpose("case", "omega"))


def test_bits_do_not_depend_on_the_batches_of_a_response() -> None:
    """Determinism: a response worked out in batches is the one worked out at once."""
    over = {"omega": np.linspace(0.5, 2.0, 100)}
    actuator, drive = rm.Actuator(temperature=350), rm.SineSquared(0.4, 1.0)
    columns = []
    for size in (100, 37):
        ens = lay_out_ensemble(actuator, drive, over, batch_size=size)
        outcome = thickness_extremes_over_window(ens, 100.0, None, 0.0, 1e-7, batch_size=size)
        columns.append([outcome.maximum, outcome.minimum, outcome.error, outcome.status])
    for at_once, batched in zip(*columns, strict=True):
        np.testing.assert_array_equal(at_once, batched)
