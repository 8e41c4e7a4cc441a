"""Where the sliders of a page begin and end: useful ranges of each number, not its limits."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType
from typing import Final

from remanent._checks import Rule


@dataclass(frozen=True)
class Range:
    """Where a slider goes.

    Attributes
    ----------
    low, high
        Its ends.
    scale
        ``"linear"`` or ``"log"``.
    """

    low: float
    high: float
    scale: str = "linear"

    def including(self, value: float) -> Range:
        """The range, made longer where the value lies outside."""
        low, high = min(self.low, value), max(self.high, value)
        return Range(low, high, self.scale if low > 0.0 else "linear")


_ANGLE: Final = Range(0.0, 2.0 * math.pi)
_LOAD: Final = Range(-1.0, 3.0)
_FREQUENCY: Final = Range(0.05, 5.0, "log")
_SHARE: Final = Range(0.0, 1.0)
#: By the end of the dotted name, its numbers left out; the longest end that fits decides.
_RANGES: Final[Mapping[str, Range]] = MappingProxyType(
    {
        # The block: films to tall columns, glass to the limit of the magnet, pull and push.
        "c": Range(1e-3, 10.0, "log"),
        "temperature": Range(200.0, 450.0),
        "reference_temperature": Range(200.0, 450.0),
        "prestress": Range(-0.5, 2.0),
        "prestress_1": Range(-0.5, 2.0),
        "prestress_2": Range(-0.5, 2.0),
        "edges_1": Range(0.2, 5.0, "log"),
        "edges_2": Range(0.2, 5.0, "log"),
        # Rubber: from the softest that locks early to what is nearly neo-Hookean.
        "material.entropic_fraction": _SHARE,
        "material.jm": Range(3.0, 200.0, "log"),
        "material.c1": Range(0.01, 1.0),
        "material.c2": Range(0.0, 1.0),
        "Yeoh.c2": Range(-0.1, 0.1),
        "Yeoh.c3": Range(-0.01, 0.01),
        "material.moduli": Range(-2.0, 2.0),
        "material.exponents": Range(-5.0, 5.0),
        "material.locking_stretch": Range(1.05, 10.0, "log"),
        # Loss, from nothing to more than critical damping.
        "eta": _SHARE,
        "modulus": Range(0.0, 3.0),
        "relaxation_time": Range(0.01, 100.0, "log"),
        "shift.c1": Range(0.0, 30.0),
        "shift.c2": Range(20.0, 400.0),
        "shift.activation_temperature": Range(0.0, 20000.0),
        # Heat: the coupling of elastomers is about 2e-4; more shows what it does.
        "heat.coupling": Range(1e-5, 0.1, "log"),
        "heat.exchange": _SHARE,
        "magnet.temperature_coefficient": Range(-0.004, 0.002),
        "magnet.demagnetisation": _SHARE,
        # Loads.
        "b": Range(0.0, 3.0),
        "m": _LOAD,
        "mean": _LOAD,
        "omega": _FREQUENCY,
        "phase": _ANGLE,
        "loads": Range(-2.0, 2.0),
        "phases": _ANGLE,
        "start": Range(0.0, 5.0),
        "stop": Range(0.0, 5.0),
        "duration": Range(1.0, 500.0, "log"),
    }
)
#: How many times its size a number of one's own may grow.
_OWN_GROWTH: Final = 3.0
#: Numbers at which a rule is asked whether it holds, to find where it ends.
_ENDS: Final = (0.0, 1.0)
_FAR: Final = 1e6


def range_of(name: str, value: float, kind: str | None = None) -> Range:
    """The range of a slider.

    Parameters
    ----------
    name : str
        The dotted name of a numeric field.
    value : float
        Its value, which lies in the range.
    kind : str, optional
        The class of the part that it belongs to.
    """
    plain = re.sub(r"\.\d+", "", name)
    ends = [f"{kind}.{plain.rpartition('.')[2]}", plain]
    while "." in ends[-1]:
        ends.append(ends[-1].partition(".")[2])
    known = next((_RANGES[end] for end in ends if end in _RANGES), None)
    return (own_range(value) if known is None else known).including(value)


def own_range(value: float) -> Range:
    """The range of a number of which nothing is known but its value."""
    if value == 0.0:
        return Range(-1.0, 1.0)
    return Range(min(0.0, _OWN_GROWTH * value), max(0.0, _OWN_GROWTH * value))


def limits_of(rule: Rule) -> dict[str, float | bool | None]:
    """Between which numbers a rule holds, where these are 0, 1 or none.

    Returns
    -------
    dict
        ``least`` and ``most``, None where there is none, and ``least_included`` and
        ``most_included``.
    """
    ends = (-_FAR, *_ENDS, _FAR)
    between = [bool(rule.is_satisfied_by(0.5 * (low + high))) for low, high in pairwise(ends)]
    least = next((k for k, holds in enumerate(between) if holds), 0)
    most = next((k for k in range(len(between), 0, -1) if between[k - 1]), len(between))
    return {
        "least": ends[least] if least > 0 else None,
        "least_included": bool(rule.is_satisfied_by(ends[least])),
        "most": ends[most] if most < len(between) else None,
        "most_included": bool(rule.is_satisfied_by(ends[most])),
    }


def allowed_range(span: Range, rule: Rule) -> Range:
    """The part of a range in which a rule holds; an end that is not allowed moves inward."""
    limits = limits_of(rule)
    low, high = span.low, span.high
    if limits["least"] is not None and low <= limits["least"]:
        least = float(limits["least"])
        low = least if limits["least_included"] else least + 1e-3 * (high - least)
    if limits["most"] is not None and high >= limits["most"]:
        most = float(limits["most"])
        high = most if limits["most_included"] else most - 1e-3 * (most - low)
    return Range(low, high, span.scale)
