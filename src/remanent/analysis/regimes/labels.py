"""The labels that motion can get, and what comes with them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from remanent._typing import FloatArray, IntArray
from remanent.analysis.regimes.evidence import EvidenceTable


class Regime(IntEnum):
    """The kinds of motion that are told apart."""

    UNDECIDED = 0
    PERIODIC = 1
    QUASI_PERIODIC = 2
    CHAOTIC = 3
    ESCAPED = 4

    @property
    def meaning(self) -> str:
        """The label that results show: ``quasi-periodic``."""
        return self.name.lower().replace("_", "-")


@dataclass(frozen=True)
class RegimeLabels:
    """Labels of many orbits with the evidence for them.

    Attributes
    ----------
    regime : array (orbit,) of int
        Values of :class:`Regime`.
    period : array (orbit,) of int
        In periods of the map; 0 where the orbit is not periodic.
    margin : array (orbit,)
        The factor by which the weakest evidence clears its threshold; NaN where nothing was
        decided.
    evidence : EvidenceTable
        At the finest tolerance at which each orbit was followed.
    exponent_error : array (orbit,)
        Standard error of the exponent and its spread over the tolerances, added in squares, and
        what the length of the run adds.
    rotation_number_error : array (orbit,)
        Of the differences of the rotation numbers of windows of two thirds of the run from that
        of all, the spread over the tolerances, and the error that a period adds.
    """

    regime: IntArray
    period: IntArray
    margin: FloatArray
    evidence: EvidenceTable
    exponent_error: FloatArray
    rotation_number_error: FloatArray
