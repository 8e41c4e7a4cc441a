"""Random motions of every kind, on which the engine of the page is compared with the package."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

import remanent as rm
from remanent.models.drives.base import Drive

#: What makes a system or a drive with random numbers.
Maker: TypeAlias = Callable[[np.random.Generator], Any]


#: Share of motions that are likely to be chaotic.
CHAOTIC_SHARE = 0.15


@dataclass(frozen=True)
class Case:
    """A motion: what moves under what, from where, and how long."""

    kind: str
    system: Any
    drive: Drive
    initial: dict[str, float]
    duration: float

    @property
    def periods(self) -> float | None:
        """Its length in periods of the load, where it has some."""
        return None if self.drive.period is None else self.duration / self.drive.period


def random_case(rng: np.random.Generator) -> Case:
    """One motion; equations recur, so that few have to be derived and compiled."""
    with warnings.catch_warnings():
        # A spline through random samples may go far beyond them.
        warnings.simplefilter("ignore", rm.InputWarning)
        return _random_case(rng)


def _random_case(rng: np.random.Generator) -> Case:
    if rng.uniform() < CHAOTIC_SHARE:
        system_kind, drive_kind = "Duffing", "chaos"
        drive: Drive = rm.Sine(float(rng.uniform(0.25, 0.5)), 1.0)
    else:
        system_kind, drive_kind = (str(rng.choice([*one])) for one in (SYSTEMS, DRIVES))
        drive = DRIVES[drive_kind](rng)
    system = SYSTEMS[system_kind](rng)
    duration = float(rng.uniform(20.0, 200.0))
    if drive.period is not None:
        duration = drive.period * int(np.exp(rng.uniform(np.log(5.0), np.log(500.0))))
    elif np.isfinite(drive.known_until):
        duration = min(duration, drive.known_until)
    initial = {}
    if isinstance(system, rm.Actuator) and system.coordinate_count == 1:
        initial = {"stretch": float(rng.uniform(0.95, 1.15))}
    return Case(f"{system_kind}, {drive_kind}", system, drive, initial, duration)


def _numbers(rng: np.random.Generator) -> dict[str, Any]:
    """Usual numbers of an actuator."""
    return {
        "c": float(np.exp(rng.uniform(np.log(0.01), np.log(3.0)))),
        "temperature": float(rng.uniform(230.0, 420.0)),
        "prestress": float(rng.uniform(-0.2, 1.2)),
    }


def _actuator(rng: np.random.Generator, **parts: Any) -> rm.Actuator:
    return rm.Actuator(**_numbers(rng), **parts)


def _biaxial(rng: np.random.Generator, **parts: Any) -> rm.Actuator:
    numbers = _numbers(rng)
    numbers["prestress"] = tuple(float(x) for x in rng.uniform(-0.1, 0.8, 2))
    return rm.Actuator(**numbers, **parts)


def _zener(rng: np.random.Generator) -> rm.Zener:
    return rm.Zener(float(rng.uniform(0.1, 1.0)), float(np.exp(rng.uniform(-2.0, 2.0))))


def _duffing(rng: np.random.Generator) -> rm.LagrangianSystem:
    return rm.LagrangianSystem.example().replace(
        parameters={"delta": float(rng.uniform(0.02, 0.4))}
    )


def _van_der_pol(rng: np.random.Generator) -> rm.FirstOrderSystem:
    return rm.FirstOrderSystem.example().replace(parameters={"mu": float(rng.uniform(0.1, 3.0))})


def _pendulum(rng: np.random.Generator) -> rm.LagrangianSystem:
    return rm.LagrangianSystem(
        coordinates="theta",
        kinetic="theta_rate**2/2",
        potential="-cos(theta) - load*sin(theta)",
        dissipation="delta*theta_rate**2/2",
        parameters={"delta": float(rng.uniform(0.0, 0.3))},
    )


#: Systems of every kind, with random numbers.
SYSTEMS: Mapping[str, Maker] = {
    "neo-Hookean": _actuator,
    "conservative Gent": lambda rng: _actuator(
        rng, material=rm.Gent(float(rng.uniform(8.0, 80.0)))
    ),
    "damped": lambda rng: _actuator(rng, dissipation=rm.Rayleigh(float(rng.uniform(0.0, 0.5)))),
    "Mooney and Kelvin": lambda rng: _actuator(
        rng,
        material=rm.MooneyRivlin(0.4, float(rng.uniform(0.0, 0.2))),
        dissipation=rm.KelvinVoigt(float(rng.uniform(0.0, 0.1))),
    ),
    "Zener": lambda rng: _actuator(rng, dissipation=_zener(rng)),
    "heat": lambda rng: _actuator(
        rng,
        dissipation=_zener(rng),
        heat=rm.Heat(float(rng.uniform(1e-4, 1e-2)), float(rng.uniform(0.0, 0.2))),
    ),
    "biaxial": _biaxial,
    "biaxial damped": lambda rng: _biaxial(rng, dissipation=rm.Rayleigh(0.1)),
    "Duffing": _duffing,
    "pendulum": _pendulum,
    "van der Pol": _van_der_pol,
}


def _frequency(rng: np.random.Generator) -> float:
    return float(np.exp(rng.uniform(np.log(0.3), np.log(4.0))))


def _tables(rng: np.random.Generator) -> tuple[list[float], list[float]]:
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(2.0, 15.0, 12))])
    return times.tolist(), rng.uniform(0.0, 0.5, times.size).tolist()


#: Drives of every kind, with random numbers.
DRIVES: Mapping[str, Maker] = {
    "SineSquared": lambda rng: rm.SineSquared(
        float(rng.uniform(0.1, 1.0)), _frequency(rng), float(rng.uniform(0.0, 6.0))
    ),
    "stronger SineSquared": lambda rng: rm.SineSquared(
        float(rng.uniform(0.5, 1.8)), _frequency(rng)
    ),
    "Sine": lambda rng: rm.Sine(float(rng.uniform(0.0, 0.6)), _frequency(rng), mean=0.1),
    "Sines": lambda rng: rm.Sines(
        [float(rng.uniform(0.05, 0.3)), float(rng.uniform(0.05, 0.3))], [1.0, 1.5], _frequency(rng)
    ),
    "no period": lambda rng: rm.Sines([0.2, 0.1], [1.0, 2.0**0.5], _frequency(rng)),
    "Constant": lambda rng: rm.Constant(float(rng.uniform(0.0, 0.6))),
    "Steps": lambda rng: rm.Steps(*_tables(rng)),
    "Ramp": lambda rng: rm.Ramp(*_tables(rng)),
    "Chirp": lambda rng: rm.Chirp(
        float(rng.uniform(0.05, 0.3)), 0.5, float(rng.uniform(1.0, 4.0)), 100.0
    ),
    "Sampled": lambda rng: rm.Sampled(np.linspace(0.0, 120.0, 25), rng.uniform(0.0, 0.4, 25)),
}
