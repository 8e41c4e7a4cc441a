"""What lies behind figures 4 to 6: periodic orbits, the fold, the jump, and where chaos is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
import xarray as xr

from remanent.report.evidence import CASES
from remanent.report.settings import FREQUENCIES, REFERENCE, TEMPERATURES
from remanent.results import build
from remanent.studies.motion.poincare_section import poincare_section
from remanent.studies.orbits.manifold_crossing import manifold_crossing
from remanent.studies.orbits.periodic_orbits import periodic_orbits
from remanent.studies.orbits.response_diagram import response_diagram
from remanent.studies.regimes.regime_chart import regime_chart
from remanent.studies.response.frequency_response import frequency_response

#: Frequencies between which branches are followed.
_OMEGA_RANGE: Final = (0.7, 1.5)
#: Number of frequencies at which branches are looked for.
_SLICES: Final = 3
#: The case whose fold and jump are located: the published resonance at 1.25.
NEAR: Final = {"prestress": 0.0, "temperature": 350.0}
#: Distance below the resonance from which the jump is looked for.
_JUMP_BELOW: Final = 0.005
#: Distance above the resonance up to which the jump is looked for.
_JUMP_ABOVE: Final = 0.001
#: Width of the last bracket of the jump.
_JUMP_WIDTH: Final = 1e-9
#: Distance in frequency from the jump of the two motions that are drawn beside it.
_SECTION_DISTANCE: Final = 1e-6
#: Drive periods of these motions.
_SECTION_PERIODS: Final = 160
#: Distance in frequency to which the response is drawn on both sides of the jump.
_RESPONSE_DISTANCE: Final = 0.02
#: Number of frequencies of that response.
_RESPONSE_POINTS: Final = 241
#: Tolerance of what is only drawn.
_DRAWING_TOLERANCE: Final = 1e-6
#: Amplitudes b of the chart of regimes, at the reference temperature.
_CHART_AMPLITUDES: Final = np.array([0.5, 1.0, 1.5, 2.0, 3.0, 4.0])
#: Frequencies of the chart of regimes, at the reference temperature.
_CHART_OMEGAS: Final = np.linspace(0.75, 3.0, 10)
#: Drive periods after which its regimes are judged.
_CHART_PERIODS: Final = 400
#: Tolerance of its motions.
_CHART_TOLERANCE: Final = 1e-6

Data = dict[str, xr.Dataset]


def orbits(resonance: xr.DataArray) -> Data:
    """All branches of forced response, and the orbits that coexist at each resonance.

    Parameters
    ----------
    resonance : xarray.DataArray (prestress, temperature)
        ω of the largest amplitude.
    """
    actuator, drive = REFERENCE.actuator, REFERENCE.drive(1.0)
    omega = xr.DataArray(
        resonance.transpose("prestress", "temperature").values, dims=("prestress", "temperature")
    )
    return {
        "branches": response_diagram(actuator, drive, _OMEGA_RANGE, over=CASES, slices=_SLICES),
        "resonance_orbits": periodic_orbits(actuator, drive, over={**CASES, "omega": omega}),
    }


def jump(resonance: xr.DataArray) -> Data:
    """Where the motion from rest crosses the saddle's stable manifold, and what it does there.

    Parameters
    ----------
    resonance : xarray.DataArray (prestress, temperature)
        ω of the largest amplitude.
    """
    actuator, drive = REFERENCE.actuator.replace(**NEAR), REFERENCE.drive(1.0)
    peak = float(resonance.sel(NEAR))
    crossing = manifold_crossing(
        actuator, drive, "omega", (peak - _JUMP_BELOW, peak + _JUMP_ABOVE), width=_JUMP_WIDTH
    )
    omega = float(crossing["omega"])
    sections = poincare_section(
        actuator, drive, periods=_SECTION_PERIODS,
        over={"omega": [omega - _SECTION_DISTANCE, omega + _SECTION_DISTANCE]},
        tolerance=_DRAWING_TOLERANCE,
    )  # fmt: skip
    omegas = np.linspace(omega - _RESPONSE_DISTANCE, omega + _RESPONSE_DISTANCE, _RESPONSE_POINTS)
    response = frequency_response(
        actuator, drive, omegas, duration=REFERENCE.window, tolerance=_DRAWING_TOLERANCE
    )
    return {"jump": crossing, "jump_sections": sections, "jump_response": response}


def chart() -> Data:
    """Regimes from rest over the plane of frequency and load, without prestress.

    At the reference temperature; with ω/√θ and b/√θ it is that of every temperature, where
    ``chart_cases`` says the places of the published ones.
    """
    actuator, drive = REFERENCE.actuator, REFERENCE.drive(1.0)
    regimes = regime_chart(
        actuator, drive, {"b": _CHART_AMPLITUDES, "omega": _CHART_OMEGAS},
        periods=_CHART_PERIODS, tolerance=_CHART_TOLERANCE,
    )  # fmt: skip
    root = np.sqrt(np.array(TEMPERATURES) / REFERENCE.reference_temperature)
    published = build.dataset(
        {
            "omega": (("temperature",), FREQUENCIES[0] / root),
            "b": (("temperature",), REFERENCE.b / root),
        },
        {"temperature": (("temperature",), np.array(TEMPERATURES))},
        {},
    )
    return {"chart": regimes, "chart_cases": published}


def summarise(data: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """What programs read of all this, and of the regimes."""
    return {
        "regimes": _regimes(data["regimes"]),
        "orbits": _orbits(data["resonance_orbits"]),
        "folds": folds(data["branches"]),
        "jump": _jump(data["jump"], folds(data["branches"])),
        "chaos": _chaos(data["chart"], data["chart_cases"]),
    }


def _cases(dataset: xr.Dataset) -> list[tuple[dict[str, float], xr.Dataset]]:
    """The six cases, each with what is known of it."""
    return [
        ({"temperature": float(t), "prestress": float(s)}, dataset.sel(prestress=s, temperature=t))
        for s in dataset["prestress"].values
        for t in dataset["temperature"].values
    ]


#: Variables of the evidence for a regime that programs read.
_EVIDENCE: Final = (
    "exponent", "exponent_error", "rotation_number", "rotation_digits", "digits", "zero_one",
    "margin",
)  # fmt: skip


def _regimes(dataset: xr.Dataset) -> list[dict[str, Any]]:
    return [
        case
        | {"omega": float(motion["omega"]), "regime": str(motion["regime"].values)}
        | {"periods": int(motion["run_periods"])}
        | {name: _number(motion[name]) for name in _EVIDENCE}
        for case, motion in _cases(dataset)
    ]


def _orbits(dataset: xr.Dataset) -> list[dict[str, Any]]:
    rows = []
    for case, coexisting in _cases(dataset):
        for k in np.flatnonzero(np.isfinite(coexisting["residual"].values)):
            orbit = coexisting.isel(orbit=k)
            rows.append(
                case
                | {"omega": float(coexisting["omega"]), "stability": str(orbit["stability"].values)}
                | {name: _number(orbit[name]) for name in ("amplitude", "residual")}
                | {"initial": [float(v) for v in orbit["initial"].values]}
                | {"multipliers": [[m.real, m.imag] for m in orbit["multipliers"].values.tolist()]}
            )
    return rows


def folds(branches: xr.Dataset) -> list[dict[str, float]]:
    """Every fold on the branches, with its error."""
    return [
        case
        | {
            "omega": float(branch["special_omega"][k]),
            "error": float(branch["special_error"][k]),
            "stretch": float(branch["special_stretch"][k]),
        }
        for case, branch in _cases(branches)
        for k in np.flatnonzero(branch["special_kind"].values == "fold")
    ]


def _jump(crossing: xr.Dataset, located: list[dict[str, float]]) -> dict[str, Any]:
    fold = next(fold for fold in located if all(fold[k] == v for k, v in NEAR.items()))
    return {
        **NEAR,
        "omega": float(crossing["omega"]),
        "error": float(crossing["omega_error"]),
        "saddle": [float(crossing["stretch"]), float(crossing["stretch_rate"])],
        "multiplier": float(crossing["multipliers"].values.real.max()),
        "fold": fold["omega"],
        "fold_error": fold["error"],
    }


def _chaos(dataset: xr.Dataset, published: xr.Dataset) -> dict[str, Any]:
    kinds, counts = np.unique(dataset["regime"].values, return_counts=True)
    points: list[dict[str, Any]] = [
        {name: float(dataset[name][j]) for name, j in (("b", k[0]), ("omega", k[1]))}
        | {name: _number(dataset[name][k]) for name in ("exponent", "exponent_error", "margin")}
        for k in map(tuple, np.argwhere((dataset["regime"] == "chaotic").values))
    ]
    return {
        "setting": f"{REFERENCE.actuator!r}, from rest; b and omega are b/√θ and ω/√θ",
        "periods": _CHART_PERIODS,
        "b": [float(v) for v in dataset["b"].values],
        "omega": [float(v) for v in dataset["omega"].values],
        "counts": dict(zip(kinds.tolist(), counts.tolist(), strict=True)),
        "chaotic": points,
        "least_b": min((point["b"] for point in points), default=None),
        "paper": [
            {
                name: float(published[name].sel(temperature=t))
                for name in ("temperature", "b", "omega")
            }
            for t in published["temperature"].values
        ],
    }


def _number(value: xr.DataArray) -> float | None:
    """A number as JSON knows it."""
    return float(value) if np.isfinite(value) else None
