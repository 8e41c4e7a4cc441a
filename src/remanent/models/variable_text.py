"""What a user says of a variable of the own system, for the labels of results."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class VariableText:
    """How a variable is labelled.

    Attributes
    ----------
    units : str
        UDUNITS text; ``"1"`` where dimensionless.
    long_name : str
        The meaning in a few words.
    symbol : str
        LaTeX for use between dollar signs.
    """

    units: str
    long_name: str
    symbol: str
