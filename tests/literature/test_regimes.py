"""Labels of a thousand motions against references that no label of ours went into.

The cases and how their truth was found: ``regimes/README.md``.

Law: Chaos needs two witnesses.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path as File
from typing import Any

import numpy as np
import pytest
import xarray as xr

from remanent._typing import FloatArray, IntArray
from remanent.analysis.regimes.collection import states_as_observables
from remanent.analysis.regimes.decision import decide_regimes
from remanent.analysis.regimes.labels import Regime
from remanent.analysis.regimes.long_runs import LongRun, TangentMap, propagate_tangents
from remanent.analysis.regimes.problem import RegimeProblem
from remanent.integrate.maps.advance import BlockAdvancer, BlockImage
from remanent.integrate.maps.period_map import PeriodMap
from remanent.models.actuator import Actuator
from remanent.models.dissipation import Rayleigh
from remanent.models.drives.base import Drive
from remanent.models.drives.waves import SineSquared
from remanent.models.system import System
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.ensemble.problem import initial_value_problem
from tests.literature.oscillators import COSINE, OSCILLATOR, PENDULUM
from tests.unit.analysis.regimes.iterated import Iterated, henon, logistic, rolled, standard

CASES: list[dict[str, Any]] = json.loads(
    (File(__file__).parent / "regimes" / "cases.json").read_text("utf-8")
)["cases"]
TOLERANCES = (1e-9, 1e-8, 1e-7)
#: Chaos that ends after the run looks like any other.
LATER = "settled"


@dataclass
class Rolling:
    """A pendulum's angle stays within a turn, where its error is small."""

    flow: BlockAdvancer

    def __call__(
        self,
        which: IntArray,
        states: FloatArray,
        tangents: FloatArray,
        periods: int,
        *,
        every: bool,
    ) -> BlockImage:
        wound = states.copy()
        wound[:, 0] = np.remainder(wound[:, 0] + np.pi, 2.0 * np.pi) - np.pi
        return self.flow(which, wound, tangents, periods, every=every)


def forced(
    system: System, drive: Drive, values: dict[str, FloatArray], tolerance: float, count: int
) -> BlockAdvancer:
    """Motions of a system, one for each set of values of its numeric fields and the drive's."""
    over = {name: xr.DataArray(v, dims="case") for name, v in values.items()}
    ens = lay_out_ensemble(system, drive, over)
    asked, length = initial_value_problem(ens, np.ones(ens.trajectory_count)), ens.drive_periods()
    assert length is not None
    flow = PeriodMap(asked.field, asked.load_schedule.waveforms_at_phase, directions=count)
    return BlockAdvancer(flow, asked.parameters, length, tolerance)


def oscillator(par: FloatArray, tolerance: float, count: int) -> TangentMap:
    names = ("omega", "d", "g", "a", "e", "k", "F")
    values = dict(zip(names, par.T, strict=True))
    return forced(OSCILLATOR, COSINE, values, tolerance, count)


def pendulum(par: FloatArray, tolerance: float, count: int) -> TangentMap:
    values = dict(zip(("omega", "d", "F"), par.T, strict=True))
    return Rolling(forced(PENDULUM, COSINE, values, tolerance, count))


def actuator(par: FloatArray, tolerance: float, count: int) -> TangentMap:
    names = ("omega", "temperature", "prestress", "b", "c", "dissipation.0.eta")
    values = par * [1.0, 293.0, 1.0, 1.0, 1.0, 1.0]
    damped = Actuator(dissipation=Rayleigh(0.1))
    over = dict(zip(names, values.T, strict=True))
    return forced(damped, SineSquared(0.4, 1.0), over, tolerance, count)


def plain_map(step: Any) -> Callable[..., TangentMap]:
    """A map is exact: nothing depends on the tolerance."""

    def make(par: FloatArray, _: float, _count: int) -> TangentMap:
        return Iterated(step, par)

    return make


def winding(y: FloatArray) -> FloatArray:
    """Cosine and sine of the angle, and the rate."""
    return np.stack([np.cos(y[..., 0]), np.sin(y[..., 0]), y[..., 1]], axis=-1)


FAMILIES: dict[str, tuple[Callable[..., TangentMap], Any]] = {
    "actuator": (actuator, states_as_observables),
    "oscillator": (oscillator, states_as_observables),
    "pendulum": (pendulum, winding),
    "standard": (plain_map(standard), rolled),
    "logistic": (plain_map(logistic), states_as_observables),
    "henon": (plain_map(henon), states_as_observables),
}


def label(cases: list[dict[str, Any]], periods: int) -> list[tuple[str, int]]:
    """Regime and period of cases of one family."""
    family = cases[0]["family"]
    make, observables = FAMILIES[family]
    parameters = np.array([case["parameters"] for case in cases])
    start = np.array([case["initial"] for case in cases])
    start = start[:, :1] if family == "logistic" else start
    dimension = start.shape[1]

    def run(which: IntArray, n: int, states: FloatArray | None = None, /) -> LongRun:
        count = dimension if n == 0 else 1
        advance = make(parameters[which], TOLERANCES[n], count)
        begin = start[which] if states is None else states
        return propagate_tangents(advance, begin, periods, directions=count, every=True)

    finest = make(parameters, TOLERANCES[0], dimension)

    def iterate(which: IntArray, states: FloatArray, period: int) -> tuple[FloatArray, FloatArray]:
        unit = np.tile(np.eye(dimension), (which.size, 1, 1))
        image = finest(which, states, unit, period, every=False)
        return image.visited_states[:, -1], np.moveaxis(image.tangents, 1, 2)

    problem = RegimeProblem(
        run,
        len(cases),
        damped=np.array([case["dissipative"] for case in cases]),
        iterate_with_jacobian=iterate,
        observables=observables,
    )
    verdict, _ = decide_regimes(problem)
    names = [Regime(code).meaning for code in verdict.regime]
    return list(zip(names, verdict.period.tolist(), strict=True))


def confusion(cases: list[dict[str, Any]], periods: int) -> tuple[Counter[Any], list[str]]:
    """Counts of (truth, label), and what is wrong."""
    counts: Counter[Any] = Counter()
    wrong: list[str] = []
    for family in FAMILIES:
        some = [case for case in cases if case["family"] == family]
        for case, (name, period) in zip(some, label(some, periods) if some else [], strict=True):
            truth = case["truth"]
            counts[truth, name] += 1
            if (
                truth != "undecided"
                and name != "undecided"
                and not right(case, name, period, periods)
            ):
                wrong.append(
                    f"{case['id']} {case['group']}: {truth} {case['period']}, {name} {period}"
                )
    return counts, wrong


def right(case: dict[str, Any], name: str, period: int, periods: int) -> bool:
    """Whether a label is true, as far as a run of this length can know."""
    settled = case["evidence"].get(LATER)
    if case["truth"] == "periodic" and name == "chaotic":
        return bool(settled is not None and settled > periods)
    if name != case["truth"]:
        return False
    if name != "periodic" or case["period"] == period:
        return True
    # Where the reference returns to within rounding, a multiple may return exactly.
    return bool(case["period"] % period == 0 and case["evidence"]["defect"] < 1e-10)


def undecided(counts: Counter[Any]) -> float:
    """Share of undecided labels among motions of known regime."""
    known = {key: n for key, n in counts.items() if key[0] != "undecided"}
    return sum(n for (_, name), n in known.items() if name == "undecided") / sum(known.values())


def test_every_twentieth_motion() -> None:
    """No wrong label after 500 periods, and few undecided."""
    counts, wrong = confusion(CASES[::20], 500)
    assert not wrong
    assert undecided(counts) < 0.12


@pytest.mark.slow
@pytest.mark.parametrize(("periods", "share"), [(500, 0.10), (2000, 0.05)])
def test_all_motions(periods: int, share: float) -> None:
    """No wrong label, and hardly any undecided: the confusion is printed."""
    counts, wrong = confusion(CASES, periods)
    print(periods, dict(sorted(counts.items())))
    assert not wrong
    assert undecided(counts) < share
