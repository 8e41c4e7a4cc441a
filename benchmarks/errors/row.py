"""A row of the study: an error that results carry, and how it is compared with the truth."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from dataclasses import dataclass
from enum import Enum
from functools import cache, wraps
from importlib import import_module
from pkgutil import iter_modules
from typing import Any, TypeVar

import numpy as np
from scipy.stats import beta

from benchmarks.errors import rows

T = TypeVar("T")

#: Least number that a double can tell from one: where a true error is smaller, it is its measure.
EPS = float(np.finfo(float).eps)


class Promise(Enum):
    """What a reported error promises."""

    BOUND = "bound"  # the true error is smaller, 99.5 % of the time
    STANDARD = "standard error"  # the true error is smaller 68 % of the time


@dataclass(frozen=True)
class Judged:
    """One number of a result: its reported error, and the true one.

    Attributes
    ----------
    case : str
        Makes it again.
    reported : float
        As the result has it; NaN where the result says that it has none.
    scale : float
        Size of the number: rounding is a share of it.
    """

    case: str
    tolerance: float
    damped: bool
    reported: float
    true: float
    scale: float = 1.0

    @property
    def covered(self) -> bool:
        return self.true <= self.reported

    @property
    def ratio(self) -> float:
        """Reported over true error, which counts as no less than rounding."""
        return self.reported / max(self.true, EPS * max(self.scale, 1.0))


@dataclass(frozen=True)
class Row:
    """An error that results carry.

    Attributes
    ----------
    name : str
        Of the number in words, as "multipliers of periodic orbits".
    variable : str
        Of the result, as "periodic_orbits: multipliers_error"; more than one with commas.
    measure : callable
        From a generator of random numbers to judged numbers of one batch of random cases.
    promise : Promise
        What the error promises.
    """

    name: str
    variable: str
    measure: Callable[[np.random.Generator], Iterable[Judged]]
    promise: Promise = Promise.BOUND

    @property
    def slug(self) -> str:
        """The name as that of a file."""
        return self.name.replace(" ", "-").replace(",", "")

    @property
    def errors(self) -> frozenset[str]:
        """The errors that it judges, each as "verb: variable"."""
        verb, names = self.variable.split(": ")
        return frozenset(f"{verb}: {name}" for name in names.split(", "))

    def measured(self, count: int, seed: int) -> Iterator[Judged]:
        """At least `count` judged numbers, the same for the same seed."""
        found = batch = 0
        while found < count:
            for judged in self.measure(np.random.default_rng([seed, batch])):
                found += 1
                yield judged
            batch += 1


def shared(batch: Callable[..., Iterable[T]]) -> Callable[..., tuple[T, ...]]:
    """Make each batch of random cases once for all the rows that judge numbers of it.

    Parameters
    ----------
    batch : callable
        Of a generator of random numbers, and of what can be a key.
    """

    @cache
    def made(seed: int, *args: Hashable) -> tuple[T, ...]:
        return tuple(batch(np.random.default_rng(seed), *args))

    @wraps(batch)
    def drawn(rng: np.random.Generator, *args: Hashable) -> tuple[T, ...]:
        return made(int(rng.integers(2**62)), *args)

    return drawn


def all_rows() -> list[Row]:
    """Every row of every file of :mod:`benchmarks.errors.rows`."""
    names = sorted(module.name for module in iter_modules(rows.__path__))
    return [row for name in names for row in import_module(f"{rows.__name__}.{name}").ROWS]


def summary(judged: list[Judged]) -> dict[str, Any]:
    """Share covered, with its lower limit (Clopper and Pearson, 95 %), and looseness.

    Numbers whose result says that it has no error are counted, and judged no further.
    """
    told = [one for one in judged if np.isfinite(one.reported) and np.isfinite(one.true)]
    covered = sum(one.covered for one in told)
    return {
        "cases": len(judged),
        "without": len(judged) - len(told),
        "coverage": covered / len(told) if told else None,
        "coverage_at_least": (
            float(beta.ppf(0.05, covered, len(told) - covered + 1)) if covered else None
        ),
        "within_two": sum(one.true <= 2.0 * one.reported for one in told) / max(len(told), 1),
        "median_ratio": float(np.median([one.ratio for one in told])) if told else None,
    }


def report(row: Row, judged: list[Judged], seed: int) -> dict[str, Any]:
    """What is kept of a row: summaries by tolerance and damping, and the cases not covered."""
    missed = [one for one in judged if np.isfinite(one.true) and one.true > one.reported]
    decades = sorted({round(float(np.floor(np.log10(one.tolerance)))) for one in judged})
    return {
        "name": row.name,
        "variable": row.variable,
        "promise": row.promise.value,
        "seed": seed,
        "total": summary(judged),
        "damped": summary([one for one in judged if one.damped]),
        "undamped": summary([one for one in judged if not one.damped]),
        "decades": {
            f"1e{d}": summary([one for one in judged if d <= np.log10(one.tolerance) < d + 1])
            for d in decades
        },
        "not_covered": [
            {"case": one.case, "tolerance": one.tolerance,
             "reported": float(f"{one.reported:.3g}"), "true": float(f"{one.true:.3g}")}
            for one in sorted(missed, key=lambda one: one.reported / one.true)
        ],
        # for the picture: log10 of true and of reported errors
        "points": [
            [_log(one.true), _log(one.reported)] for one in judged if np.isfinite(one.reported)
        ],
    }  # fmt: skip


def _log(error: float) -> float:
    """Decimal logarithm of an error, with two digits; no less than that of 1e-18."""
    return round(float(np.log10(max(error, 1e-18))), 2)
