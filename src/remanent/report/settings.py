"""What [Thermal] states, and what it leaves unstated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

import numpy as np

from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.models.drives.waves import Sine, SineSquared

#: Temperatures of every figure, kelvin.
TEMPERATURES: Final = (250.0, 350.0, 400.0)
#: Prestresses of every figure.
PRESTRESSES: Final = (0.0, 1.0)
#: Drive frequency of the motions in figures 5 (S = 0) and 6 (S = 1).
MOTION_FREQUENCIES: Final = (1.25, 1.08)
#: Published resonance frequencies, one row per prestress, one column per temperature.
PUBLISHED_RESONANCES: Final = ((1.05, 1.25, 1.35), (0.85, 1.08, 1.19))
#: Two digits after the point are published, and the maximum is read off a curve.
MAX_RESONANCE_MISFIT: Final = 0.01


@dataclass(frozen=True)
class Setting:
    """One choice of everything [Thermal] leaves unstated.

    Attributes
    ----------
    b
        Amplitude b0 of the square root of the load.
    reference_temperature
        T0, kelvin.
    window_length
        Length of the response window, tau.
    law_name
        Name in :data:`FORCING_LAWS`.
    """

    b: float = 0.4
    reference_temperature: float = 293.0
    window_length: float = 100.0
    law_name: str = "sin2"

    def __str__(self) -> str:
        return (
            f"b₀ = {self.b:g}, T₀ = {self.reference_temperature:g} K, "
            f"window {self.window_length:g}, {FORCING_LAWS[self.law_name].text}"
        )

    @property
    def actuator(self) -> Actuator:
        """The published cube, with this reference temperature."""
        return Actuator(reference_temperature=self.reference_temperature)

    def build_drive(self, omega: float) -> Drive:
        """The periodic load at a frequency."""
        return FORCING_LAWS[self.law_name].build_drive(self.b, omega)


@dataclass(frozen=True)
class ForcingLaw:
    """A reading of "periodic magnetic flux".

    Attributes
    ----------
    text, symbol
        In plain text, and as mathtext.
    sine_phase
        Phase of the sine that is squared; None where the load is a sine itself.
    """

    text: str
    symbol: str
    sine_phase: float | None

    def build_drive(self, b: float, omega: float) -> Drive:
        """The load with amplitude b², at a frequency."""
        if self.sine_phase is None:
            return Sine(b**2, omega)
        return SineSquared(b, omega, self.sine_phase)

    def drive_field(self, b: np.ndarray) -> tuple[str, np.ndarray]:
        """Name and values of the drive's field that `b` sets."""
        return ("m", b**2) if self.sine_phase is None else ("b", b)


#: Readings of the periodic load, by name.
FORCING_LAWS: Final[Mapping[str, ForcingLaw]] = MappingProxyType(
    {
        "sin2": ForcingLaw("m = (b₀ sin ωτ)²", r"$(b_0\sin\omega\tau)^2$", 0.0),
        "cos2": ForcingLaw("m = (b₀ cos ωτ)²", r"$(b_0\cos\omega\tau)^2$", np.pi / 2),
        "sin": ForcingLaw("m = b₀² sin ωτ", r"$b_0^2\sin\omega\tau$", None),
    }
)
#: The setting whose numbers are reported.
REFERENCE_SETTING: Final = Setting()
