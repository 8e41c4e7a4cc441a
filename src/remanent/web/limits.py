"""How long each job may take, and what to do where it takes longer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

#: Seconds for what follows a slider, and for what is computed in the background.
SLIDER_CAP: Final = 10.0
BACKGROUND_CAP: Final = 300.0


@dataclass(frozen=True)
class Limit:
    """How long a job may take.

    Attributes
    ----------
    seconds : float
    remedy : str
        What to do where it takes longer, a sentence.
    """

    seconds: float
    remedy: str


_FEWER_POINTS: Final = "Ask for fewer points, or for shorter runs."

#: The limits of all jobs by their names.
JOB_LIMITS: Final[Mapping[str, Limit]] = MappingProxyType(
    {
        "frequency_response": Limit(SLIDER_CAP, _FEWER_POINTS),
        "classify": Limit(SLIDER_CAP, "Ask for fewer periods."),
        "equilibria": Limit(SLIDER_CAP, "Ask for a smaller box."),
        "response_diagram": Limit(BACKGROUND_CAP, "Ask for a narrower range of omega."),
        "basins": Limit(BACKGROUND_CAP, _FEWER_POINTS),
        "regime_chart": Limit(BACKGROUND_CAP, _FEWER_POINTS),
    }
)
