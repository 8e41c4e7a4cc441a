"""What is known of a language: how it writes numbers, operations, assignments and comments."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Language:
    """How a language writes straight-line code.

    Attributes
    ----------
    operations
        For each operation its text, with a place for each operand.
    assignment
        A statement that gives a new name a value.
    comment
        What begins a line of comment.
    reserved_words
        Names that mean something else in its files.
    helpers
        For operations that it refuses outside their range, or answers with complex numbers, the
        function that `operations` calls in their place.
    not_a_number, infinity
        These two numbers.
    exponent
        What stands before the exponent of a number.
    has_case
        Whether names that differ in case only are different names.
    """

    operations: Mapping[str, str]
    assignment: str
    comment: str
    reserved_words: frozenset[str]
    helpers: Mapping[str, str] = field(default_factory=dict)
    not_a_number: str = "NaN"
    infinity: str = "Infinity"
    exponent: str = "e"
    has_case: bool = True

    def number(self, value: float) -> str:
        """A number with all of its digits."""
        if math.isnan(value):
            return self.not_a_number
        if math.isinf(value):
            return self.infinity if value > 0.0 else f"-{self.infinity}"
        mantissa, _, exponent = repr(value).partition("e")
        if self.exponent == "e" and not exponent:
            return mantissa
        return f"{mantissa}{self.exponent}{int(exponent or 0)}"
