"""The orbits whose regime is asked for, and how they are looked at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.regimes.agreement import DEFAULT_REGIME_RULES, RegimeRules, agreed_regime
from remanent.analysis.regimes.collection import (
    INDICATOR_FUNCTIONS,
    ObservablesFunction,
    collect_evidence,
    states_as_observables,
)
from remanent.analysis.regimes.evidence import EvidenceTable
from remanent.analysis.regimes.limit_orbits import IterateWithJacobian
from remanent.analysis.regimes.long_runs import LongRun
from remanent.analysis.regimes.orbit_batch import IndicatorFunction
from remanent.analysis.regimes.thresholds import RegimeThresholds
from remanent.analysis.regimes.transients import ToleranceRunFunction


@dataclass(frozen=True)
class RegimeProblem:
    """The orbits whose regime is asked for, and how they are looked at.

    Attributes
    ----------
    run_at_tolerance : ToleranceRunFunction
        Follows some of the orbits at one of three tolerances.
    orbit_count : int
        How many orbits there are.
    damped : array (orbit,) of bool
        Where motion contracts.
    iterate_with_jacobian : callable, optional
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
    thresholds : RegimeThresholds
        What it is compared with.
    """

    run_at_tolerance: ToleranceRunFunction
    orbit_count: int
    damped: BoolArray
    iterate_with_jacobian: IterateWithJacobian | None = None
    seed: int = 0
    observables: ObservablesFunction = states_as_observables
    indicators: Mapping[str, IndicatorFunction] = field(default_factory=lambda: INDICATOR_FUNCTIONS)
    rules: RegimeRules = DEFAULT_REGIME_RULES
    thresholds: RegimeThresholds = field(default_factory=RegimeThresholds)

    def evidence_of_run(self, run: LongRun, orbits: IntArray) -> EvidenceTable:
        """The evidence of a run of some orbits."""
        return collect_evidence(
            run,
            damped=self.damped[orbits],
            seed=self.seed,
            observables=self.observables,
            indicators=self.indicators,
        )

    def agreed_regime(
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
