"""What kind of motion an orbit is: a label only where independent indicators agree.

Three kinds of evidence are weighed, at more than one tolerance: the growth of tangents, the
convergence of weighted averages along the orbit, and its return to the same point.  Where
they disagree, or where the run is too short for them to speak, the label is `undecided`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from enum import IntEnum
from typing import Protocol

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.regimes.birkhoff import overlapping_digits, rotation_numbers
from remanent.analysis.regimes.following import LongRun
from remanent.analysis.regimes.indicators import smaller_alignment_index, zero_one_test
from remanent.analysis.regimes.lyapunov import lyapunov_exponents
from remanent.analysis.regimes.returns import (
    IterateMap,
    approaches_limit,
    find_best_returns,
    find_limit_orbit,
)

#: Return defect of a closed orbit, relative to its extent.
CLOSED = 1e-6


class Regime(IntEnum):
    """The kinds of motion that are told apart."""

    UNDECIDED = 0
    PERIODIC = 1
    QUASI_PERIODIC = 2
    CHAOTIC = 3
    ESCAPED = 4

    @property
    def meaning(self) -> str:
        return self.name.lower().replace("_", "-")


@dataclass(frozen=True)
class Thresholds:
    """Where the lines are drawn.

    Attributes
    ----------
    closed, open
        An orbit whose return defect (relative to its extent) is below the first is closed;
        above the second it is not; between them nobody can tell.
    torus_digits, few_digits, rotation_digits
        Digits of the weighted averages on a torus, at least; or the second, if those of the
        rotation number are at least the third.
    chaos_digits
        Digits of the averages in chaos, at most.
    significance
        Standard errors by which an exponent must exceed 0.
    power, excess
        Tangents grow at most like n e^excess on a torus; in chaos they grow at least like
        n^power e^(2 excess), and by e^half in each half of the run.
    steady, steadier
        Change of the logarithm of a tangent between the second and the last quarter of the
        run, at most, on a torus: n^2 would give 1.7.  The second where digits are few.
    wandering, calm
        The 0-1 test, at most, on a torus; the second where digits are few.
    pieces
        Extent of every eighth point on a torus that attracts, relative to all, at least:
        where periods double for ever, motion is as regular as on a torus, in pieces.
    alike
        Factor between exponents at different tolerances that are the same, at most.
    """

    closed: float = CLOSED
    open: float = 1e-5
    torus_digits: float = 5.0
    few_digits: float = 3.4
    rotation_digits: float = 4.5
    chaos_digits: float = 3.5
    significance: float = 3.0
    power: float = 1.5
    excess: float = 2.0
    half: float = 4.5
    steady: float = 2.5
    steadier: float = 1.5
    wandering: float = 0.4
    calm: float = 0.2
    pieces: float = 0.1
    alike: float = 3.0


@dataclass(frozen=True)
class EvidenceTable:
    """Numbers about many orbits at one tolerance, arrays (orbit,).

    Attributes
    ----------
    exponent, exponent_error
        Largest Lyapunov exponent per period, its standard error.
    growth
        Logarithm of the tangent's growth over the stretch looked at.
    halves : array (orbit, 2)
        The same over its two halves.
    steady
        Its mean over the last quarter less that over the second.
    digits
        Digits to which weighted averages agree, the fewest over the observables.
    banded_digits
        The same within the bands of an orbit that visits some in turn.
    pieces
        Extent of every eighth point relative to that of all.
    zero_one
        Result of the 0-1 test, NaN where it was not needed.
    sali
        Smaller alignment index at the end, NaN with one tangent.
    rotation_number, rotation_digits
        Turns per period about the middle of the orbit, and how many digits agree.
    period, defect, late
        After how many periods the orbit comes back best, to within what part of its
        extent, over the whole stretch and at its end.
    spread
        Its extent.
    """

    exponent: FloatArray
    exponent_error: FloatArray
    growth: FloatArray
    halves: FloatArray
    steady: FloatArray
    digits: FloatArray
    banded_digits: FloatArray
    pieces: FloatArray
    zero_one: FloatArray
    sali: FloatArray
    rotation_number: FloatArray
    rotation_digits: FloatArray
    period: IntArray
    defect: FloatArray
    late: FloatArray
    spread: FloatArray

    def taken(self, which: IntArray | BoolArray) -> EvidenceTable:
        """That of some orbits."""
        return EvidenceTable(*(getattr(self, f.name)[which] for f in fields(self)))


#: Share of a damped motion that is left out.
_TRANSIENT = 0.4
#: Orbits looked at together: their points stay in the cache.
_SLICE = 128


def state_observables(states: FloatArray) -> FloatArray:
    """The states themselves as observables."""
    return states


def collect_evidence(
    path: LongRun,
    *,
    damped: BoolArray,
    seed: int = 0,
    observables: Callable[[FloatArray], FloatArray] = state_observables,
) -> EvidenceTable:
    """Collect the evidence of one run.

    Parameters
    ----------
    path
        With all states; orbits that ended early give NaN.
    damped : array (orbit,) of bool
        Where motion contracts, so that its beginning is a transient.
    seed
        For the random frequencies of the 0-1 test, the same for every orbit.
    observables
        Of states (..., state), bounded functions (..., observable): cosine and sine for an
        angle.
    """
    parts = [
        (some, _gather(path, some, kept, seed, observables))
        for which, kept in ((np.flatnonzero(~damped), 0.0), (np.flatnonzero(damped), _TRANSIENT))
        for some in np.array_split(which, -(-which.size // _SLICE) or 1)
    ]
    order = np.argsort(np.concatenate([some for some, _ in parts]), kind="stable")
    names = [f.name for f in fields(EvidenceTable)]
    return EvidenceTable(
        *(np.concatenate([getattr(part, name) for _, part in parts])[order] for name in names)
    )


def _gather(
    path: LongRun,
    which: IntArray,
    transient: float,
    seed: int,
    observables: Callable[[FloatArray], FloatArray],
) -> EvidenceTable:
    assert path.visited is not None
    states = path.visited[which]
    first = int(transient * path.periods)
    points = observables(states[:, first:])
    growth, lengths = path.growth[which], path.lengths
    statistics = lyapunov_exponents(growth[:, :, :1], lengths, transient=max(transient, 0.1))
    logs = np.cumsum(growth[:, int(transient * lengths.size) :, 0], axis=1)
    quarter = max(logs.shape[1] // 4, 1)
    middle = logs[:, logs.shape[1] // 2]
    back = find_best_returns(points, closed=CLOSED)
    turning = rotation_numbers(points[:, :, :2]) if points.shape[2] > 1 else None
    none = np.full(which.size, np.nan)
    return EvidenceTable(
        exponent=statistics.mean[:, 0],
        exponent_error=statistics.error[:, 0],
        growth=logs[:, -1],
        halves=np.column_stack([middle, logs[:, -1] - middle]),
        steady=logs[:, -quarter:].mean(axis=1) - logs[:, quarter : 2 * quarter].mean(axis=1),
        digits=overlapping_digits(np.moveaxis(points, 1, 2)).min(axis=1),
        banded_digits=_banded(points),
        pieces=_pieces(points),
        zero_one=zero_one_test(points[:, :, 0], rng=np.random.default_rng(seed)),
        sali=smaller_alignment_index(path.factors[which])[:, -1] if growth.shape[2] > 1 else none,
        rotation_number=none if turning is None else turning.number,
        rotation_digits=np.zeros(which.size) if turning is None else turning.digits,
        period=back.period,
        defect=back.defect,
        late=back.late,
        spread=back.spread,
    )


#: Numbers of bands that are looked for, and how narrow they are beside the whole.
_BANDS, _NARROW = (2, 4, 8, 16, 3, 6, 12), 0.5


def _banded(points: FloatArray) -> FloatArray:
    """Digits of averages over one band, for orbits that visit bands in turn.

    The step from band to band is as regular as a clock; it would hide how little the motion
    within the bands is.
    """
    values = np.moveaxis(points, 1, 2)
    digits = overlapping_digits(values).min(axis=1)
    extent = np.std(np.ascontiguousarray(values), axis=2)
    for bands in _BANDS:
        one = np.ascontiguousarray(values[..., ::bands])
        with np.errstate(invalid="ignore"):
            narrow = (np.std(one, axis=2) < _NARROW * extent).any(axis=1)
        if narrow.any() and one.shape[2] >= _SHORTEST:
            own = overlapping_digits(one[narrow]).min(axis=1)
            digits[narrow] = np.fmin(digits[narrow], own)
    return np.asarray(digits)


#: Fewest points of an average.
_SHORTEST = 24


def _pieces(points: FloatArray) -> FloatArray:
    """Scatter of every eighth point relative to that of all, the least over observables."""
    values = np.moveaxis(points, 1, 2)
    some, whole = (np.ascontiguousarray(part) for part in (values[..., ::8], values))
    with np.errstate(all="ignore"):
        return np.asarray(np.fmin.reduce(some.std(axis=2) / whole.std(axis=2), axis=1))


@dataclass(frozen=True)
class RegimeLabels:
    """Labels of many orbits with what decided.

    Attributes
    ----------
    regime : array (orbit,)
        Values of :class:`Regime`.
    period : array (orbit,)
        In periods of the map; 0 where the label is another.
    margin : array (orbit,)
        By what factor the evidence that was nearest to its line is beyond it; NaN where
        nothing was decided.
    evidence
        At the finest tolerance.
    exponent_error : array (orbit,)
        Standard error and spread over the tolerances, together.
    """

    regime: IntArray
    period: IntArray
    margin: FloatArray
    evidence: EvidenceTable
    exponent_error: FloatArray


def agreed_regime(
    runs: Sequence[EvidenceTable],
    *,
    damped: BoolArray,
    periods: int,
    rules: Thresholds | None = None,
) -> tuple[IntArray, FloatArray]:
    """The regime that all runs agree on, and the margin.

    Parameters
    ----------
    runs
        Evidence at two tolerances or more, the finest first.
    damped : array (orbit,) of bool
    periods
        Length of the runs.
    """
    rules = rules or Thresholds()
    candidates = [_regime_of_run(run, damped, periods, rules) for run in runs]
    label = candidates[0][0]
    agreed = np.all([other == label for other, _ in candidates[1:]], axis=0)
    found = np.array([run.exponent for run in runs])
    with np.errstate(invalid="ignore"):
        stable = found.max(axis=0) <= rules.alike * found.min(axis=0)
    agreed = agreed & (stable | (label != Regime.CHAOTIC))
    margin = np.min([own for _, own in candidates], axis=0)
    label = np.where(agreed, label, Regime.UNDECIDED)
    return label, np.where(label == Regime.UNDECIDED, np.nan, margin)


def _regime_of_run(
    e: EvidenceTable, damped: BoolArray, periods: int, rules: Thresholds
) -> tuple[IntArray, FloatArray]:
    """The regime that one run speaks for, and the margin."""
    with np.errstate(all="ignore"):
        defect = np.where(damped, e.late, e.defect)
        regular = (e.growth <= np.log(periods) + rules.excess) & (e.steady <= rules.steady)
        periodic = (defect <= rules.closed) & np.where(damped, e.growth < 0.0, regular)
        apart = np.maximum(e.defect, e.late) >= rules.open
        lasting = (e.steady >= -0.4 * rules.steady) & (e.late >= 0.5 * e.defect)
        many = (e.digits >= rules.torus_digits) & ~(e.zero_one > rules.wandering)
        few = (
            (e.digits >= rules.few_digits)
            & (e.rotation_digits >= rules.rotation_digits)
            & (e.steady <= rules.steadier)
            & ~(e.zero_one > rules.calm)
        )
        torus = apart & regular & (~damped | lasting & (e.pieces >= rules.pieces)) & (many | few)
        significance = e.exponent / (rules.significance * e.exponent_error)
        most = rules.power * np.log(periods) + 2.0 * rules.excess
        chaotic = (
            apart
            & (significance > 1.0)
            & (e.growth >= most)
            & (e.halves.min(axis=1) >= rules.half)
            & (e.banded_digits <= rules.chaos_digits)
        )
        closeness = np.log(defect) / np.log(rules.closed)
        smooth = e.digits / np.where(many, rules.torus_digits, rules.few_digits)
        margins = [closeness, smooth, np.minimum(significance, e.growth / most)]
    label = np.full(e.exponent.size, int(Regime.UNDECIDED))
    margin = np.full(e.exponent.size, np.nan)
    kinds = (Regime.PERIODIC, Regime.QUASI_PERIODIC, Regime.CHAOTIC)
    for which, kind, own in zip((periodic, torus, chaotic), kinds, margins, strict=True):
        label, margin = np.where(which, int(kind), label), np.where(which, own, margin)
    return label, margin


class RunAtTolerance(Protocol):
    """Follows some orbits."""

    def __call__(self, which: IntArray, n: int, states: FloatArray | None = None, /) -> LongRun:
        """Follow orbits, by number, at the n-th tolerance, of which 0 is the finest.

        They start from `states` (orbit, state), or where they belong.
        """


def decide_regimes(
    follow: RunAtTolerance,
    count: int,
    *,
    damped: BoolArray,
    iterate: IterateMap | None = None,
    seed: int = 0,
    observables: Callable[[FloatArray], FloatArray] = state_observables,
    rules: Thresholds | None = None,
) -> tuple[RegimeLabels, LongRun]:
    """Label many orbits.

    Every orbit is followed at the two loosest tolerances.  If they agree that it is
    regular, or that it escapes, that is its label; the finest tolerance is kept for the
    others, of which two finer runs must agree, and all three where they call it chaotic.
    Damped motion that is chaotic has to remain so twice as long again, in sixteen motions that
    start beside it: chaotic transients can outlast a run.  Where motion is damped but has not
    settled, Newton's method looks for the periodic orbit ahead, and the motion has to approach
    it at the rate of its multiplier.

    Parameters
    ----------
    follow
        Gives the path of some orbits at a tolerance.
    count
        Orbits.
    damped : array (orbit,) of bool
    iterate
        Image and Jacobian of some orbits' maps at the finest tolerance.
    seed, observables, rules
        As for :func:`collect_evidence` and :func:`agreed_regime`.

    Returns
    -------
    Verdict
    Path
        At the finest tolerance that each orbit was followed at; its tangents are not kept.
    """
    everyone = np.arange(count)

    def evidence(path: LongRun, which: IntArray) -> EvidenceTable:
        return collect_evidence(path, damped=damped[which], seed=seed, observables=observables)

    path = follow(everyone, _LOOSEST)
    loose = evidence(path, everyone)
    at = np.flatnonzero(path.trusted)
    again = follow(at, _LOOSEST - 1)
    first = _with(loose, evidence(again, at), at)
    label, margin = agreed_regime([first, loose], damped=damped, periods=path.periods, rules=rules)
    spread = np.abs(first.exponent - loose.exponent)
    disputed = path.escaped[at] != again.escaped
    path = path.updated(again, at)
    disputed |= ~path.escaped[at] & ~np.isin(label[at], (Regime.PERIODIC, Regime.QUASI_PERIODIC))
    at = at[disputed & path.trusted[at]]
    if at.size:
        finest = follow(at, 0)
        three = [evidence(finest, at), first.taken(at), loose.taken(at)]
        own = {"damped": damped[at], "periods": path.periods, "rules": rules}
        label[at], margin[at] = agreed_regime(three[:2], **own)
        all_agree, least = agreed_regime(three, **own)
        chaotic = label[at] == Regime.CHAOTIC
        label[at[chaotic]], margin[at[chaotic]] = all_agree[chaotic], least[chaotic]
        found = np.array([run.exponent for run in three])
        spread[at] = np.ptp(found, axis=0)
        first, path = _with(first, three[0], at), path.updated(finest, at)
    at = np.flatnonzero(damped & (label == Regime.CHAOTIC))
    passing = at[~_lasting(follow, at, path.last[at], (rules or Thresholds()).half)]
    label[passing], margin[passing] = Regime.UNDECIDED, np.nan
    escaped, untrusted = path.escaped, ~path.trusted
    label[untrusted] = Regime.UNDECIDED
    period = np.where(label == Regime.PERIODIC, first.period, 0)
    if iterate is not None:
        ahead = damped & (label == Regime.UNDECIDED) & ~escaped & ~untrusted
        ahead &= (first.exponent < 0.0) & (first.late < _NEAR)
        which = np.flatnonzero(ahead)
        found = _settling(path, which, first.period[which], iterate)
        there = which[found > 0]
        label[there], period[there], margin[there] = Regime.PERIODIC, found[found > 0], 1.0
        # An orbit that still settles may seem to have a multiple of its period.
        which = np.flatnonzero(damped & (period > 1) & (first.late > _SETTLED))
        found = _settling(path, which, period[which], iterate)
        period[which] = np.where(found > 0, found, period[which])
    label = np.where(escaped, int(Regime.ESCAPED), label)
    error = np.hypot(first.exponent_error, spread)
    return RegimeLabels(label, period, margin, first, error), path


#: So many runs more damped motion has to stay chaotic, and so many others that start beside
#: it, each this share of the state farther away; so many are followed together.
_AGAIN, _BESIDE, _APART, _TOGETHER = 2, 16, 1e-9, 4096
#: The tolerance that every orbit is followed at first.
_LOOSEST = 2
#: An orbit that returns worse than this, relative to its extent, is not settling yet.
_NEAR = 0.5
#: An orbit that returns better than this has settled.
_SETTLED = 1e-10
#: Newton's residual at a periodic orbit.
_RESIDUAL = 1e-8


def _lasting(follow: RunAtTolerance, which: IntArray, states: FloatArray, half: float) -> BoolArray:
    """Where chaos goes on: in no motion that starts beside the orbit do tangents stop growing.

    A transient ends at random, after any time: many short trials see more of that than one
    long one, and sixteen motions cost a kernel what one does.
    """
    lasting = np.ones(which.size, dtype=np.bool_)
    apart = 1.0 + _APART * np.arange(_BESIDE)
    beside = np.repeat(states, _BESIDE, axis=0) * np.tile(apart, which.size)[:, None]
    for _ in range(_AGAIN):
        left = np.flatnonzero(np.repeat(lasting, _BESIDE))
        for at in np.array_split(left, -(-left.size // _TOGETHER)) if left.size else ():
            orbit = at // _BESIDE
            path = follow(which[orbit], _LOOSEST, beside[at])
            growth = path.growth[..., 0]
            late = growth[:, growth.shape[1] // 2 :].sum(axis=1)
            stopped = ~(path.trusted & ~path.escaped & (late >= half))
            lasting[orbit[stopped]] = False
            beside[at] = path.last
    return lasting


def _settling(path: LongRun, which: IntArray, guess: IntArray, iterate: IterateMap) -> IntArray:
    """Periods of the stable orbits that motions are seen to approach, or 0."""
    assert path.visited is not None
    period = np.zeros(which.size, dtype=np.int64)
    for q in range(1, int(guess.max(initial=0)) + 1):
        some = np.flatnonzero((guess % q == 0) & (period == 0))
        if not some.size:
            continue
        states = path.visited[which[some]]
        ahead = find_limit_orbit(iterate, which[some], states[:, -1], q)
        with np.errstate(invalid="ignore"):
            rate = np.log(np.maximum(ahead.multiplier, 1e-300)) / q
            known = (ahead.residual <= _RESIDUAL) & (rate < 0.0)
        late = states[:, path.periods // 2 :]
        period[some[known & approaches_limit(late, ahead.state, q, rate)]] = q
    return period


def _with(whole: EvidenceTable, part: EvidenceTable, which: IntArray) -> EvidenceTable:
    """The evidence with that of some orbits put in."""
    values = {f.name: getattr(whole, f.name).copy() for f in fields(whole)}
    for name, value in values.items():
        value[which] = getattr(part, name)
    return EvidenceTable(**values)
