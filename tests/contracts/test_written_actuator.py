"""An actuator written by hand as formulas gives what `Actuator` gives, within both errors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from remanent._instructions import program_cost
from remanent.codegen.field import vector_field_for

DRIVE = rm.SineSquared(0.4, 1.25)
#: One coordinate: energies per 8 H L^2 mu of equal stretches.
BUILT = rm.Actuator(temperature=350.0, prestress=0.1, dissipation=rm.Rayleigh(0.05))
WRITTEN = rm.LagrangianSystem(
    coordinates="stretch",
    kinetic="stretch_rate**2/3 + 2*c*stretch_rate**2/(3*stretch**6)",
    potential="temperature/reference_temperature*(2*stretch**2 + stretch**-4 - 3)/2"
    " - load/stretch**2 - 2*prestress*(stretch - 1)",
    dissipation="eta*stretch_rate**2",
    parameters={
        "c": 1.0, "temperature": 350.0, "reference_temperature": 293.0, "prestress": 0.1,
        "eta": 0.05,
    },
    observable="stretch**-2",
    rest={"stretch": 1.0},
)  # fmt: skip
#: Two coordinates, of unequal dead loads.
BUILT_PAIR = rm.Actuator(prestress=(0.1, 0.05), dissipation=rm.Rayleigh(0.1))
WRITTEN_PAIR = rm.LagrangianSystem(
    coordinates=("stretch_1", "stretch_2"),
    kinetic="(stretch_1_rate**2 + stretch_2_rate**2 + c*(stretch_1_rate*stretch_2"
    " + stretch_2_rate*stretch_1)**2/(stretch_1*stretch_2)**4)/6",
    potential="(stretch_1**2 + stretch_2**2 + 1/(stretch_1*stretch_2)**2 - 3)/2"
    " - load/(stretch_1*stretch_2) - s_1*(stretch_1 - 1) - s_2*(stretch_2 - 1)",
    dissipation="eta*(stretch_1_rate**2 + stretch_2_rate**2)/2",
    parameters={"c": 1.0, "s_1": 0.1, "s_2": 0.05, "eta": 0.1},
    observable="1/(stretch_1*stretch_2)",
    rest={"stretch_1": 1.0, "stretch_2": 1.0},
)
BOX = {"stretch": (0.5, 2.5), "stretch_rate": (-2.0, 2.0)}
PAIR_BOX = {
    "stretch_1": (0.7, 1.5), "stretch_1_rate": (-0.5, 0.5),
    "stretch_2": (0.7, 1.5), "stretch_2_rate": (-0.5, 0.5),
}  # fmt: skip

#: Calls of verbs; what is compared, and the variable with the error of each.
CALLS: dict[str, tuple[Callable[..., xr.Dataset], dict[str, Any], dict[str, str]]] = {
    "simulate": (rm.simulate, {"duration": 20.0}, {"energy": "error", "load": "error"}),
    "poincare_section": (rm.poincare_section, {"periods": 20}, {}),
    "crossings": (
        rm.crossings, {"variable": "stored_energy", "value": 0.01, "duration": 20.0},
        {"crossing_time": "crossing_time_error"},
    ),
    "energy_balance": (
        rm.energy_balance, {"duration": 10.0},
        {"drive_work": "drive_work_error", "dissipated_energy": "dissipated_energy_error"},
    ),
    "cycle_losses": (
        rm.cycle_losses, {"periods": 5}, {"dissipated_energy": "dissipated_energy_error"},
    ),
    "lyapunov": (rm.lyapunov, {"periods": 60}, {"exponent": "exponent_error"}),
}  # fmt: skip
#: Calls of one coordinate only.
SINGLE_CALLS: dict[str, tuple[Callable[..., xr.Dataset], dict[str, Any], dict[str, str]]] = {
    "frequency_response": (
        rm.frequency_response, {"omega": np.linspace(1.0, 1.4, 9), "duration": 40.0},
        {"amplitude": "amplitude_error", "maximum": "amplitude_error"},
    ),
    "periodic_orbits": (
        rm.periodic_orbits, {"state_box": BOX},
        {"initial": "error", "maximum": "maximum_error", "amplitude": "amplitude_error"},
    ),
    "continue_orbit": (
        rm.continue_orbit,
        {"parameter": "omega", "parameter_range": (1.1, 1.5), "state_box": BOX, "max_points": 400},
        {"special_omega": "special_error"},
    ),
    "classify": (rm.classify, {"periods": 200}, {"exponent": "exponent_error"}),
}  # fmt: skip


def assert_alike(one: xr.Dataset, other: xr.Dataset, compared: dict[str, str]) -> None:
    """Variables agree within both errors and rounding, and so do the states."""
    assert one.status.values.tolist() == other.status.values.tolist()
    # Points of two branches lie at other values of the parameter.
    states = [k for k in one.data_vars if str(k).startswith("stretch") and "point" not in one.dims]
    errors = dict.fromkeys(map(str, states), "error") | compared
    for name, error in errors.items():
        if error not in one:
            continue
        slack = one[error] + other[error] + 1e-12 * (1.0 + abs(one[name]))
        left = abs(one[name] - other[name]) - slack
        assert bool((left.fillna(0.0) <= 0.0).all()), name
        np.testing.assert_array_equal(np.isnan(one[name]), np.isnan(other[name]))


@pytest.mark.parametrize("name", [*CALLS, *SINGLE_CALLS])
def test_a_written_actuator_of_one_coordinate(name: str) -> None:
    """Lagrange's equations from the energies alone."""
    verb, options, compared = {**CALLS, **SINGLE_CALLS}[name]
    assert_alike(verb(WRITTEN, DRIVE, **options), verb(BUILT, DRIVE, **options), compared)


@pytest.mark.parametrize("name", [*CALLS])
def test_a_written_actuator_of_two_coordinates(name: str) -> None:
    """The same of a pair of coupled coordinates."""
    verb, options, compared = CALLS[name]
    one, other = (verb(s, DRIVE, **options) for s in (WRITTEN_PAIR, BUILT_PAIR))
    assert_alike(one, other, compared)


def test_orbits_of_two_written_coordinates() -> None:
    """The one orbit of a damped pair, its multipliers and its extremes."""
    one, other = (
        rm.periodic_orbits(s, DRIVE, state_box=PAIR_BOX) for s in (WRITTEN_PAIR, BUILT_PAIR)
    )
    assert one.sizes["orbit"] == other.sizes["orbit"] == 1
    assert_alike(one, other, {"initial": "error", "amplitude": "amplitude_error"})


@pytest.mark.parametrize("m", [0.0, 0.16, -0.3])
def test_equilibria_of_a_written_actuator(m: float) -> None:
    """Places, energies and natural frequencies, in one coordinate and two."""
    one = rm.equilibria(WRITTEN, m, state_box={"stretch": (0.3, 4.0)})
    other = rm.equilibria(BUILT, m)
    for name in ("stretch", "natural_frequency", "equilibrium_potential"):
        both = one[f"{name}_error"].values + other[f"{name}_error"].values
        assert (np.abs(one[name].values - other[name].values) <= both).all()
    box = {"stretch_1": (0.3, 4.0), "stretch_2": (0.3, 4.0)}
    pair, built = rm.equilibria(WRITTEN_PAIR, m, state_box=box), rm.equilibria(BUILT_PAIR, m)
    assert pair.sizes["equilibrium"] == built.sizes["equilibrium"]
    for name in ("stretch_1", "stretch_2", "natural_frequency"):
        both = pair[f"{name}_error"].values + built[f"{name}_error"].values
        assert (np.abs(pair[name].values - built[name].values) <= both).all()


def test_free_oscillations_of_a_written_actuator() -> None:
    """The backbone without damping, within both errors."""
    free = WRITTEN.replace(dissipation="0*eta*stretch_rate**2")
    with pytest.raises(rm.InputError, match="dissipates"):
        rm.backbone(free, [1.2])
    parameters = {k: v for k, v in WRITTEN.parameter_values().items() if k != "eta"}
    free = rm.LagrangianSystem(
        coordinates="stretch", kinetic=WRITTEN.kinetic, potential=WRITTEN.potential,
        parameters=parameters, observable="stretch**-2", rest={"stretch": 1.0},
    )  # fmt: skip
    one = rm.backbone(free, [1.2, 2.0])
    other = rm.backbone(BUILT.replace(dissipation=()), [1.2, 2.0])
    assert (np.abs(one.frequency - other.frequency)
            <= one.frequency_error + other.frequency_error).all()  # fmt: skip
    assert (np.abs(one.maximum - other.maximum) <= one.error + other.error).all()


def test_the_code_of_a_written_actuator_is_short() -> None:
    """No longer than that of the block, of one coordinate and of two."""
    for written, built in ((WRITTEN, BUILT), (WRITTEN_PAIR, BUILT_PAIR)):
        one, other = (program_cost(vector_field_for(s, DRIVE).rates) for s in (written, built))
        assert one <= other
