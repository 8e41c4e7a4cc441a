"""Collecting the evidence of a run: exponents, returns, rotation, and the indicators."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.regimes.bands import convergence_digits_within_bands, relative_band_scatter
from remanent.analysis.regimes.birkhoff import birkhoff_convergence_digits, rotation_numbers
from remanent.analysis.regimes.evidence import EvidenceTable
from remanent.analysis.regimes.indicators import smaller_alignment_index, zero_one_test
from remanent.analysis.regimes.long_runs import LongRun
from remanent.analysis.regimes.lyapunov import DEFAULT_TRANSIENT_SHARE, lyapunov_exponents
from remanent.analysis.regimes.orbit_batch import IndicatorFunction, OrbitBatch
from remanent.analysis.regimes.returns import find_best_returns
from remanent.analysis.regimes.thresholds import MAX_CLOSED_RETURN_DEFECT

#: Share of a damped motion at the beginning that is left out.
_OMITTED_SHARE_OF_DAMPED_RUN = 0.4
#: Orbits looked at together, so that their points stay in the cache.
_ORBITS_PER_BATCH = 128

#: ``observables(states)`` of states (..., state) gives bounded numbers (..., observable).
ObservablesFunction = Callable[[FloatArray], FloatArray]


def states_as_observables(states: FloatArray) -> FloatArray:
    """The states themselves as observables."""
    return states


def _birkhoff_digits(batch: OrbitBatch) -> FloatArray:
    """Digits to which weighted averages agree, the fewest over the observables."""
    return np.asarray(
        birkhoff_convergence_digits(np.moveaxis(batch.observable_values, 1, 2)).min(axis=1)
    )


def _zero_one_statistic(batch: OrbitBatch) -> FloatArray:
    """The 0-1 test of the first observable."""
    return zero_one_test(batch.observable_values[:, :, 0], rng=np.random.default_rng(batch.seed))


def _final_alignment_index(batch: OrbitBatch) -> FloatArray:
    """Smaller alignment index at the end, NaN with one tangent."""
    if batch.triangular_factors.shape[2] < 2:
        return np.full(len(batch.triangular_factors), np.nan)
    return smaller_alignment_index(batch.triangular_factors)[:, -1]


#: The indicators, by the names of their columns.  A further one is a file with a function of
#: an :class:`OrbitBatch` and a line here; the rules in `agreement.py` may then ask for it.
INDICATOR_FUNCTIONS: Mapping[str, IndicatorFunction] = MappingProxyType(
    {
        "digits": _birkhoff_digits,
        "banded_digits": convergence_digits_within_bands,
        "relative_band_scatter": relative_band_scatter,
        "zero_one": _zero_one_statistic,
        "sali": _final_alignment_index,
    }
)


def collect_evidence(
    run: LongRun,
    *,
    damped: BoolArray,
    seed: int = 0,
    observables: ObservablesFunction = states_as_observables,
    indicators: Mapping[str, IndicatorFunction] = INDICATOR_FUNCTIONS,
) -> EvidenceTable:
    """Collect the evidence of one run.

    Parameters
    ----------
    run : LongRun
        With all states; orbits that ended early give NaN.
    damped : array (orbit,) of bool
        Where motion contracts, so that its beginning is a transient.
    seed : int
        For the random frequencies of the 0-1 test, the same for every orbit.
    observables : callable
        Of states (..., state), bounded functions (..., observable): cosine and sine for an
        angle.
    indicators : mapping of name to callable
        Of an :class:`~remanent.analysis.regimes.orbit_batch.OrbitBatch`.
    """
    groups = (np.flatnonzero(~damped), 0.0), (np.flatnonzero(damped), _OMITTED_SHARE_OF_DAMPED_RUN)
    batches = [
        (batch, _evidence_columns(run, batch, transient, seed, observables, indicators))
        for orbits, transient in groups
        for batch in np.array_split(orbits, -(-orbits.size // _ORBITS_PER_BATCH) or 1)
    ]
    order = np.argsort(np.concatenate([batch for batch, _ in batches]), kind="stable")
    names = batches[0][1]
    return EvidenceTable.from_columns(
        {name: np.concatenate([columns[name] for _, columns in batches])[order] for name in names}
    )


def _evidence_columns(
    run: LongRun,
    orbits: IntArray,
    transient: float,
    seed: int,
    observables: ObservablesFunction,
    indicators: Mapping[str, IndicatorFunction],
) -> dict[str, FloatArray | IntArray]:
    """The columns of some orbits, the first `transient` of whose run is left out."""
    assert run.visited_states is not None
    points = observables(run.visited_states[orbits, int(transient * run.periods) :])
    batch = OrbitBatch(points, run.triangular_factors[orbits], seed)
    return {
        **_growth_columns(run.log_growth[orbits], run.block_lengths_in_periods, transient),
        **_return_and_rotation_columns(points),
        **{name: indicator(batch) for name, indicator in indicators.items()},
    }


def _growth_columns(
    growth: FloatArray, lengths: IntArray, transient: float
) -> dict[str, FloatArray | IntArray]:
    """Exponent and growth of the first tangent."""
    # Tangents need a while to turn to the direction that grows, damped or not.
    statistics = lyapunov_exponents(
        growth[:, :, :1], lengths, transient=max(transient, DEFAULT_TRANSIENT_SHARE)
    )
    logs = np.cumsum(growth[:, int(transient * lengths.size) :, 0], axis=1)
    quarter = max(logs.shape[1] // 4, 1)
    half = logs[:, logs.shape[1] // 2]
    with np.errstate(invalid="ignore"):  # growth that no number can hold says nothing
        late = logs[:, -quarter:].mean(axis=1) - logs[:, quarter : 2 * quarter].mean(axis=1)
        second_half = logs[:, -1] - half
    return {
        "exponent": statistics.mean[:, 0],
        "exponent_error": statistics.batch_error[:, 0],
        "swing_error": statistics.error[:, 0],
        "finite_time_error": statistics.finite_time_error[:, 0],
        "log_growth": logs[:, -1],
        "log_growth_of_halves": np.column_stack([half, second_half]),
        "late_log_growth": late,
    }


def _return_and_rotation_columns(points: FloatArray) -> dict[str, FloatArray | IntArray]:
    """How the orbits return, and how they turn about their middle."""
    best = find_best_returns(points, closed=MAX_CLOSED_RETURN_DEFECT)
    columns: dict[str, FloatArray | IntArray] = {
        "period": best.period,
        "defect": best.return_defect,
        "late_defect": best.late_return_defect,
        "extent": best.extent,
        "rotation_number": np.full(len(points), np.nan),
        "rotation_error": np.full(len(points), np.nan),
        "rotation_digits": np.zeros(len(points)),
    }
    if points.shape[2] > 1:
        rotation = rotation_numbers(points[:, :, :2])
        columns |= {
            "rotation_number": rotation.turns_per_iterate,
            "rotation_error": rotation.error,
            "rotation_digits": rotation.converged_digits,
        }
    return columns
