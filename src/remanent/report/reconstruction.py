"""Which unstated choices bring the six published resonances back."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import xarray as xr

from remanent._typing import FloatArray
from remanent.report.settings import (
    FORCING_LAWS,
    MAX_RESONANCE_MISFIT,
    PRESTRESSES,
    PUBLISHED_RESONANCES,
    TEMPERATURES,
    Setting,
)
from remanent.results import build, provenance
from remanent.studies.response.frequency_response import frequency_response

#: Reference temperatures T₀ for which the misfit is computed, kelvin.
REFERENCE_TEMPERATURES = np.arange(287.0, 304.0, 2.0)
#: Amplitudes b₀ for which the misfit is computed.
ROOT_LOAD_AMPLITUDES = np.round(np.arange(0.34, 0.4401, 0.01), 2)
#: Lengths of the response window for which the misfit is computed, tau.
WINDOW_LENGTHS = (50.0, 100.0, 150.0)
#: First, last and number of frequencies searched, by law; m = b₀² sin ωτ resonates at twice the
#: published ones.
_FREQUENCY_GRIDS = {"sin2": (0.7, 1.5, 41), "cos2": (0.7, 1.5, 41), "sin": (0.7, 3.0, 116)}
#: Tolerance of amplitudes, as small as the width of a resonance needs.
_RESPONSE_TOLERANCE = 1e-4
#: Width to which a resonance is read: two parts of eight of a step of the table, with room for
#: rounding.
_RESONANCE_BRACKET_WIDTH = 5.1e-3


def compute_misfits(
    law: str, windows: tuple[float, ...], report: Callable[[], None], *, every: int = 1
) -> xr.Dataset:
    """Largest difference from the published resonances, over T₀, b₀ and the window.

    Parameters
    ----------
    law
        Name in :data:`~remanent.report.settings.FORCING_LAWS`.
    windows
        Lengths of the response window.
    report
        Called after each window.
    every
        Use every so many values of T₀ and b₀ only.

    Returns
    -------
    xarray.Dataset
        ``misfit`` (law, window, reference_temperature, b) and the ``resonance``
        (law, window, reference_temperature, b, temperature, prestress) behind it.
    """
    resonances = []
    for window in windows:
        resonances.append(
            _resonance_frequencies(
                law, window, REFERENCE_TEMPERATURES[::every], ROOT_LOAD_AMPLITUDES[::every]
            )
        )
        report()
    resonance = np.stack(resonances)[None]
    misfit = np.abs(resonance - np.array(PUBLISHED_RESONANCES).T).max(axis=(-2, -1))
    dims = ("law", "window", "reference_temperature", "b")
    setting = Setting(law_name=law)
    return build.dataset(
        {
            "misfit": (dims, misfit),
            "resonance": ((*dims, "temperature", "prestress"), resonance),
        },
        {
            "law": (("law",), np.array([FORCING_LAWS[law].symbol])),
            "window": (("window",), np.array(windows)),
            "reference_temperature": (("reference_temperature",), REFERENCE_TEMPERATURES[::every]),
            "b": (("b",), ROOT_LOAD_AMPLITUDES[::every]),
            "temperature": (("temperature",), np.array(TEMPERATURES)),
            "prestress": (("prestress",), np.array(PRESTRESSES)),
        },
        provenance.attributes(
            setting.actuator,
            setting.build_drive(1.0),
            _RESPONSE_TOLERANCE,
            over=dims[1:],
            width=_RESONANCE_BRACKET_WIDTH,
        ),
    )


def _resonance_frequencies(
    law: str, window: float, temperatures: FloatArray, amplitudes: FloatArray
) -> FloatArray:
    """Array (reference_temperature, b, temperature, prestress)."""
    field, values = FORCING_LAWS[law].drive_field(amplitudes)
    response = frequency_response(
        Setting().actuator,
        FORCING_LAWS[law].build_drive(0.4, 1.0),
        np.linspace(*_FREQUENCY_GRIDS[law]),
        duration=window,
        tolerance=_RESPONSE_TOLERANCE,
        resonance_width=_RESONANCE_BRACKET_WIDTH,
        over={
            "reference_temperature": temperatures,
            field: values,
            "temperature": TEMPERATURES,
            "prestress": PRESTRESSES,
        },
    )
    order = ("reference_temperature", field, "temperature", "prestress")
    return np.asarray(response["resonance"].transpose(*order).values)


def admissible_settings(misfit: xr.Dataset, law: str) -> list[Setting]:
    """Settings that bring all six resonances back: the best of each window.

    Parameters
    ----------
    misfit : xarray.Dataset
        From :func:`compute_misfits`, for one law on the full grid.
    law : str
        Its name in :data:`~remanent.report.settings.FORCING_LAWS`.

    Returns
    -------
    list of Setting
        At most one for each window.
    """
    values = misfit["misfit"].isel(law=0).transpose("window", "reference_temperature", "b").values
    admitted = np.argwhere(values <= MAX_RESONANCE_MISFIT)
    by_window = [admitted[admitted[:, 0] == w] for w in range(values.shape[0])]
    best = [rows[np.argmin(values[tuple(rows.T)])] for rows in by_window if rows.size]
    settings = [
        Setting(
            float(ROOT_LOAD_AMPLITUDES[j]),
            float(REFERENCE_TEMPERATURES[i]),
            float(WINDOW_LENGTHS[w]),
            law,
        )
        for w, i, j in best
    ]
    return list(dict.fromkeys(settings))
