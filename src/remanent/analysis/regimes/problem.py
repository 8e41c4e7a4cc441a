"""The orbits whose regime is asked for, and how they are looked at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.regimes.agreement import RULES, RegimeRules, agreed_regime
from remanent.analysis.regimes.collection import (
    INDICATOR_FUNCTIONS,
    Observables,
    collect_evidence,
    state_observables,
)
from remanent.analysis.regimes.evidence import EvidenceTable
from remanent.analysis.regimes.limit_orbits import IterateMap
from remanent.analysis.regimes.long_runs import LongRun
from remanent.analysis.regimes.orbit_batch import Indicator
from remanent.analysis.regimes.thresholds import Thresholds
from remanent.analysis.regimes.transients import RunAtTolerance


@dataclass(frozen=True)
class RegimeProblem:
    """The orbits whose regime is asked for, and how they are looked at.

    Attributes
    ----------
    run : RunAtTolerance
        Follows some of the orbits at one of three tolerances.
    count : int
        How many orbits there are.
    damped : array (orbit,) of bool
        Where motion contracts.
    iterate : callable, optional
        Images and Jacobians of the orbits' maps; without it nothing is said of motion that
        has not settled.
    seed : int
        For the frequencies of the 0-1 test.
    observables : callable
        Bounded functions of the states.
    indicators : mapping of name to callable
        What is computed from the orbits.
    rules : sequence of (Regime, callable)
        What the evidence is judged by.
    thresholds : Thresholds
        What it is compared with.
    """

    run: RunAtTolerance
    count: int
    damped: BoolArray
    iterate: IterateMap | None = None
    seed: int = 0
    observables: Observables = state_observables
    indicators: Mapping[str, Indicator] = field(default_factory=lambda: INDICATOR_FUNCTIONS)
    rules: RegimeRules = RULES
    thresholds: Thresholds = field(default_factory=Thresholds)

    def evidence(self, run: LongRun, orbits: IntArray) -> EvidenceTable:
        """The evidence of a run of some orbits."""
        return collect_evidence(
            run,
            damped=self.damped[orbits],
            seed=self.seed,
            observables=self.observables,
            indicators=self.indicators,
        )

    def agreed(
        self, runs: list[EvidenceTable], orbits: IntArray, periods: int
    ) -> tuple[IntArray, FloatArray]:
        """The regime that runs of some orbits agree on, and the margin."""
        return agreed_regime(
            runs,
            damped=self.damped[orbits],
            periods=periods,
            thresholds=self.thresholds,
            rules=self.rules,
        )
