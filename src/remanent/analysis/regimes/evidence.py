"""The evidence about many orbits at one tolerance: one table, one row for each orbit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from remanent._typing import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class EvidenceTable:
    """Numbers about many orbits at one tolerance, arrays (orbit,) unless said otherwise.

    A table is never changed: :meth:`subset` and :meth:`with_replaced_rows` give new ones.
    ``table["zero_one"]`` is the column of an indicator, or any other.

    Attributes
    ----------
    exponent, exponent_error
        Largest Lyapunov exponent per period, and its standard error by means of batches, which
        is the larger one on a torus.
    swing_error
        The standard error by the swings of the growth about its trend.
    finite_time_error
        How much of the exponent may be growth in proportion to time, as on a torus.
    log_growth
        Logarithm of the tangent's growth over the run, without the transient.
    log_growth_of_halves : array (orbit, 2)
        The same over the two halves of that.
    late_log_growth
        Its mean over the last quarter less that over the second.
    rotation_number, rotation_error, rotation_digits
        Turns per period about the middle of the orbit, their error by the length of the run, and
        how many of their digits agree.
    period : array (orbit,) of int
        After how many periods the orbit comes back best.
    defect, late_defect
        How far from itself it comes back after that, relative to its extent: over the run
        without the transient, and over its last quarter.
    extent
        Of the orbit.
    indicators : mapping of name to array (orbit,)
        Of :data:`~remanent.analysis.regimes.collection.INDICATOR_FUNCTIONS`.
    """

    exponent: FloatArray
    exponent_error: FloatArray
    swing_error: FloatArray
    finite_time_error: FloatArray
    log_growth: FloatArray
    log_growth_of_halves: FloatArray
    late_log_growth: FloatArray
    rotation_number: FloatArray
    rotation_error: FloatArray
    rotation_digits: FloatArray
    period: IntArray
    defect: FloatArray
    late_defect: FloatArray
    extent: FloatArray
    indicators: Mapping[str, FloatArray]

    @classmethod
    def from_columns(cls, columns: Mapping[str, Any]) -> EvidenceTable:
        """A table of columns by name; those that are no attributes are indicators."""
        names = {f.name for f in fields(cls)} - {"indicators"}
        return cls(
            **{name: columns[name] for name in names},
            indicators={name: columns[name] for name in columns if name not in names},
        )

    @property
    def column_of_name(self) -> dict[str, FloatArray | IntArray]:
        """All columns by name."""
        names = (f.name for f in fields(self) if f.name != "indicators")
        return {**{name: getattr(self, name) for name in names}, **self.indicators}

    def __getitem__(self, name: str) -> FloatArray:
        """A column by name."""
        return self.indicators[name] if name in self.indicators else getattr(self, name)

    def subset(self, indices: IntArray | BoolArray) -> EvidenceTable:
        """The rows of some orbits."""
        return self.from_columns({name: c[indices] for name, c in self.column_of_name.items()})

    def with_replaced_rows(self, indices: IntArray, rows: EvidenceTable) -> EvidenceTable:
        """A table in which the rows of some orbits are replaced."""
        changed = {name: column.copy() for name, column in self.column_of_name.items()}
        for name, column in changed.items():
            column[indices] = rows[name]
        return self.from_columns(changed)
