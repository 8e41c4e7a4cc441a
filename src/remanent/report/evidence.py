"""What a verdict is drawn from: the six cases of [Thermal], computed for one setting."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import xarray as xr

from remanent.models.drives.waves import Constant
from remanent.report.settings import (
    MOTION_FREQUENCIES,
    PRESTRESSES,
    PUBLISHED_RESONANCES,
    TEMPERATURES,
    Setting,
)
from remanent.results import build
from remanent.studies.motion.poincare_section import poincare_section
from remanent.studies.motion.simulate import simulate
from remanent.studies.regimes.classify import classify
from remanent.studies.response.frequency_response import frequency_response
from remanent.studies.statics.equilibria import equilibria

#: The six cases, all combinations of these; prestress first as in the published panels.
CASE_VALUES = {"prestress": PRESTRESSES, "temperature": TEMPERATURES}
#: Frequencies at which responses are tabulated before the largest is refined.
RESPONSE_FREQUENCIES = np.linspace(0.5, 2.0, 601)
#: Drive periods in sections: so many until the slowest of the six curves closes.
SECTION_DRIVE_PERIODS = 1000
#: Drive periods after which regimes are judged; the next where one is still undecided.
CLASSIFICATION_RUN_PERIODS = (500, 1000, 2000, 8000)
#: Difference in stretch between a motion and the neighbour whose separation is followed.
NEIGHBOUR_STRETCH_OFFSET = 1e-6


@dataclass(frozen=True)
class ClaimEvidence:
    """Results for one setting; dimensions are (prestress, temperature, ...) throughout.

    Attributes
    ----------
    constant_load_motion
        Histories under the constant load b₀² (figures 2 and 3).
    landscape
        Equilibria and potentials under that load; ``mean_load_equilibria`` under half of it.
    response
        Frequency responses (figure 4), with ``published`` resonances.
    unloaded_equilibria
        Equilibria without load or prestress (temperature): the small-strain modulus.
    periodic_load_motion
        Histories under the periodic load (figures 5 and 6).
    regimes
        What kind of motion that is, with the evidence (``remanent.classify``), and the
        length of the run it took, ``run_periods``; empty until
        :func:`compute_regimes` has computed it.
    section, neighbour_section
        Sections at every drive period, of the motion from rest and of one that starts
        at a stretch larger by :data:`NEIGHBOUR_STRETCH_OFFSET`.
    least_misfits
        Least misfit of the six resonances that each forcing law reaches, by its name;
        empty where the reconstruction was not made.
    """

    setting: Setting
    constant_load_motion: xr.Dataset
    landscape: xr.Dataset
    mean_load_equilibria: xr.Dataset
    unloaded_equilibria: xr.Dataset
    response: xr.Dataset
    periodic_load_motion: xr.Dataset
    section: xr.Dataset
    neighbour_section: xr.Dataset
    regimes: xr.Dataset = field(default_factory=xr.Dataset)
    least_misfits: Mapping[str, float] = field(default_factory=dict)


def gather_evidence(setting: Setting, tolerance: float = 1e-8, every: int = 1) -> ClaimEvidence:
    """Compute everything that verdicts need, for one setting.

    Parameters
    ----------
    setting : Setting
        A choice of what [Thermal] leaves unstated.
    tolerance : float
        Largest error of the integrated motions.
    every : int
        Tabulate responses at every so many of :data:`RESPONSE_FREQUENCIES` only, before refining.

    Returns
    -------
    ClaimEvidence
        Without regimes and misfits, which are found for all settings together.
    """
    actuator, m = setting.actuator, setting.b**2
    section, neighbour = compute_sections(setting, tolerance)
    return ClaimEvidence(
        setting=setting,
        constant_load_motion=simulate(
            actuator,
            Constant(m),
            duration=setting.window_length,
            over=CASE_VALUES,
            tolerance=tolerance,
        ),
        landscape=equilibria(actuator, m, over=CASE_VALUES),
        mean_load_equilibria=equilibria(actuator, m / 2, over=CASE_VALUES),
        unloaded_equilibria=equilibria(actuator, 0.0, over={"temperature": TEMPERATURES}),
        response=compute_responses(setting, tolerance, every),
        periodic_load_motion=compute_motions(setting, tolerance),
        section=section,
        neighbour_section=neighbour,
    )


def compute_responses(setting: Setting, tolerance: float, every: int = 1) -> xr.Dataset:
    """Figure 4, with the published resonances beside the computed ones."""
    response = frequency_response(
        setting.actuator, setting.build_drive(1.0), RESPONSE_FREQUENCIES[::every],
        duration=setting.window_length, over=CASE_VALUES, tolerance=tolerance,
    )  # fmt: skip
    dims = ("prestress", "temperature")
    published = build.dataset({"published": (dims, np.array(PUBLISHED_RESONANCES))}, {}, {})
    return response.assign(published=published["published"])


def compute_motions(setting: Setting, tolerance: float) -> xr.Dataset:
    """Figures 5 and 6: a window of each motion under the periodic load."""
    return simulate(
        setting.actuator, setting.build_drive(1.0), duration=setting.window_length,
        over=_driven_case_values(), tolerance=tolerance,
    )  # fmt: skip


def compute_regimes(settings: Sequence[Setting], tolerance: float) -> list[xr.Dataset]:
    """What kind of motion each is, for settings of one law, all judged together.

    Runs are made longer where it is still undecided.

    Parameters
    ----------
    settings : sequence of Setting
        Choices of what [Thermal] leaves unstated, with one forcing law.
    tolerance : float
        Largest error of a motion in one drive period.

    Returns
    -------
    list of xarray.Dataset
        Regimes (prestress, temperature), with their evidence, for each setting.
    """
    cases = _driven_case_values() | {
        name: xr.DataArray([getattr(setting, name) for setting in settings], dims="setting")
        for name in ("reference_temperature", "b")
    }
    order = ("setting", "prestress", "temperature")
    first, *longer = CLASSIFICATION_RUN_PERIODS
    outcome = _classify_after_periods(settings[0], cases, first, tolerance).transpose(*order)
    for periods in longer:
        undecided = np.nonzero(outcome["regime"].values == "undecided")
        if not undecided[0].size:
            break
        subset = {
            name: xr.DataArray(_values_per_motion(values, outcome)[undecided], dims="case")
            for name, values in cases.items()
        }
        repeated = _classify_after_periods(settings[0], subset, periods, tolerance)
        for name in repeated.data_vars:
            outcome[name].values[undecided] = repeated[name].values
    return [outcome.isel(setting=k) for k in range(len(settings))]


def _classify_after_periods(
    setting: Setting, over: Mapping[str, xr.DataArray], periods: int, tolerance: float
) -> xr.Dataset:
    """Regimes after runs of one length, which ``run_periods`` holds."""
    outcome = classify(
        setting.actuator, setting.build_drive(1.0), periods=periods, over=over, tolerance=tolerance
    )
    regime = outcome["regime"]
    length = {"run_periods": (tuple(map(str, regime.dims)), np.full(regime.shape, periods))}
    return outcome.assign(build.dataset(length, {}, {}))


def _values_per_motion(values: xr.DataArray, outcome: xr.Dataset) -> np.ndarray:
    """Values of a field for every motion, in the shape of the regimes."""
    regime = outcome["regime"].reset_coords(drop=True).drop_vars(list(outcome["regime"].indexes))
    return np.asarray(values.broadcast_like(regime).transpose(*regime.dims).values)


def compute_sections(setting: Setting, tolerance: float) -> tuple[xr.Dataset, xr.Dataset]:
    """Sections of each motion and of a neighbour."""
    start = xr.DataArray([1.0, 1.0 + NEIGHBOUR_STRETCH_OFFSET], dims="start")
    section = poincare_section(
        setting.actuator, setting.build_drive(1.0), periods=SECTION_DRIVE_PERIODS,
        over={**_driven_case_values(), "initial.stretch": start}, tolerance=tolerance,
    )  # fmt: skip
    return section.isel(start=0), section.isel(start=1)


def _driven_case_values() -> dict[str, xr.DataArray]:
    """Each prestress with its own drive frequency."""
    return {
        "prestress": xr.DataArray(list(PRESTRESSES), dims="prestress"),
        "omega": xr.DataArray(list(MOTION_FREQUENCIES), dims="prestress"),
        "temperature": xr.DataArray(list(TEMPERATURES), dims="temperature"),
    }
