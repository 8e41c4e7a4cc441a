"""Everything public that is called, each with sound arguments to spoil."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import cache, partial
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np
import xarray as xr

import remanent as rm
from remanent.models.drives.base import Drive
from tests.contracts.public import examples
from tests.contracts.sound_calls import SOUND, measure
from tests.faults.own_systems import BOTH, DUFFING, FORCE, PAIR, TWO_LOADS, own_sound_calls
from tests.faults.result_pool import result_of
from tests.faults.value_pool import film
from tests.unit.plots import synthetic

#: Further words that pictures hand to Matplotlib, one of which a call may get.
MATPLOTLIB_WORDS = ("color", "linewidth", "label", "alpha")
#: Options of a verb that a measure hands on.
OPTION_WORDS = ("m", "over", "tolerance")
#: What follows the name of a verb that is called with a system of one's own.
OF_AN_OWN_SYSTEM = " of an own system"


@dataclass(frozen=True)
class Subject:
    """Something public that is called.

    Attributes
    ----------
    name
        What to call it.
    call
        It takes arguments by name.
    sound
        A maker of sound arguments.
    further
        Names that it takes beside those of its signature.
    is_of_own_system
        Whether the sound arguments have a system that a user wrote.
    """

    name: str
    call: Callable[..., Any]
    sound: Callable[[], Mapping[str, Any]]
    further: tuple[str, ...] = ()
    is_of_own_system: bool = False

    def argument_names(self) -> list[str]:
        """Names of the arguments that may be passed by name."""
        kinds = inspect.Parameter
        unnamed = {kinds.VAR_POSITIONAL, kinds.VAR_KEYWORD, kinds.POSITIONAL_ONLY}
        parameters = inspect.signature(self.call).parameters.values()
        return [*(p.name for p in parameters if p.kind not in unnamed), *self.further]


def subjects() -> list[Subject]:
    """Verbs, classes, methods of values, pictures, files."""
    values_and_names = {name: getattr(rm, name) for name in rm.__all__}
    measuring = {"sensitivity", "uncertainty"}
    verbs = [
        Subject(f"rm.{name}", getattr(rm, name), sound, OPTION_WORDS if name in measuring else ())
        for name, sound in SOUND.items()
    ]
    of_own = [
        Subject(f"rm.{name}{OF_AN_OWN_SYSTEM}", getattr(rm, name), sound, is_of_own_system=True)
        for name, sound in own_sound_calls().items()
    ]
    classes = [
        Subject(f"rm.{name}", cls, partial(fields_of, cls.example()))
        for name, cls in values_and_names.items()
        if isinstance(cls, type) and hasattr(cls, "example")
    ]
    plots = [
        Subject(f"rm.plot.{name}", getattr(rm.plot, name), DRAWN[name], MATPLOTLIB_WORDS)
        for name in rm.plot.__all__
    ]
    return [*verbs, *of_own, *classes, *others(), *methods(), *plots]


def fields_of(value: Any) -> dict[str, Any]:
    """The arguments that make a value."""
    return {field.name: getattr(value, field.name) for field in fields(value) if field.init}


#: Methods of an actuator that take a quantity: name, argument, a sound one.
SI_METHODS = (
    ("stress", "stress", "50 kPa"), ("viscosity", "viscosity", "20 Pa s"),
    ("load", "flux_density", "140 mT"), ("coupling", "heat_capacity", "1.9 kJ/(kg K)"),
    ("frequency", "frequency", "50 Hz"), ("time", "time", "1 s"),
)  # fmt: skip


def sound_sweep() -> dict[str, Any]:
    """A study that is cheap; a store is made in the folder of the call."""
    system, drive = rm.Actuator(dissipation=rm.Rayleigh(0.1)), rm.SineSquared(0.4, 1.25)
    return {"system": system, "drive": drive, "over": {"b": [0.3, 0.4]}, "verb": "cycle_losses",
            "periods": 2, "store": f"{mkdtemp()}/study.zarr"}  # fmt: skip


def others() -> list[Subject]:
    """Functions and classes that are neither a verb nor made by an example."""
    folder = Path(mkdtemp())
    sizes = {"shear_modulus": "100 kPa", "density": "2000 kg/m^3", "half_length": "5 mm",
             "half_thickness": "0.5 mm"}  # fmt: skip
    moved = {"system": rm.Actuator(), "drive": rm.SineSquared(0.4, 1.25)}
    parts = ("material", "dissipation", "heat", "magnet")
    return [
        Subject("rm.Actuator", rm.Actuator, dict),
        Subject("rm.sweep", rm.sweep, sound_sweep, ("periods", "tolerance")),
        Subject("rm.Actuator.from_si", rm.Actuator.from_si, lambda: dict(sizes), parts),
        Subject("rm.Measure", measured, lambda: {"verb": rm.equilibria, "of": "natural_frequency",
                                                 "system": rm.Actuator()}, OPTION_WORDS),
        Subject("rm.equations", rm.equations, lambda: {"system": rm.Actuator()}),
        Subject("rm.rates", rm.rates, lambda: moved),
        Subject("rm.period_map", rm.period_map, lambda: moved),
        Subject("rm.export", rm.export, lambda: {**moved, "language": "python"}),
        Subject("rm.equations of an own system", rm.equations, lambda: {"system": DUFFING}),
        Subject("rm.save", rm.save, lambda: {"dataset": motion(), "path": folder / "it.nc"}),
        Subject("rm.load", rm.load, lambda: {"path": saved(folder)}),
    ]  # fmt: skip


def measured(verb: Any, system: Any, of: Any = None, **options: Any) -> Any:
    """A measure, and its value at 300 K."""
    made = rm.Measure(verb, system, of=of, **options)
    repr(made)
    return made.at({"temperature": [300.0]})


def methods() -> list[Subject]:
    """Methods of values, and functions that verbs return."""
    moved = (rm.Actuator(), rm.SineSquared(0.4, 1.25))
    held = (rm.Actuator(), rm.Steps([0.0, 1.0], [0.1, 0.2]))
    converted = [
        Subject(f"actuator.{name}", getattr(film(), name), partial(dict, {argument: text}))
        for name, argument, text in SI_METHODS
    ]
    replaced = [
        Subject(f"{type(value).__name__}.replace", value.replace, dict, tuple(fields_of(value)))
        for value in (
            film(),
            rm.SineSquared(0.4, 1.25),
            rm.Ogden.example(),
            rm.WLF(8.0, 200.0),
            DUFFING,
            BOTH,
            rm.FirstOrderSystem.example(),
        )
    ]
    loads = [
        Subject(f"{name}.__call__", drive.__call__, lambda: {"tau": 0.5})
        for name, drive in examples(Drive).items()  # type: ignore[type-abstract]
    ]
    return [
        *converted, *replaced, *loads,
        Subject("actuator.in_unit", film().in_unit, lambda: {"values": 1.0, "unit": "ms"}),
        Subject("actuator.with_parameter", film().with_parameter,
                lambda: {"name": "c", "value": 1}),
        Subject("Measure.at", measure().at, lambda: {"values": {"temperature": [300.0]}}),
        Subject("Measure.values_at", measure().values_at, lambda: {"values": {"c": [0.5]}}),
        Subject("Rates.__call__", rm.rates(*moved).__call__, lambda: {"t": 0.5, "y": [1.0, 0.0]}),
        Subject("Rates of steps", rm.rates(*held).__call__, lambda: {"t": 0.5, "y": [1.0, 0.0]}),
        Subject("PeriodMap.__call__", rm.period_map(*moved).__call__,
                lambda: {"states": [1.0, 0.0]}),
        Subject("system.with_parameter", DUFFING.with_parameter,
                lambda: {"name": "delta", "value": 1}),
        Subject("Rates of an own system", rm.rates(TWO_LOADS, BOTH).__call__,
                lambda: {"t": 0.5, "y": [1.0, 0.0]}),
        Subject("PeriodMap of an own system", rm.period_map(PAIR, FORCE).__call__,
                lambda: {"states": [1.0, 0.0, 0.0, 0.0]}),
    ]  # fmt: skip


@cache
def saved(folder: Path) -> Path:
    """A file with a motion."""
    return rm.save(motion(), folder / "motion.nc")


@cache
def motion() -> xr.Dataset:
    """A short motion of two actuators."""
    over = {"temperature": [290.0, 300.0]}
    return rm.simulate(rm.Actuator(), rm.SineSquared(0.4, 1.25), duration=1.0, over=over)


@cache
def equilibria_over_loads() -> xr.Dataset:
    """Equilibria against the load, with the two folds of a bistable block."""
    return rm.equilibria(rm.Actuator(prestress=2.2), over={"m": np.linspace(1.0, 4.0, 13)})


#: Arguments of a sound picture of each kind.
DRAWN: Mapping[str, Callable[[], dict[str, Any]]] = {
    "bars": lambda: {"dataset": result_of("sensitivity")},
    "basins": lambda: {"dataset": synthetic.basins_of_two()},
    "branch": lambda: {"dataset": result_of("continue_orbit")},
    "curve": lambda: {"dataset": motion(), "variable": "stretch", "x": "time"},
    "energy_balance": lambda: {"dataset": result_of("energy_balance")},
    "equilibria": lambda: {"dataset": equilibria_over_loads()},
    "fit": lambda: {"dataset": result_of("fit")},
    "history": lambda: {"dataset": motion()},
    "landscape": lambda: {"dataset": synthetic.potential()},
    "map": lambda: {"dataset": result_of("regime_chart")},
    "overview": lambda: {"dataset": result_of("regime_chart")},
    "multipliers": lambda: {"dataset": result_of("continue_orbit")},
    "phase": lambda: {"dataset": motion()},
    "resonances": lambda: {"dataset": result_of("resonances")},
    "response": lambda: {"dataset": result_of("frequency_response")},
    "section": lambda: {"dataset": result_of("poincare_section")},
    "step_response": lambda: {
        "dataset": motion().isel(temperature=0),
        "measures": result_of("step_response"),
    },
}
