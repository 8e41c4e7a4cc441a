"""Dissipation: dashpots on the stretches, and branches with internal variables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar

from remanent import _checks
from remanent._checks import Rule
from remanent.models.parts import Part


@dataclass(frozen=True)
class Dissipation(Part):
    """A dissipative element acting in parallel with the elastic solid.

    An element may have a Rayleigh function, and it may have internal variables (for
    example the stretch of a spring in series with a dashpot), one of each kind for
    each of the two in-plane directions, with a stored energy and their own rates.
    All energies are per reference volume, divided by mu at T0; time is tau.
    """

    #: Kinds of internal variables; each starts from 1.
    internal: ClassVar[tuple[str, ...]] = ()

    def rayleigh(self, stretches: Sequence[Any], rates: Sequence[Any], p: Mapping[str, Any]) -> Any:
        """Rayleigh function D; the force on stretch i is -dD/d(rate i).

        Parameters
        ----------
        stretches, rates
            In-plane stretches and their rates, two of each.
        p
            Values of the element's numeric fields, by name.
        """
        return 0

    def stored(
        self, stretches: Sequence[Any], internal: Sequence[Any], p: Mapping[str, Any]
    ) -> Any:
        """Energy stored in the element at T0; it is multiplied by T/T0.

        `internal` lists the internal variables, kind by kind, two directions each.
        """
        return 0

    def internal_rates(
        self, stretches: Sequence[Any], internal: Sequence[Any], theta: Any, p: Mapping[str, Any]
    ) -> Sequence[Any]:
        """Rates of the internal variables, in the order of `internal`."""
        return ()


@dataclass(frozen=True)
class Rayleigh(Dissipation):
    """A linear dashpot on stretch: D = eta (l1'^2 + l2'^2)/2 per 8 H L^2 mu.

    For equal stretches the term eta l' joins the bracket of the paper's equation 16.

    Parameters
    ----------
    eta
        Viscosity divided by mu times the unit of time.
    """

    eta: float

    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {
            "eta": _checks.not_negative(
                "A dashpot takes energy out of the motion.", "Pass 0 for no damping."
            )
        }
    )

    def rayleigh(self, stretches: Sequence[Any], rates: Sequence[Any], p: Mapping[str, Any]) -> Any:
        """D = eta (l1'^2 + l2'^2)/2."""
        return p["eta"] * (rates[0] ** 2 + rates[1] ** 2) / 2
