"""What is exported in tests: systems under drives of every kind, and the law that all obey."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import remanent as rm
from remanent._typing import FloatArray
from remanent.models.drives.base import Drive
from remanent.models.materials.base import Material
from remanent.studies.ensemble.layout import lay_out_ensemble
from tests.contracts.public import examples
from tests.faults.own_systems import BOTH, DUFFING, FREE, PAIR, TWO_LOADS
from tests.faults.test_random_systems import random_system

#: Systems under drives, by what they are called.
Cases = Mapping[str, tuple[Any, Drive]]
#: Rates and loads at a time, as a tool gives them.
Answer = tuple[Sequence[float], Sequence[float]]

SINE = rm.Sine(0.2, 1.3, mean=0.05, phase=0.4)
#: Names that mean something in one language or another.
RESERVED = rm.LagrangianSystem(
    coordinates=("new", "y"),
    kinetic="new_rate**2/2 + y_rate**2/2",
    potential="function*new**2/2 + elseif*y**4/4 + double*new*y + t*y**2 - load*y + beta*E",
    dissipation="NaN*new_rate**2/2 + v_1*np*y_rate**2/2",
    parameters={"function": 1.0, "elseif": 0.5, "double": 0.25, "t": 0.125, "NaN": 0.2, "v_1": 0.3,
                "np": 1.5, "beta": 2.0, "E": 3.0},
    units={"y": "mm", "new": "\\*/ µ"},
)  # fmt: skip


def systems() -> dict[str, Any]:
    """Systems of every kind."""
    rates = rm.FirstOrderSystem
    pressed = rm.Actuator(prestress=(0.4, 0.1), dissipation=rm.KelvinVoigt(0.1))
    prony = (rm.Zener(0.4, 1.0), rm.Zener(0.2, 5.0, shift=rm.WLF(8.0, 200.0)))
    strain = rm.StrainEnergy("a*(I1 - 3)/2 + b*(I1 - 3)**2", {"a": 1.0, "b": 0.05})
    return {
        "actuator": rm.Actuator(c=0.7, temperature=330.0, dissipation=rm.Rayleigh(0.1)),
        "two stretches": pressed,
        "Prony series": rm.Actuator(dissipation=prony),
        "heat": rm.Actuator(dissipation=rm.Zener(0.4, 1.0), heat=rm.Heat.example()),
        "strain energy": rm.Actuator(material=strain),
        "magnet": rm.Actuator(magnet=rm.Magnet(temperature_coefficient=-1e-3, demagnetisation=0.2)),
        "warm magnet": rm.Actuator(magnet=rm.Magnet(temperature_coefficient=-1e-3),
                                   dissipation=rm.Rayleigh(0.1), heat=rm.Heat.example()),
        **{f"of {name}": rm.Actuator(material=one)
           for name, one in examples(Material).items()},  # type: ignore[type-abstract]
        "Duffing": DUFFING, "free": FREE, "pair": PAIR, "reserved names": RESERVED,
        "van der Pol": rm.FirstOrderSystem.example(),
        "Lorenz": rates(rates={"x": "sigma*(y - x)", "y": "x*(rho - z) - y", "z": "x*y - beta*z"},
                        parameters={"sigma": 10.0, "rho": 28.0, "beta": 8 / 3}),
        "functions": rates(rates={"x": "sqrt(x)*log(x)*exp(-x) + cos(x)", "y": "sin(load)/x"},
                           rest={"x": 1.0}),
        "constant rates": rates(rates={"x": "0", "y": "2"}),
    }  # fmt: skip


def drives() -> dict[str, Drive]:
    """Drives of every kind."""
    return {
        **{name: one for name, one in examples(Drive).items() if name != "Loads"},  # type: ignore[type-abstract]
        "subharmonics": rm.Sines([0.2, -0.1], [0.5, 1.5], 0.7, phases=[0.3, 1.0]),
        "no period": rm.Sines([0.2, 0.1], [1.0, 2.0**0.5], 0.9, phases=[0.0, 0.4], mean=-0.1),
        "one step": rm.Steps((0.0,), (0.1,)),
        "falling chirp": rm.Chirp(0.2, 3.0, 0.0, 3.0),
        "two samples": rm.Sampled([0.0, 10.0], [1.0, 2.0]),
    }


def two_loads() -> dict[str, Drive]:
    """Drives of two loads, of every kind."""
    squared = rm.SineSquared(0.3, 2.6, phase=0.1)
    both: dict[str, dict[str, Drive]] = {
        "two periods": {"pressure": rm.Sine(0.1, 1.3), "voltage": squared},
        "sines": {"pressure": rm.Sines([0.1, 0.2], [1, 3], 1.3), "voltage": squared},
        "steps and a constant": {"pressure": rm.Constant(0.1),
                                 "voltage": rm.Steps([0.0, 2.0], [0.1, 0.3])},
        "constants": {"pressure": rm.Constant(0.1), "voltage": rm.Constant(0.2)},
        "samples": {"pressure": rm.Sampled([0.0, 5.0, 12.0], [0.0, 0.3, 0.1]),
                    "voltage": rm.Constant(0.3)},
    }  # fmt: skip
    return {"a sine": BOTH, **{name: rm.Loads(one) for name, one in both.items()}}


#: Each system under a sine, each drive on an oscillator, and several loads.
CASES: Cases = {
    **{name: (system, SINE) for name, system in systems().items()},
    **{f"{name} on Duffing": (DUFFING, drive) for name, drive in drives().items()},
    "steps on an actuator": (rm.Actuator(), rm.Steps.example()),
    **{f"two loads, {name}": (TWO_LOADS, drive) for name, drive in two_loads().items()},
}


def random_cases(count: int) -> Cases:
    """Random systems, each under one of the drives: actuators, one's own, and of two loads."""
    single, double = [*drives().values()], [*two_loads().values()]
    chosen: dict[str, tuple[Any, Drive]] = {}
    seed = 0
    while len(chosen) < count:
        seed += 1
        drive = double[seed // 10 % len(double)] if seed % 10 == 0 else single[seed % len(single)]
        try:
            system = random_system_of_any_kind(seed)
            rm.rates(system, drive)
        except rm.InputError:
            continue
        chosen[str(seed)] = (system, drive)
    return chosen


def random_system_of_any_kind(seed: int) -> Any:
    """A system of two loads for each tenth seed, an actuator for each third, or one's own."""
    rng = np.random.default_rng(seed)
    if seed % 10 == 0:
        return random_pair_of_loads(rng)
    return random_actuator(rng) if seed % 3 == 0 else random_system(rng)


def random_actuator(rng: np.random.Generator) -> rm.Actuator:
    """An actuator of random numbers, of any material, with any losses."""
    materials = [*examples(Material).values()]  # type: ignore[type-abstract]
    losses: list[Any] = [
        (),
        rm.Rayleigh(rng.uniform(0.01, 0.3)),
        rm.KelvinVoigt(rng.uniform(0.01, 0.3)),
        rm.Zener(rng.uniform(0.1, 0.5), rng.uniform(0.5, 4.0)),
    ]
    return rm.Actuator(
        c=rng.uniform(0.3, 2.0),
        temperature=rng.uniform(280.0, 350.0),
        prestress=rng.uniform(0.0, 0.2),
        material=materials[rng.integers(len(materials))],
        dissipation=losses[rng.integers(len(losses))],
        magnet=rm.Magnet(temperature_coefficient=rng.uniform(-1e-3, 0.0)),
    )


def random_pair_of_loads(rng: np.random.Generator) -> rm.LagrangianSystem:
    """The oscillator of two loads, with random numbers."""
    return TWO_LOADS.replace(
        parameters={"k": rng.uniform(0.5, 2.0), "delta": rng.uniform(0.0, 0.5)}
    )


def times_of(drive: Drive, rng: np.random.Generator) -> list[float]:
    """Times at which a load is known: random ones, and those of its jumps."""
    end = min(drive.known_until, 20.0)
    breaks = [one for one in getattr(drive, "times", ()) if one <= end]
    return [0.0, *breaks, *rng.uniform(0.0, end, 3)]


def random_state(system: Any, drive: Drive, rng: np.random.Generator) -> FloatArray:
    """A neighbour of the state of rest."""
    rest = lay_out_ensemble(system, drive).initial_states[0]
    near = rest * rng.uniform(0.98, 1.05, rest.size) + rng.uniform(-0.03, 0.05, rest.size)
    return np.asarray(near)


@cache
def points(system: Any, drive: Drive) -> list[tuple[float, FloatArray, FloatArray]]:
    """Times, states, and the rates that are integrated."""
    rng = np.random.default_rng(1)
    rates = rm.rates(system, drive)
    found = []
    for t in times_of(drive, rng):
        y = random_state(system, drive, rng)
        found.append((float(t), y, rates(t, y)))
    return found


def require_equal(seen: Any, expected: FloatArray, case: str = "") -> None:
    """Equal to 1e-12 of the largest rate, and infinite or NaN where the other is."""
    finite = expected[np.isfinite(expected)]
    scale = float(np.abs(finite).max(initial=1e-300))
    np.testing.assert_allclose(seen, expected, rtol=1e-12, atol=1e-12 * scale, err_msg=case)


def require_engine(chosen: Cases, answers: Sequence[Sequence[Answer]]) -> None:
    """Law: a tool gives rates to 1e-12 and loads to 1e-13, at each of the points."""
    assert len(answers) == len(chosen) > 0
    for (case, (system, drive)), answered in zip(chosen.items(), answers, strict=True):
        for (t, _, expected), (rates, loads) in zip(points(system, drive), answered, strict=True):
            require_equal(rates, expected, case=case)
            np.testing.assert_allclose(loads, np.ravel(drive(t)), rtol=0.0, atol=1e-13)


def write(files: Mapping[str, str], folder: Path) -> None:
    """Write texts, which are ASCII, as files."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text, encoding="ascii")


def load_names(drive: Drive) -> dict[str, str]:
    """The function of each load."""
    return {name: "load" if name == "load" else f"load_{name}" for name in drive.load_names}
