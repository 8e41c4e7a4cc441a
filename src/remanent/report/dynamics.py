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

#: Frequencies over which branches are followed, and at how many of them they are looked for.
_RANGE, _SLICES = (0.7, 1.5), 3
#: The case whose fold and jump are located: the published resonance at 1.25.
NEAR: Final = {"prestress": 0.0, "temperature": 350.0}
#: The jump is looked for from so far below the resonance to so far above it.
_AROUND = (0.005, 0.001)
#: Width of its last bracket; distance of the motions drawn beside it, and their periods.
_WIDTH, _BESIDE, _PERIODS = 1e-9, 1e-6, 160
#: Frequencies drawn around the jump, from so far below it to the fold.
_BELOW, _POINTS = 0.02, 241
#: The chart of regimes, at the reference temperature.
_AMPLITUDES, _FREQUENCIES = np.array([0.5, 1.0, 1.5, 2.0, 3.0, 4.0]), np.linspace(0.75, 3.0, 10)
_CHART_PERIODS, _CHART_TOLERANCE = 400, 1e-6

Data = dict[str, xr.Dataset]


def orbits(resonance: xr.DataArray) -> Data:
    """All branches of forced response, and the orbits that coexist at each resonance.

    Parameters
    ----------
    resonance
        ω of the largest amplitude (prestress, temperature).
    """
    actuator, drive = REFERENCE.actuator, REFERENCE.drive(1.0)
    omega = xr.DataArray(
        resonance.transpose("prestress", "temperature").values, dims=("prestress", "temperature")
    )
    return {
        "branches": response_diagram(actuator, drive, _RANGE, over=CASES, slices=_SLICES),
        "resonance_orbits": periodic_orbits(actuator, drive, over={**CASES, "omega": omega}),
    }


def jump(resonance: xr.DataArray) -> Data:
    """Where the motion from rest crosses the saddle's stable manifold, and what it does there.

    Parameters
    ----------
    resonance
        As for :func:`orbits`.
    """
    actuator, drive = REFERENCE.actuator.replace(**NEAR), REFERENCE.drive(1.0)
    peak = float(resonance.sel(NEAR))
    crossing = manifold_crossing(
        actuator, drive, "omega", (peak - _AROUND[0], peak + _AROUND[1]), width=_WIDTH
    )
    at = float(crossing["omega"])
    beside = poincare_section(
        actuator, drive, periods=_PERIODS, over={"omega": [at - _BESIDE, at + _BESIDE]},
        tolerance=1e-6,
    )  # fmt: skip
    near = frequency_response(
        actuator, drive, np.linspace(at - _BELOW, at + _BELOW, _POINTS),
        duration=REFERENCE.window, tolerance=1e-6,
    )  # fmt: skip
    return {"jump": crossing, "jump_sections": beside, "jump_response": near}


def chart() -> Data:
    """Regimes from rest over the plane of frequency and load, without prestress.

    At the reference temperature; with ω/√θ and b/√θ it is that of every temperature, where
    ``chart_cases`` says the places of the published ones.
    """
    actuator, drive = REFERENCE.actuator, REFERENCE.drive(1.0)
    found = regime_chart(
        actuator, drive, {"b": _AMPLITUDES, "omega": _FREQUENCIES},
        periods=_CHART_PERIODS, tolerance=_CHART_TOLERANCE,
    )  # fmt: skip
    root = np.sqrt(np.array(TEMPERATURES) / REFERENCE.reference_temperature)
    paper = build.dataset(
        {
            "omega": (("temperature",), FREQUENCIES[0] / root),
            "b": (("temperature",), REFERENCE.b / root),
        },
        {"temperature": (("temperature",), np.array(TEMPERATURES))},
        {},
    )
    return {"chart": found, "chart_cases": paper}


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


_EVIDENCE = (
    "exponent", "exponent_error", "rotation_number", "rotation_digits", "digits", "zero_one",
    "margin",
)  # fmt: skip


def _regimes(dataset: xr.Dataset) -> list[dict[str, Any]]:
    return [
        at
        | {"omega": float(one["omega"]), "regime": str(one["regime"].values)}
        | {"periods": int(one["run_periods"])}
        | {name: _number(one[name]) for name in _EVIDENCE}
        for at, one in _cases(dataset)
    ]


def _orbits(dataset: xr.Dataset) -> list[dict[str, Any]]:
    found = []
    for at, one in _cases(dataset):
        for k in np.flatnonzero(np.isfinite(one["residual"].values)):
            orbit = one.isel(orbit=k)
            found.append(
                at
                | {"omega": float(one["omega"]), "stability": str(orbit["stability"].values)}
                | {name: _number(orbit[name]) for name in ("amplitude", "residual")}
                | {"initial": [float(v) for v in orbit["initial"].values]}
                | {"multipliers": [[m.real, m.imag] for m in orbit["multipliers"].values.tolist()]}
            )
    return found


def folds(branches: xr.Dataset) -> list[dict[str, float]]:
    """Every fold on the branches, with its error."""
    return [
        at
        | {
            "omega": float(one["special_omega"][k]),
            "error": float(one["special_error"][k]),
            "stretch": float(one["special_stretch"][k]),
        }
        for at, one in _cases(branches)
        for k in np.flatnonzero(one["special_kind"].values == "fold")
    ]


def _jump(crossing: xr.Dataset, known: list[dict[str, float]]) -> dict[str, Any]:
    fold = next(one for one in known if all(one[k] == v for k, v in NEAR.items()))
    return {
        **NEAR,
        "omega": float(crossing["omega"]),
        "error": float(crossing["omega_error"]),
        "saddle": [float(crossing["stretch"]), float(crossing["stretch_rate"])],
        "multiplier": float(crossing["multipliers"].values.real.max()),
        "fold": fold["omega"],
        "fold_error": fold["error"],
    }


def _chaos(dataset: xr.Dataset, paper: xr.Dataset) -> dict[str, Any]:
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
        "least_b": min((one["b"] for one in points), default=None),
        "paper": [
            {name: float(paper[name].sel(temperature=t)) for name in ("temperature", "b", "omega")}
            for t in paper["temperature"].values
        ],
    }


def _number(value: xr.DataArray) -> float | None:
    """A number as JSON knows it."""
    return float(value) if np.isfinite(value) else None
