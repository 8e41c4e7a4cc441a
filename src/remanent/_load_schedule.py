"""How a load runs in time, without its physics: what drives tell the integrator."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from remanent._typing import FloatArray


@dataclass(frozen=True)
class LoadSchedule:
    """Consecutive pieces of time on each of which the load is smooth.

    Attributes
    ----------
    piece_lengths : array (piece, trajectory)
        Length of each piece in units of tau.  A periodic load has one piece, its
        smallest period.
    periodic : bool
        Whether the pieces repeat for ever.  Otherwise they end with the last.
    piece_parameters : mapping of name to array (piece, trajectory)
        Parameters of the field that change from piece to piece (the levels of a
        step drive, the coefficients of a spline); empty for a periodic load.
    waveforms_at_phase : callable
        ``waveforms_at_phase(phase)`` with phases in [0, 1], any shape, gives an array
        ``(waveform, *phase.shape)``: values of the field's waveforms.
    """

    piece_lengths: FloatArray
    periodic: bool
    piece_parameters: Mapping[str, FloatArray]
    waveforms_at_phase: Callable[[FloatArray], FloatArray]
