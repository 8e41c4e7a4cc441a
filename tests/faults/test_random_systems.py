"""Random formulas and systems: each ends in a result or in a message."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

import remanent as rm

#: Functions of formulas.
FUNCTIONS = ["sqrt", "exp", "log", "sin", "cos", "sin", "cos"]
#: Some that there are not.
UNKNOWN_FUNCTIONS = ["tan", "eval", "abs"]
#: Names that mean something in one place or another, or nowhere.
NAMES = ["x", "y", "x", "y", "x_rate", "y_rate", "load", "k", "pi", "z", "omega", "__class__", "I"]
#: Fragments that no formula may have.
BROKEN = ["(", ")", "**", "x..y", "lambda: 0", "x[0]", "'a'", "1e999", "0x10", "x if x else y",
          "x;y", "x=1", "é", "9**9**9", "x.__class__", "", " ", "1/0", "((((((x))))))"]  # fmt: skip
#: Random systems of the fast test, and of the slow one.
COUNTS = (25, 2000)


@dataclass(frozen=True)
class Grammar:
    """What random formulas are written with.

    Attributes
    ----------
    names, functions
        That are drawn from.
    broken
        Share of parts that no formula may have.
    """

    names: list[str]
    functions: list[str]
    broken: float = 0.0

    def formula(self, rng: np.random.Generator, depth: int) -> str:
        """A formula, nested so deep at most."""
        if rng.random() < self.broken:
            return str(rng.choice(BROKEN))
        kind = rng.choice(["name", "number", "sum", "product", "power", "function"])
        if depth == 0 or kind == "name":
            return str(rng.choice(self.names))
        if kind == "number":
            return f"{float(rng.choice([0.0, 1.0, 0.5, 2.0, 1e-3, 3.7]))!r}"
        a, b = (self.formula(rng, depth - 1) for _ in range(2))
        exponent = rng.choice(["2", "3", "-2", "0.5", "1.5", "(x)", "40", "0"])
        return {
            "sum": f"({a} {rng.choice(['+', '-'])} {b})",
            "product": f"({a}) {rng.choice(['*', '*', '/'])} ({b})",
            "power": f"({a})**{exponent}",
            "function": f"{rng.choice(self.functions)}({a})",
        }[kind]


def random_system(rng: np.random.Generator) -> rm.LagrangianSystem | rm.FirstOrderSystem:
    """A system by random formulas; those with sound ones move."""
    two = bool(rng.random() < 0.4)
    names = ["x", "y"][: 1 + two]
    sound = bool(rng.random() < 0.8)
    grammar = (
        Grammar([*names, *names, "load", "k"], FUNCTIONS)
        if sound
        else Grammar(NAMES, [*FUNCTIONS, *UNKNOWN_FUNCTIONS], broken=0.02)
    )
    inner = replace(grammar, names=[*names, "k"]) if sound else grammar

    def energy(depth: int = 3, of: Grammar = grammar) -> str:
        return of.formula(rng, depth)

    # A parameter is refused unless it is used: here it always is.
    used: dict[str, Any] = {"parameters": {"k": float(rng.uniform(-2.0, 2.0))}}
    rest = {name: float(rng.choice([0.0, 0.7, 1.0])) for name in names}
    if rng.random() < 0.4:
        rates = {name: f"{energy()} + 0*k" for name in names}
        return rm.FirstOrderSystem(rates=rates, rest=rest, **used)
    kinetic = " + ".join(f"{name}_rate**2/2" for name in names)
    if not sound or rng.random() < 0.3:
        kinetic = f"{kinetic} + {energy(2, inner)}"
    return rm.LagrangianSystem(
        coordinates=names,
        kinetic=kinetic,
        potential=f"{energy()} + 0*k",
        dissipation=str(rng.choice(["0", "0.1*x_rate**2", energy(2, inner)])),
        observable=str(rng.choice(["x", "x**2", energy(1, inner)])),
        rest=rest,
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
