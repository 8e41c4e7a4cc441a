"""A sound call of every verb, as cheap as there are, which tests spoil to see what is refused."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np
import xarray as xr

import remanent as rm

BODY = rm.Actuator()
DAMPED = rm.Actuator(dissipation=rm.Rayleigh(0.1))
HOT = rm.Actuator(temperature=350.0)
DRIVE = rm.SineSquared(0.4, 1.25)
BARELY_DAMPED, FAST = rm.Actuator(dissipation=rm.Rayleigh(0.01)), rm.SineSquared(0.8, 2.4)
STEP = rm.Steps((0.0,), (0.1,))
SIZED = rm.Actuator.from_si(
    shear_modulus="100 kPa",
    density="2000 kg/m^3",
    half_length="5 mm",
    half_thickness="0.5 mm",
)


@cache
def decaying() -> xr.Dataset:
    return rm.simulate(DAMPED, rm.Constant(0.1), duration=40.0)


@cache
def branch() -> xr.Dataset:
    return rm.continue_orbit(BARELY_DAMPED, FAST, "omega", (2.25, 2.45))


@cache
def measure() -> rm.Measure:
    return rm.Measure(rm.equilibria, BODY, 0.16, of="turning_upper")


def data() -> dict[str, np.ndarray]:
    run = rm.simulate(DAMPED, STEP, times=np.linspace(0.0, 5.0, 21))
    return {"time": run.time.values, "thickness_stretch": run.thickness_stretch.values}


#: Arguments of a sound call of every verb, as cheap as there are.
SOUND: Mapping[str, Callable[[], dict[str, Any]]] = {
    "backbone": lambda: {"actuator": BODY, "stretch": [1.05]},
    "basins": lambda: {
        "system": DAMPED, "drive": DRIVE, "periods": 100,
        "grid": {"stretch": [1.0, 1.1], "stretch_rate": [0.0]},
    },
    "bifurcation_diagram": lambda: {
        "system": DAMPED, "drive": DRIVE, "parameter": "b", "values": [0.3, 0.4], "discard": 2,
        "keep": 2,
    },
    "classify": lambda: {"system": DAMPED, "drive": DRIVE, "periods": 100},
    "continue_bifurcation": lambda: {
        "system": HOT, "drive": rm.SineSquared(0.4, 1.2668), "kind": "fold",
        "parameters": ("omega", "b"), "parameter_ranges": [(1.2, 1.3), (0.35, 0.45)],
        "initial": (1.2268, 0.0), "max_points": 2,
    },
    "continue_orbit": lambda: {
        "system": HOT, "drive": DRIVE, "parameter": "omega", "parameter_range": (1.2, 1.3),
        "initial": (1.433, 0.0), "max_points": 2, "state_box": None,
    },
    "crossings": lambda: {
        "system": BODY, "drive": DRIVE, "variable": "stretch", "value": 1.0, "duration": 1.0,
    },
    "cycle_losses": lambda: {"system": DAMPED, "drive": DRIVE, "periods": 2},
    "design": lambda: {"measures": measure(), "targets": 1.1, "parameters": "temperature"},
    "energy_balance": lambda: {"system": DAMPED, "drive": DRIVE, "duration": 1.0},
    "equilibria": lambda: {"actuator": BODY},
    "fit": lambda: {
        "system": DAMPED, "drive": STEP, "data": data(), "parameters": {"dissipation.0.eta": 0.12},
    },
    "frequency_response": lambda: {
        "system": DAMPED, "drive": DRIVE, "omega": [1.0, 1.2], "duration": 5.0,
    },
    "locate_bifurcation": lambda: {
        "system": HOT, "drive": rm.SineSquared(0.4, 1.2668), "kind": "fold",
        "parameter": "omega", "initial": (1.2268, 0.0),
    },
    "logarithmic_decrement": lambda: {"history": decaying()},
    "lyapunov": lambda: {"system": DAMPED, "drive": DRIVE, "periods": 16},
    "manifold_crossing": lambda: {
        "system": HOT, "drive": DRIVE, "parameter": "omega", "parameter_range": (1.25, 1.26),
        "saddle": (1.433, 0.0), "width": 5e-3,
    },
    "periodic_orbits": lambda: {
        "system": DAMPED, "drive": DRIVE, "state_box": {"stretch": (0.9, 1.1)},
    },
    "poincare_section": lambda: {"system": BODY, "drive": DRIVE, "periods": 2},
    "read_measurements": lambda: {"data": {"time": [0.0, 1.0], "thickness_stretch": [1.0, 1.1]}},
    "regime_chart": lambda: {
        "system": DAMPED, "drive": DRIVE, "over": {"b": [0.3], "temperature": [293.0]},
        "periods": 100,
    },
    "read_drive": lambda: {"dataset": decaying()},
    "read_system": lambda: {"dataset": decaying()},
    "rescale": lambda: {"dataset": rm.simulate(BODY, DRIVE, duration=1.0), "temperature": 300.0},
    "resonances": lambda: {
        "system": DAMPED, "drive": DRIVE, "omega_range": (1.2, 1.4), "slices": 1,
        "state_box": {"stretch": (0.9, 1.1)},
    },
    "response_diagram": lambda: {
        "system": DAMPED, "drive": DRIVE, "omega_range": (1.2, 1.4), "slices": 1, "max_points": 2,
        "state_box": {"stretch": (0.9, 1.1)},
    },
    "sensitivity": lambda: {"measure": measure(), "parameters": "temperature"},
    "shape_command": lambda: {"actuator": BODY, "target": 1.1},
    "shape_commands": lambda: {"actuator": BODY, "target": 1.1},
    "simulate": lambda: {"system": BODY, "drive": DRIVE, "duration": 1.0},
    "snap_through": lambda: {
        "actuator": rm.Actuator(prestress=2.2), "parameter": "m", "parameter_range": (1.0, 4.0),
    },
    "step_response": lambda: {"system": DAMPED, "drive": STEP, "duration": 5.0},
    "switch_branch": lambda: {"branch": branch(), "max_points": 2},
    "symmetry_check": lambda: {"system": DAMPED, "drive": DRIVE, "periods": 50},
    "to_si": lambda: {"dataset": rm.simulate(SIZED, DRIVE, duration=1.0)},
    "uncertainty": lambda: {
        "measure": measure(), "parameter_ranges": {"temperature": (290.0, 300.0)}, "samples": 256,
    },
}  # fmt: skip
#: Verbs that only an actuator has a meaning for.
ACTUATOR_ONLY = {
    "rescale", "shape_command", "shape_commands", "step_response", "symmetry_check", "to_si",
}  # fmt: skip
#: Verbs that are given no system.
OF_DATA_ONLY = {"logarithmic_decrement", "read_drive", "read_measurements", "read_system"}


def written(eta: float = 0.0, temperature: float = 293.0, prestress: float = 0.0) -> Any:
    """The block of one coordinate, by its energies."""
    system = rm.LagrangianSystem(
        coordinates="stretch",
        kinetic="stretch_rate**2/3 + 2*c*stretch_rate**2/(3*stretch**6)",
        potential="temperature/293*(2*stretch**2 + stretch**-4 - 3)/2"
        " - load/stretch**2 - 2*prestress*(stretch - 1)",
        dissipation="eta*stretch_rate**2",
        parameters={"c": 1.0, "eta": eta, "temperature": temperature, "prestress": prestress},
        observable="stretch**-2",
        rest={"stretch": 1.0},
    )
    return system if eta else system.without_dissipation()


OWN_SPAN = {"stretch": (0.3, 4.0)}
OWN_BOX = {"stretch": (0.9, 1.1), "stretch_rate": (-0.5, 0.5)}


@cache
def own_branch() -> xr.Dataset:
    box = {"stretch": (0.3, 4.0), "stretch_rate": (-8.0, 8.0)}
    return rm.continue_orbit(written(0.01), FAST, "omega", (2.25, 2.45), state_box=box)


def own_measure() -> rm.Measure:
    return rm.Measure(rm.simulate, written(), DRIVE, times=[2.0], of="stretch")


#: What differs where a system of one's own is meant: see :func:`own_call`.
OWN_CHANGES: Mapping[str, Callable[[], dict[str, Any]]] = {
    "backbone": lambda: {"actuator": written()},
    "basins": lambda: {"system": written(0.1)},
    "bifurcation_diagram": lambda: {"system": written(0.1)},
    "classify": lambda: {"system": written(0.1)},
    "continue_bifurcation": lambda: {
        "system": written(temperature=350.0),
        "state_box": {"stretch": (0.3, 4.0), "stretch_rate": (-8.0, 8.0)},
    },
    "continue_orbit": lambda: {
        "system": written(temperature=350.0),
        "state_box": {"stretch": (0.3, 4.0), "stretch_rate": (-8.0, 8.0)},
    },
    "crossings": lambda: {"system": written()},
    "cycle_losses": lambda: {"system": written(0.1)},
    "design": lambda: {"measures": own_measure(), "targets": 1.05, "parameters": "b"},
    "energy_balance": lambda: {"system": written(0.1)},
    "equilibria": lambda: {"actuator": written(), "state_box": OWN_SPAN},
    "fit": lambda: {
        "system": written(0.1), "parameters": {"eta": 0.12},
        "data": rm.simulate(DAMPED, STEP, times=np.linspace(0.0, 5.0, 21))[["stretch"]],
    },
    "frequency_response": lambda: {"system": written(0.1)},
    "locate_bifurcation": lambda: {"system": written(temperature=350.0)},
    "lyapunov": lambda: {"system": written(0.1)},
    "manifold_crossing": lambda: {"system": written(temperature=350.0)},
    "periodic_orbits": lambda: {"system": written(0.1), "state_box": OWN_BOX},
    "poincare_section": lambda: {"system": written()},
    "regime_chart": lambda: {"system": written(0.1)},
    "resonances": lambda: {
        "system": written(0.1), "state_box": {"stretch": (0.7, 1.5), "stretch_rate": (-1.0, 1.0)},
    },
    "response_diagram": lambda: {"system": written(0.1), "state_box": OWN_BOX},
    "sensitivity": lambda: {"measure": own_measure()},
    "simulate": lambda: {"system": written()},
    "snap_through": lambda: {
        "actuator": written(prestress=2.2), "state_box": OWN_SPAN, "initial": 1.0,
    },
    "switch_branch": lambda: {
        "branch": own_branch(),
        "state_box": {"stretch": (0.3, 4.0), "stretch_rate": (-8.0, 8.0)},
    },
    "uncertainty": lambda: {
        "measure": own_measure(), "parameter_ranges": {"temperature": (290.0, 300.0)},
    },
}  # fmt: skip


def own_call(verb: str) -> dict[str, Any]:
    """A sound call of a verb with a system of one's own."""
    return {**SOUND[verb](), **OWN_CHANGES[verb]()}


#: Functions of the public names that are no verbs: they take other things than numbers.
NOT_VERBS = {"equations", "load", "save", "rates", "period_map", "export", "sweep"}


def verbs() -> dict[str, Callable[..., Any]]:
    functions = {name: getattr(rm, name) for name in rm.__all__}
    return {k: f for k, f in functions.items() if inspect.isfunction(f) and k not in NOT_VERBS}
