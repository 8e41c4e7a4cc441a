"""Systems that users write, sound and extreme, and sound calls of the verbs with them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial
from itertools import product
from typing import Any, Final

import numpy as np
import xarray as xr

import remanent as rm
from tests.contracts.sound_calls import SOUND

#: Duffing's oscillator with two wells.
DUFFING: Final = rm.LagrangianSystem.example()
#: A conservative oscillator.
FREE: Final = rm.LagrangianSystem(
    coordinates="x", kinetic="x_rate**2/2", potential="k*x**4/4 - load*x", parameters={"k": 1.0}
)
#: Two coupled masses, one load.
PAIR: Final = rm.LagrangianSystem(
    coordinates=("x", "y"),
    kinetic="(x_rate**2 + y_rate**2)/2 + 0.3*x_rate*y_rate*cos(x)",
    potential="x**2/2 + y**2 + x*y/4 - load*sin(x + y)",
    dissipation="delta*(x_rate - y_rate)**2/2",
    parameters={"delta": 0.15},
)
#: A mass with two loads.
TWO_LOADS: Final = rm.LagrangianSystem(
    coordinates="x",
    kinetic="x_rate**2/2",
    potential="k*x**2/2 + pressure*x**3/3 - voltage*x",
    dissipation="delta*x_rate**2/2",
    parameters={"k": 1.0, "delta": 0.15},
    loads=("pressure", "voltage"),
)
#: Its drive, which is a mapping too.
BOTH: Final = rm.Loads({"pressure": rm.Constant(0.1), "voltage": rm.Sine(0.2, 1.2)})
#: A force.
FORCE: Final = rm.Sine(0.1, 1.2)
#: Fields of all of these that may be varied.
OWN_FIELDS: Final = ("delta", "k", "mu", "m", "omega", "initial.x", "pressure.m", "voltage.omega")

#: What their results are made of.
OWN_NAMES: Final = ("x", "x_rate", "observable", "energy", "load", "amplitude", "maximum", "error")


def own_systems() -> list[Any]:
    """Systems of every kind, with usual numbers and extreme ones."""
    rates = rm.FirstOrderSystem
    lorenz = {"x": "sigma*(y - x)", "y": "x*(rho - z) - y", "z": "x*y - beta*z"}
    return [
        DUFFING, FREE, PAIR, TWO_LOADS, rm.FirstOrderSystem.example(),
        rates(rates=lorenz, parameters={"sigma": 10.0, "rho": 28.0, "beta": 8 / 3}),
        *(DUFFING.replace(parameters={"delta": x}) for x in (0.0, -0.1, 1e-300, 1e300, -1e300)),
        *(FREE.replace(parameters={"k": x}) for x in (0.0, 1e-300, 1e300, -1.0, 1e16)),
        rm.FirstOrderSystem.example().with_parameter("mu", 1e4),
        DUFFING.replace(rest={"x": 1e70}), DUFFING.replace(observable="exp(x)"),
        DUFFING.replace(units={"x": "mm", "time": "s"}, symbols={"x": "u"}),
        rates(rates={"x": "-x + load"}), rates(rates={"x": "0"}), rates(rates={"x": "exp(x)"}),
        rates(rates={"x": "x**2 + load"}), rates(rates={"x": "1e200*x", "y": "load/1e200"}),
        rates(rates={"x": "1/x + log(x) - load"}, rest={"x": 1.0}),
        rates(rates={"x": "sin(1e8*x) + load"}), rates(rates={"x": "1e300 + load"}),
        rm.LagrangianSystem(coordinates="x", kinetic="x_rate**2/x**2", potential="exp(700*x)",
                            rest={"x": 1.0}),
        rm.LagrangianSystem(coordinates=("x", "y"), kinetic="1e-5*x_rate**2 + 1e5*y_rate**2",
                            potential="load*x*y"),
        rm.LagrangianSystem(coordinates=("x", "q"), kinetic="x_rate**2/2",
                            potential="(x - q)**2/2 - load*x", dissipation="q_rate**2/2"),
        rm.LagrangianSystem(coordinates=tuple("xyzuvwpq"), potential="load*x",
                            kinetic="+".join(f"{c}_rate**2" for c in "xyzuvwpq")),
    ]  # fmt: skip


def loads() -> list[Any]:
    """Drives of several loads."""
    return [
        BOTH, rm.Loads({"load": FORCE}), rm.Loads({"voltage": FORCE, "pressure": rm.Constant(0.0)}),
        rm.Loads({"pressure": rm.Constant(1e300), "voltage": rm.Ramp([0.0, 1.0], [0.0, 1e300])}),
        rm.Loads({"pressure": rm.Sine(0.1, 1.2), "voltage": rm.Sine(0.2, 1.2 * 7.0 / 64.0)}),
        rm.Loads({"pressure": rm.Constant(0.0), "voltage": rm.Sines([0.1, 0.1], [1, 2**0.5], 1.0)}),
    ]  # fmt: skip


def own_states() -> list[Any]:
    """States of them."""
    return [[0.0, 0.0], [1.0, 0.1], [-1.0, 0.0], [1.0], [0.1, 0.0, 0.0, 0.1], [1.0, 1.0, 20.0],
            [1e300, 0.0], [1e8, -1e8], [5e-324, 0.0], [0.0, 0.0, 0.0], [np.nan, 0.0]]  # fmt: skip


def own_boxes(rows: tuple[Any, ...]) -> list[Any]:
    """Boxes of states of them."""
    square = [{"x": (-r, r), name: (-r, r)} for r in (0.5, 2.0, 20.0, 1e8, 1e300)
              for name in ("x_rate", "v", "y")]  # fmt: skip
    return [*square, {"x": (-2.0, 2.0)}, {"x": (0.0, 1.0)}, *({"x": row} for row in rows)]


def own_overs(rows: tuple[Any, ...]) -> list[Any]:
    """Values of their fields."""
    together = {name: xr.DataArray([0.1, 0.2], dims="case") for name in ("delta", "m")}
    return [*({name: row} for name, row in product(OWN_FIELDS, rows)), together]


#: Part of the states around one of its wells.
_WELL: Final = {"x": (0.8, 1.2), "x_rate": (-0.3, 0.3)}
#: All that motions near them reach.
_WELLS: Final = {"x": (-2.0, 2.0), "x_rate": (-2.0, 2.0)}
#: What sound calls with Duffing's oscillator have in place of what those with an actuator have.
_CHANGES: Final[Mapping[str, Mapping[str, Any]]] = {
    "backbone": {"actuator": FREE, "stretch": [1.2]},
    "basins": {"grid": {"x": [0.9, 1.1], "x_rate": [0.0]}},
    "bifurcation_diagram": {"parameter": "delta", "values": [0.2, 0.3]},
    "classify": {},
    "continue_bifurcation": {
        "drive": FORCE.replace(omega=1.21401352), "parameters": ("omega", "m"),
        "parameter_ranges": [(1.2, 1.23), (0.09, 0.11)], "initial": (-1.062, 0.3283),
        "state_box": _WELLS,
    },
    "continue_orbit": {
        "initial": (-1.254611, -0.410942), "parameter_range": (1.19, 1.21), "state_box": _WELLS,
    },
    "crossings": {"variable": "x", "value": 0.0},
    "cycle_losses": {},
    "energy_balance": {},
    "equilibria": {"state_box": {"x": (-2.0, 2.0)}},
    "fit": {"drive": rm.Constant(0.1), "parameters": {"delta": 0.12}},
    "frequency_response": {},
    "locate_bifurcation": {
        "drive": FORCE.replace(omega=1.21401352), "initial": (-1.062, 0.3283)
    },
    "lyapunov": {},
    "manifold_crossing": {
        "saddle": (-1.105627, 0.400667), "initial": (-1.1318, -0.0416),
        "parameter_range": (1.19, 1.21), "width": 1e-2, "periods": 50,
    },
    "periodic_orbits": {"state_box": _WELL},
    "poincare_section": {},
    "regime_chart": {"over": {"delta": [0.3], "m": [0.1]}},
    "resonances": {"omega_range": (1.2, 1.6), "state_box": _WELL},
    "response_diagram": {"state_box": _WELL},
    "simulate": {},
    "snap_through": {"parameter_range": (-1.0, 1.0), "state_box": {"x": (-2.0, 2.0)}},
}  # fmt: skip


def own_sound_calls() -> dict[str, Callable[[], dict[str, Any]]]:
    """A sound call of every verb that takes a system, with Duffing's oscillator."""
    return {verb: partial(_own_arguments, verb) for verb in _CHANGES}


def _own_arguments(verb: str) -> dict[str, Any]:
    sound = SOUND[verb]()
    force = {"drive": FORCE} if "drive" in sound else {}
    given = {"actuator" if "actuator" in sound else "system": DUFFING}
    measured = {"data": _measured()} if "data" in sound else {}
    return {**sound, **force, **given, **measured, **_CHANGES[verb]}


@cache
def _measured() -> xr.Dataset:
    """A motion of Duffing's oscillator, as measured."""
    return rm.simulate(DUFFING, rm.Constant(0.1), times=np.linspace(0.0, 5.0, 21))[["x"]]
