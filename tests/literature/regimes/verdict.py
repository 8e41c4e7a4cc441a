"""What a long reference orbit says of its regime, with the numbers that say it.

Three kinds of evidence, each over the whole orbit and none of them a classifier's own: the
growth of a tangent vector, the convergence of weighted averages, and return to the same
point. A regime is named only where they agree; what lies between is `undecided`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from remanent._typing import FloatArray

#: Largest period looked for, in drive periods or iterates.
LONGEST = 128
#: A chaotic tangent grows by e to this over the orbit at least, by a third of it over each
#: half, and its exponent is this many standard errors; a regular one grows by no more than
#: the power law N^2 times e^8.
CHAOTIC_GROWTH, STANDARD_ERRORS = 60.0, 3.0
REGULAR_POWER, REGULAR_EXCESS = 2.0, 8.0
#: Digits of the averages on a torus, at least.
TORUS_DIGITS = 4.0
#: In chaos they are at most these, more than the square root of the number of values gives;
#: chaos in bands may have more, and needs an exponent of so many standard errors.
CHAOS_DIGITS, BEYOND_DOUBT = 1.5, 20.0
#: Defect of a periodic orbit at most, of any other at least, relative to its spread.
CLOSED, OPEN = 1e-9, 1e-5
#: The spread of an orbit that returns after every period is taken to be this.
LEAST_SPREAD = 1e-2
#: A defect below this means that the transient is over, as a classifier would see it.
SETTLED = 1e-6
#: Chaos that ends in a periodic orbit later than this is left undecided.
LATEST_SETTLING = 2_000


@dataclass(frozen=True)
class Evidence:
    """Numbers about one orbit of `length` periods or iterates.

    Attributes
    ----------
    growth
        Logarithm of the tangent's growth over the first and the second half.
    early
        The same over the first 500 and 2000 periods: what a classifier can see.
    exponent, error
        Lyapunov exponent per period over the second half, and its standard error from 16
        blocks.
    digits
        Of the weighted average, the fewest over the observables.
    defect, period
        Largest distance after `period` periods over the last quarter, relative to the
        orbit's spread there, for the least period up to `LONGEST` that makes it `CLOSED`,
        or else smallest but for a factor of 10.
    settled
        Periods after which that distance stays below `SETTLED`; None if it never does.
    """

    length: int
    growth: tuple[float, float]
    early: tuple[float, float]
    exponent: float
    error: float
    digits: float
    defect: float
    period: int
    settled: int | None


def gather(observables: FloatArray, growth: FloatArray) -> Evidence:
    """Evidence from observables (period, observable) and growth of a tangent (chunk,)."""
    length, half = len(observables) - 1, len(growth) // 2
    periods = length // len(growth)
    second = growth[half:]
    blocks = np.array([b.mean() for b in np.array_split(second, 16)]) / periods
    period, defect, distance = returns(observables)
    late = np.flatnonzero(~(distance < SETTLED))
    settled = 0 if len(late) == 0 else int(late[-1]) + 1
    return Evidence(
        length=length,
        growth=(float(growth[:half].sum()), float(second.sum())),
        early=(float(growth[: 500 // periods].sum()), float(growth[: 2000 // periods].sum())),
        exponent=float(second.mean()) / periods,
        error=float(blocks.std(ddof=1) / np.sqrt(len(blocks))),
        digits=digits(observables[length // 10 :]),
        defect=defect,
        period=period,
        settled=settled if settled < 0.75 * length else None,
    )


def digits(observables: FloatArray) -> float:
    """Agreement of weighted averages over the two halves, in decimal digits."""
    half = len(observables) // 2
    s = np.arange(1, half + 1) / (half + 1)
    with np.errstate(under="ignore"):
        weight = np.exp(-1.0 / (s * (1.0 - s)))
    weight /= weight.sum()
    difference = np.abs(weight @ (observables[:half] - observables[-half:]))
    spread = np.maximum(np.std(observables, axis=0), 1e-12)
    return float(-np.log10(np.maximum(np.max(difference / spread), 1e-16)))


def returns(observables: FloatArray) -> tuple[int, float, FloatArray]:
    """Period, defect, and distance after that period along the whole orbit."""
    tail = observables[-(len(observables) // 4) :]
    spread = max(float(np.max(np.ptp(tail, axis=0))), LEAST_SPREAD)
    defects = np.full(LONGEST + 1, np.inf)
    for p in range(1, LONGEST + 1):
        defects[p] = np.max(np.abs(tail[p:] - tail[:-p])) / spread
    enough = max(CLOSED, 10 * defects.min())
    period = int(np.flatnonzero(defects <= enough)[0])
    distance = np.max(np.abs(observables[period:] - observables[:-period]), axis=1) / spread
    return period, float(defects[period]), distance


def regime(evidence: Evidence, *, dissipative: bool) -> str:
    """`periodic`, `quasi-periodic`, `chaotic`, or `undecided` where the evidence disagrees."""
    total = sum(evidence.growth)
    regular = REGULAR_POWER * np.log(evidence.length) + REGULAR_EXCESS
    if evidence.defect <= CLOSED:
        decays = evidence.growth[1] < -20.0 and not _transient_chaos(evidence)
        return "periodic" if (decays if dissipative else total <= regular) else "undecided"
    if evidence.defect < OPEN:
        return "undecided"
    steady = abs(total) <= regular if dissipative else total <= regular
    if steady and evidence.digits >= TORUS_DIGITS:
        return "quasi-periodic"
    if _chaotic(evidence):
        return "chaotic"
    return "undecided"


def _transient_chaos(evidence: Evidence) -> bool:
    """Chaos for so long that who sees less of the orbit rightly calls it chaotic."""
    late = evidence.settled is None or evidence.settled > LATEST_SETTLING
    return late and evidence.early[1] > CHAOTIC_GROWTH / 3


def _chaotic(evidence: Evidence) -> bool:
    first, second = evidence.growth
    grows = first + second >= CHAOTIC_GROWTH and min(first, second) >= CHAOTIC_GROWTH / 3
    irregular = evidence.digits <= CHAOS_DIGITS + 0.5 * np.log10(evidence.length)
    certain = evidence.exponent >= BEYOND_DOUBT * evidence.error
    sure = evidence.exponent >= STANDARD_ERRORS * evidence.error
    return bool(grows and (certain or (sure and irregular)))


def row(evidence: Evidence) -> dict[str, Any]:
    """Evidence in few characters."""
    return {
        "length": evidence.length,
        "growth": [float(f"{x:.4g}") for x in evidence.growth],
        "early": [float(f"{x:.4g}") for x in evidence.early],
        "exponent": float(f"{evidence.exponent:.4g}"),
        "error": float(f"{evidence.error:.2g}"),
        "digits": round(evidence.digits, 2),
        "defect": float(f"{evidence.defect:.2g}"),
        "period": evidence.period,
        "settled": evidence.settled,
    }
