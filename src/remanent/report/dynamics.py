"""What lies behind figures 4 to 6: periodic orbits, the fold, the jump, and where chaos is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
import xarray as xr

from remanent.report.evidence import CASE_VALUES
from remanent.report.settings import MOTION_FREQUENCIES, REFERENCE_SETTING, TEMPERATURES
from remanent.results import build
from remanent.studies.motion.poincare_section import poincare_section
from remanent.studies.orbits.manifold_crossing import manifold_crossing
from remanent.studies.orbits.periodic_orbits import periodic_orbits
from remanent.studies.orbits.response_diagram import response_diagram
from remanent.studies.regimes.regime_chart import regime_chart
from remanent.studies.response.frequency_response import frequency_response

#: Frequencies over which branches are followed.
_BRANCH_FREQUENCY_RANGE = (0.7, 1.5)
#: Frequencies at which branches are looked for.
_BRANCH_SEARCH_FREQUENCY_COUNT = 3
#: The case whose fold and jump are located: the published resonance at 1.25.
JUMP_CASE: Final = {"prestress": 0.0, "temperature": 350.0}
#: The jump is looked for from so far below the resonance.
_JUMP_SEARCH_BELOW_RESONANCE = 0.005
#: The jump is looked for up to so far above the resonance.
_JUMP_SEARCH_ABOVE_RESONANCE = 0.001
#: Width of the last bracket of the jump.
_JUMP_BRACKET_WIDTH = 1e-9
#: Distance in frequency from the jump of the two motions drawn beside it.
_JUMP_SIDE_FREQUENCY_OFFSET = 1e-6
#: Drive periods of these two motions.
_JUMP_SIDE_DRIVE_PERIODS = 160
#: Half of the interval of frequencies drawn around the jump.
_JUMP_RESPONSE_HALF_WIDTH = 0.02
#: Frequencies in that interval.
_JUMP_RESPONSE_FREQUENCY_COUNT = 241
#: Tolerance of the motions and the response around the jump.
_JUMP_TOLERANCE = 1e-6
#: Roots of the peak load of the chart of regimes, at the reference temperature.
_CHART_B = np.array([0.5, 1.0, 1.5, 2.0, 3.0, 4.0])
#: Drive frequencies of the chart.
_CHART_OMEGA = np.linspace(0.75, 3.0, 10)
#: Drive periods after which the motions of the chart are judged.
_CHART_DRIVE_PERIODS = 400
#: Tolerance of the motions of the chart.
_CHART_TOLERANCE = 1e-6


def compute_branches_and_orbits(resonance: xr.DataArray) -> dict[str, xr.Dataset]:
    """All branches of forced response, and the orbits that coexist at each resonance.

    Parameters
    ----------
    resonance : xarray.DataArray
        ω of the largest amplitude (prestress, temperature).

    Returns
    -------
    dict of str to xarray.Dataset
        ``branches`` and ``resonance_orbits``.
    """
    actuator, drive = REFERENCE_SETTING.actuator, REFERENCE_SETTING.build_drive(1.0)
    omega = xr.DataArray(
        resonance.transpose("prestress", "temperature").values, dims=("prestress", "temperature")
    )
    return {
        "branches": response_diagram(
            actuator,
            drive,
            _BRANCH_FREQUENCY_RANGE,
            over=CASE_VALUES,
            slices=_BRANCH_SEARCH_FREQUENCY_COUNT,
        ),
        "resonance_orbits": periodic_orbits(actuator, drive, over={**CASE_VALUES, "omega": omega}),
    }


def locate_jump(resonance: xr.DataArray) -> dict[str, xr.Dataset]:
    """Where the motion from rest crosses the saddle's stable manifold, and what it does there.

    Parameters
    ----------
    resonance : xarray.DataArray
        ω of the largest amplitude (prestress, temperature).

    Returns
    -------
    dict of str to xarray.Dataset
        ``jump``, the crossing; ``jump_sections``, a motion on either side of it;
        ``jump_response``, the response from rest around it.
    """
    actuator, drive = (
        REFERENCE_SETTING.actuator.replace(**JUMP_CASE),
        REFERENCE_SETTING.build_drive(1.0),
    )
    peak = float(resonance.sel(JUMP_CASE))
    crossing = manifold_crossing(
        actuator,
        drive,
        "omega",
        (peak - _JUMP_SEARCH_BELOW_RESONANCE, peak + _JUMP_SEARCH_ABOVE_RESONANCE),
        width=_JUMP_BRACKET_WIDTH,
    )
    omega = float(crossing["omega"])
    sections = poincare_section(
        actuator, drive, periods=_JUMP_SIDE_DRIVE_PERIODS,
        over={"omega": [omega - _JUMP_SIDE_FREQUENCY_OFFSET, omega + _JUMP_SIDE_FREQUENCY_OFFSET]},
        tolerance=_JUMP_TOLERANCE,
    )  # fmt: skip
    response = frequency_response(
        actuator, drive,
        np.linspace(
            omega - _JUMP_RESPONSE_HALF_WIDTH, omega + _JUMP_RESPONSE_HALF_WIDTH,
            _JUMP_RESPONSE_FREQUENCY_COUNT,
        ),
        duration=REFERENCE_SETTING.window_length, tolerance=_JUMP_TOLERANCE,
    )  # fmt: skip
    return {"jump": crossing, "jump_sections": sections, "jump_response": response}


def compute_chaos_chart() -> dict[str, xr.Dataset]:
    """Regimes from rest over the plane of frequency and load, without prestress.

    At the reference temperature; with ω/√θ and b/√θ it is that of every temperature, where
    ``chart_cases`` says the places of the published ones.

    Returns
    -------
    dict of str to xarray.Dataset
        ``chart`` (b, omega) and ``chart_cases`` (temperature).
    """
    actuator, drive = REFERENCE_SETTING.actuator, REFERENCE_SETTING.build_drive(1.0)
    regimes = regime_chart(
        actuator, drive, {"b": _CHART_B, "omega": _CHART_OMEGA},
        periods=_CHART_DRIVE_PERIODS, tolerance=_CHART_TOLERANCE,
    )  # fmt: skip
    root = np.sqrt(np.array(TEMPERATURES) / REFERENCE_SETTING.reference_temperature)
    published = build.dataset(
        {
            "omega": (("temperature",), MOTION_FREQUENCIES[0] / root),
            "b": (("temperature",), REFERENCE_SETTING.b / root),
        },
        {"temperature": (("temperature",), np.array(TEMPERATURES))},
        {},
    )
    return {"chart": regimes, "chart_cases": published}


def summarise_dynamics(data: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """What programs read of orbits, the jump, chaos and the regimes.

    Parameters
    ----------
    data : mapping of str to xarray.Dataset
        Results by name.

    Returns
    -------
    dict
        Plain data, which JSON can hold.
    """
    folds = list_folds(data["branches"])
    return {
        "regimes": _list_regimes(data["regimes"]),
        "orbits": _list_orbits(data["resonance_orbits"]),
        "folds": folds,
        "jump": _summarise_jump(data["jump"], folds),
        "chaos": _summarise_chaos(data["chart"], data["chart_cases"]),
    }


def _split_by_case(dataset: xr.Dataset) -> list[tuple[dict[str, float], xr.Dataset]]:
    """The six cases by their coordinates, each with its part of a Dataset."""
    return [
        ({"temperature": float(t), "prestress": float(s)}, dataset.sel(prestress=s, temperature=t))
        for s in dataset["prestress"].values
        for t in dataset["temperature"].values
    ]


#: Numbers that a regime is reported with.
_REGIME_EVIDENCE_VARIABLES = (
    "exponent", "exponent_error", "rotation_number", "rotation_digits", "digits", "zero_one",
    "margin",
)  # fmt: skip


def _list_regimes(dataset: xr.Dataset) -> list[dict[str, Any]]:
    return [
        at
        | {"omega": float(case["omega"]), "regime": str(case["regime"].values)}
        | {"periods": int(case["run_periods"])}
        | {name: _finite_or_none(case[name]) for name in _REGIME_EVIDENCE_VARIABLES}
        for at, case in _split_by_case(dataset)
    ]


def _list_orbits(dataset: xr.Dataset) -> list[dict[str, Any]]:
    orbits = []
    for at, case in _split_by_case(dataset):
        for k in np.flatnonzero(np.isfinite(case["residual"].values)):
            orbit = case.isel(orbit=k)
            orbits.append(
                at
                | {"omega": float(case["omega"]), "stability": str(orbit["stability"].values)}
                | {name: _finite_or_none(orbit[name]) for name in ("amplitude", "residual")}
                | {"initial": [float(v) for v in orbit["initial"].values]}
                | {"multipliers": [[m.real, m.imag] for m in orbit["multipliers"].values.tolist()]}
            )
    return orbits


def list_folds(branches: xr.Dataset) -> list[dict[str, float]]:
    """Every fold on the branches: its case, its frequency with its error, its stretch."""
    return [
        at
        | {
            "omega": float(case["special_omega"][k]),
            "error": float(case["special_error"][k]),
            "stretch": float(case["special_stretch"][k]),
        }
        for at, case in _split_by_case(branches)
        for k in np.flatnonzero(case["special_kind"].values == "fold")
    ]


def _summarise_jump(crossing: xr.Dataset, folds: list[dict[str, float]]) -> dict[str, Any]:
    fold = next(f for f in folds if all(f[name] == v for name, v in JUMP_CASE.items()))
    return {
        **JUMP_CASE,
        "omega": float(crossing["omega"]),
        "error": float(crossing["omega_error"]),
        "saddle": [float(crossing["stretch"]), float(crossing["stretch_rate"])],
        "multiplier": float(crossing["multipliers"].values.real.max()),
        "fold": fold["omega"],
        "fold_error": fold["error"],
    }


def _summarise_chaos(dataset: xr.Dataset, published: xr.Dataset) -> dict[str, Any]:
    kinds, counts = np.unique(dataset["regime"].values, return_counts=True)
    points: list[dict[str, Any]] = [
        {name: float(dataset[name][j]) for name, j in (("b", k[0]), ("omega", k[1]))}
        | {
            name: _finite_or_none(dataset[name][k])
            for name in ("exponent", "exponent_error", "margin")
        }
        for k in map(tuple, np.argwhere((dataset["regime"] == "chaotic").values))
    ]
    return {
        "setting": f"{REFERENCE_SETTING.actuator!r}, from rest; b and omega are b/√θ and ω/√θ",
        "periods": _CHART_DRIVE_PERIODS,
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


def _finite_or_none(value: xr.DataArray) -> float | None:
    """A number, or None where JSON has none for it."""
    return float(value) if np.isfinite(value) else None
