"""The evidence about many orbits at one tolerance: one table, one row for each orbit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.regimes.birkhoff import overlapping_digits, rotation_numbers
from remanent.analysis.regimes.indicators import smaller_alignment_index, zero_one_test
from remanent.analysis.regimes.long_runs import LongRun
from remanent.analysis.regimes.lyapunov import TRANSIENT_SHARE, lyapunov_exponents
from remanent.analysis.regimes.returns import find_best_returns
from remanent.analysis.regimes.thresholds import MAX_CLOSED_DEFECT

#: Share of a damped motion at the beginning that is left out.
_DAMPED_TRANSIENT_SHARE = 0.4
#: Orbits looked at together, so that their points stay in the cache.
_ORBITS_PER_BATCH = 128
#: Numbers of bands that an orbit may visit in turn.
_BAND_COUNTS = (2, 4, 8, 16, 3, 6, 12)
#: Scatter within a band relative to that of all points, at most.
_MAX_BAND_SCATTER = 0.5
#: Fewest points that an average within a band is made of.
_MIN_BAND_POINTS = 24


@dataclass(frozen=True)
class EvidenceTable:
    """Numbers about many orbits at one tolerance, arrays (orbit,) unless said otherwise.

    A table is never changed: :meth:`subset` and :meth:`with_rows` give new ones.

    Attributes
    ----------
    exponent, exponent_error
        Largest Lyapunov exponent per period, and its standard error.
    growth
        Logarithm of the tangent's growth over the run, without the transient.
    half_growths : array (orbit, 2)
        The same over the two halves of that.
    late_growth
        Its mean over the last quarter less that over the second.
    digits
        Digits to which weighted averages agree, the fewest over the observables.
    banded_digits
        The same within the bands of an orbit that visits bands in turn.
    band_extent
        Scatter of every eighth point relative to that of all points.
    zero_one
        Result of the 0-1 test.
    sali
        Smaller alignment index at the end, NaN with one tangent.
    rotation_number, rotation_digits
        Turns per period about the middle of the orbit, and how many of their digits agree.
    period : array (orbit,) of int
        After how many periods the orbit comes back best.
    defect, late_defect
        How far from itself it comes back after that, relative to its extent: over the run
        without the transient, and over its last quarter.
    extent
        Of the orbit.
    """

    exponent: FloatArray
    exponent_error: FloatArray
    growth: FloatArray
    half_growths: FloatArray
    late_growth: FloatArray
    digits: FloatArray
    banded_digits: FloatArray
    band_extent: FloatArray
    zero_one: FloatArray
    sali: FloatArray
    rotation_number: FloatArray
    rotation_digits: FloatArray
    period: IntArray
    defect: FloatArray
    late_defect: FloatArray
    extent: FloatArray

    def subset(self, indices: IntArray | BoolArray) -> EvidenceTable:
        """The rows of some orbits."""
        return EvidenceTable(*(getattr(self, f.name)[indices] for f in fields(self)))

    def with_rows(self, indices: IntArray, rows: EvidenceTable) -> EvidenceTable:
        """A table in which the rows of some orbits are replaced."""
        values = {f.name: getattr(self, f.name).copy() for f in fields(self)}
        for name, value in values.items():
            value[indices] = getattr(rows, name)
        return EvidenceTable(**values)


#: ``observables(states)`` of states (..., state) gives bounded numbers (..., observable).
Observables = Callable[[FloatArray], FloatArray]


def state_observables(states: FloatArray) -> FloatArray:
    """The states themselves as observables."""
    return states


def collect_evidence(
    run: LongRun,
    *,
    damped: BoolArray,
    seed: int = 0,
    observables: Observables = state_observables,
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
    """
    groups = (np.flatnonzero(~damped), 0.0), (np.flatnonzero(damped), _DAMPED_TRANSIENT_SHARE)
    batches = [
        (batch, _batch_evidence(run, batch, transient, seed, observables))
        for indices, transient in groups
        for batch in np.array_split(indices, -(-indices.size // _ORBITS_PER_BATCH) or 1)
    ]
    order = np.argsort(np.concatenate([batch for batch, _ in batches]), kind="stable")
    names = [f.name for f in fields(EvidenceTable)]
    return EvidenceTable(
        *(np.concatenate([getattr(rows, name) for _, rows in batches])[order] for name in names)
    )


def _batch_evidence(
    run: LongRun, indices: IntArray, transient: float, seed: int, observables: Observables
) -> EvidenceTable:
    """The rows of some orbits, whose first `transient` of the run is left out."""
    assert run.visited is not None
    states = run.visited[indices]
    points = observables(states[:, int(transient * run.periods) :])
    growth, lengths = run.growth[indices], run.block_lengths
    # Tangents need a while to turn to the direction that grows, damped or not.
    statistics = lyapunov_exponents(
        growth[:, :, :1], lengths, transient=max(transient, TRANSIENT_SHARE)
    )
    logs = np.cumsum(growth[:, int(transient * lengths.size) :, 0], axis=1)
    quarter = max(logs.shape[1] // 4, 1)
    half = logs[:, logs.shape[1] // 2]
    best = find_best_returns(points, closed=MAX_CLOSED_DEFECT)
    rotation = rotation_numbers(points[:, :, :2]) if points.shape[2] > 1 else None
    nothing = np.full(indices.size, np.nan)
    return EvidenceTable(
        exponent=statistics.mean[:, 0],
        exponent_error=statistics.error[:, 0],
        growth=logs[:, -1],
        half_growths=np.column_stack([half, logs[:, -1] - half]),
        late_growth=logs[:, -quarter:].mean(axis=1) - logs[:, quarter : 2 * quarter].mean(axis=1),
        digits=overlapping_digits(np.moveaxis(points, 1, 2)).min(axis=1),
        banded_digits=_banded_digits(points),
        band_extent=_band_extent(points),
        zero_one=zero_one_test(points[:, :, 0], rng=np.random.default_rng(seed)),
        sali=(
            smaller_alignment_index(run.factors[indices])[:, -1] if growth.shape[2] > 1 else nothing
        ),
        rotation_number=nothing if rotation is None else rotation.number,
        rotation_digits=np.zeros(indices.size) if rotation is None else rotation.digits,
        period=best.period,
        defect=best.defect,
        late_defect=best.late_defect,
        extent=best.extent,
    )


def _banded_digits(points: FloatArray) -> FloatArray:
    """Digits of averages over one band, for orbits that visit bands in turn.

    In banded chaos an orbit steps from band to band as regularly as a clock, and moves
    chaotically within each.  Averages over all points converge because of the first; averages
    over every k-th point, which all lie in one band, show the second.
    """
    values = np.moveaxis(points, 1, 2)
    digits = overlapping_digits(values).min(axis=1)
    extent = np.std(np.ascontiguousarray(values), axis=2)
    for count in _BAND_COUNTS:
        band = np.ascontiguousarray(values[..., ::count])
        with np.errstate(invalid="ignore"):
            narrow = (np.std(band, axis=2) < _MAX_BAND_SCATTER * extent).any(axis=1)
        if narrow.any() and band.shape[2] >= _MIN_BAND_POINTS:
            within = overlapping_digits(band[narrow]).min(axis=1)
            digits[narrow] = np.fmin(digits[narrow], within)
    return np.asarray(digits)


def _band_extent(points: FloatArray) -> FloatArray:
    """Scatter of every eighth point relative to that of all, the least over observables."""
    values = np.moveaxis(points, 1, 2)
    eighth, every = (np.ascontiguousarray(part) for part in (values[..., ::8], values))
    with np.errstate(all="ignore"):
        return np.asarray(np.fmin.reduce(eighth.std(axis=2) / every.std(axis=2), axis=1))
