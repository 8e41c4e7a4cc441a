"""Random formulas and systems: each ends in a result or in a message."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import remanent as rm

#: Functions, and some that there are not.
FUNCTIONS = ["sqrt", "exp", "log", "sin", "cos", "sin", "cos", "tan", "eval", "abs"]
#: Names that mean something in one place or another, or nowhere.
NAMES = ["x", "y", "x", "y", "x_rate", "y_rate", "load", "k", "pi", "z", "omega", "__class__", "I"]
#: Fragments that no formula may have.
BROKEN = ["(", ")", "**", "x..y", "lambda: 0", "x[0]", "'a'", "1e999", "0x10", "x if x else y",
          "x;y", "x=1", "é", "9**9**9", "x.__class__", "", " ", "1/0", "((((((x))))))"]  # fmt: skip
#: Random systems of the fast test, and of the slow one.
COUNTS = (60, 2000)


def random_formula(rng: np.random.Generator, depth: int, names: list[str]) -> str:
    """A formula by a grammar, seldom broken."""
    if rng.random() < 0.006:
        return str(rng.choice(BROKEN))
    kind = rng.choice(["name", "number", "sum", "product", "power", "function"])
    if depth == 0 or kind == "name":
        return str(rng.choice(names))
    if kind == "number":
        return f"{rng.choice([0.0, 1.0, 0.5, 2.0, 1e-3, 3.7])!r}"
    a, b = (random_formula(rng, depth - 1, names) for _ in range(2))
    exponent = rng.choice(["2", "3", "-2", "0.5", "1.5", "(x)", "40", "0"])
    return {
        "sum": f"({a} {rng.choice(['+', '-'])} {b})",
        "product": f"({a}) {rng.choice(['*', '*', '/'])} ({b})",
        "power": f"({a})**{exponent}",
        "function": f"{rng.choice(FUNCTIONS)}({a})",
    }[kind]


def random_system(rng: np.random.Generator) -> rm.LagrangianSystem | rm.FirstOrderSystem:
    """A system by random formulas; those with sound ones move."""
    two = bool(rng.random() < 0.4)
    names = ["x", "y"][: 1 + two]
    sound = bool(rng.random() < 0.8)
    words = [*names, *names, "load", "k"] if sound else NAMES

    def energy(depth: int = 3) -> str:
        return random_formula(rng, depth, words)

    used: dict[str, Any] = (
        {"parameters": {"k": float(rng.uniform(-2.0, 2.0))}} if rng.random() < 0.8 else {}
    )
    if rng.random() < 0.4:
        return rm.FirstOrderSystem(
            rates={name: f"{energy()} + 0*k" if used else energy() for name in names},
            rest={name: float(rng.choice([0.0, 1.0])) for name in names},
            **used,
        )
    kinetic = " + ".join(f"{name}_rate**2/2" for name in names)
    if not sound or rng.random() < 0.3:
        kinetic = f"{kinetic} + {energy(2)}"
    return rm.LagrangianSystem(
        coordinates=names,
        kinetic=kinetic,
        potential=f"{energy()} + 0*k" if used else energy(),
        dissipation=str(rng.choice(["0", "0.1*x_rate**2", energy(2)])),
        observable=str(rng.choice(["x", "x**2", energy(1)])),
        rest={name: float(rng.choice([0.0, 1.0])) for name in names},
        **used,
    )


def outcome(seed: int) -> str:
    """What comes of a random system: ``refused`` or ``moved``."""
    rng = np.random.default_rng(seed)
    drive = [rm.Sine(0.1, 1.0), rm.Constant(0.2), rm.Steps([0.0, 0.2], [0.1, 0.3])][seed % 3]
    try:
        system = random_system(rng)
        result = rm.simulate(system, drive, duration=0.5, tolerance=1e-6)
    except rm.InputError:
        return "refused"
    assert int(result.status) in {*map(int, rm.Status)}
    known = np.isfinite(result[system.state_names[0]].values)
    assert known.any() or int(result.status) != int(rm.Status.OK)
    return "moved"


def run(seeds: range) -> dict[str, int]:
    """How many random systems are refused, and how many move; warnings are errors."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        outcomes = [outcome(seed) for seed in seeds]
    return {name: outcomes.count(name) for name in ("refused", "moved")}


def test_random_systems_end_in_a_result_or_a_message() -> None:
    """Nothing but `InputError` leaves a random system."""
    counts = run(range(COUNTS[0]))
    assert min(counts.values()) > 5


@pytest.mark.slow
def test_many_random_systems_end_in_a_result_or_a_message() -> None:
    """The same of two thousand."""
    counts = run(range(10_000, 10_000 + COUNTS[1]))
    assert min(counts.values()) > 200
