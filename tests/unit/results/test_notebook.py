"""What a notebook shows is what is computed, in LaTeX that is understood."""

from __future__ import annotations

import re
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
import sympy as sp
from matplotlib.mathtext import MathTextParser

import remanent as rm
from remanent.derivation.block import build_motion
from remanent.derivation.letters import letter
from remanent.derivation.shown import (
    formulas,
    load_in_time,
    strain_energy_in_invariants,
)
from remanent.models.drives.base import Drive
from remanent.models.materials.base import Material
from remanent.models.parts import Part
from remanent.results.notebook import markdown
from tests.contracts.public import examples

PARTS = examples(Part)
MATERIALS = {name: part for name, part in PARTS.items() if isinstance(part, Material)}
SYSTEMS: dict[str, Any] = {
    "one coordinate": rm.Actuator(),
    "branches": rm.Actuator(
        material=rm.Gent(50),
        dissipation=[rm.Rayleigh(0.1), rm.Zener(0.5, 2.0, shift=rm.WLF(8.0, 200.0))],
    ),
    "two coordinates and heat": rm.Actuator(prestress=(0, 1), heat=rm.Heat()),
    "own field": rm.Actuator(magnet=rm.Magnet(demagnetisation=0.1)),
    "energies": rm.LagrangianSystem.example(),
    "rates": rm.FirstOrderSystem.example(),
}
EVERYTHING = PARTS | SYSTEMS
DRIVES = {
    name: part for name, part in PARTS.items() if isinstance(part, Drive) and name != "Loads"
} | {
    "without a period": rm.Sines([0.1, 0.05], [1, 2**0.5], 2.5, phases=[0.3, 1.0]),
}


def typeset(text: str) -> None:
    """Raise where TeX would: at two superscripts, an open brace, an unknown command."""
    rows = re.sub(r"\\(begin|end)\{aligned\}|&|\{\}", "", text).split(r"\\")
    for row in rows:
        MathTextParser("path").parse(f"${row.strip()}$".replace("\n", " "))


@pytest.mark.parametrize("name", sorted(EVERYTHING))
def test_formulas_are_typeset(name: str) -> None:
    """All between dollar signs is LaTeX that a parser reads, and tables have no stray bars."""
    shown = EVERYTHING[name]._repr_markdown_()
    found = re.findall(r"\$\$(.*?)\$\$|\$(.*?)\$", shown, re.DOTALL)
    assert found
    for one in found:
        typeset("".join(one))
    rows = [line for line in shown.splitlines() if line.startswith("| $")]
    assert {row.count("|") for row in rows} <= {3, 4, 6}


@pytest.mark.parametrize("name", sorted(EVERYTHING))
def test_numbers_have_a_row_each(name: str) -> None:
    """With the value that the equations take."""
    value = EVERYTHING[name]
    shown = dict(re.findall(r"^\| \$.*?\$ \| `(.*?)` \| (\S+) \|", markdown(value), re.MULTILINE))
    assert {k: float(v) for k, v in shown.items()} == pytest.approx(value.parameter_values())


@pytest.mark.parametrize("name", sorted(SYSTEMS))
def test_letters_of_the_equations_are_those_of_the_numbers(name: str) -> None:
    """A reader finds every number of an equation in the table below it."""
    system = SYSTEMS[name]
    table = re.findall(r"^\| \$(.*?)\$ \| `(.*?)`", markdown(system), re.MULTILINE)
    shown = rm.equations(system)
    rows = (*shown.second_order, *shown.first_order, *shown.definitions)
    used = {symbol.name for row in rows for symbol in row.free_symbols}
    numbers = {k: v for v, k in table}
    text = " ".join(formulas(system))
    for one in used & system.parameter_values().keys():
        assert numbers[one] in text or name == "own field"


@pytest.mark.parametrize("name", sorted(DRIVES))
def test_the_load_that_is_shown_is_the_load(name: str) -> None:
    """The formula in tau, with the drive's numbers, at times of its first piece."""
    drive = DRIVES[name]
    tau = np.linspace(0.0, 1.2, 7)
    numbers = {sp.Symbol(k, real=True): v for k, v in drive.parameter_values().items()}
    formula = load_in_time(drive).subs(numbers)
    law = sp.lambdify(sp.Symbol("tau", real=True), formula, "numpy")
    np.testing.assert_allclose(law(tau) + 0.0 * tau, drive(tau), rtol=0.0, atol=2e-6)


@pytest.mark.parametrize("name", sorted(MATERIALS))
def test_the_strain_energy_that_is_shown_is_the_strain_energy(name: str) -> None:
    """In invariants or in stretches, at a stretch that keeps the volume."""
    material = MATERIALS[name]
    motion = build_motion(rm.Actuator(material=material, prestress=(0, 0)), None)
    l1, l2 = 1.3, 0.9
    l3 = 1.0 / (l1 * l2)
    squares = np.square([l1, l2, l3])
    values = {
        **dict(zip(("stretch_1", "stretch_2", "thickness"), (l1, l2, l3), strict=True)),
        **{"I1": squares.sum(), "I2": (1.0 / squares).sum()},
        **{f"material.{k}": v for k, v in material.parameter_values().items()},
    }
    shown = strain_energy_in_invariants(material, motion)
    number = shown.subs({s: values[s.name] for s in shown.free_symbols})
    exact = material.energy(l1, l2, l3, material.parameter_values(), np)
    assert float(number) == pytest.approx(float(exact), rel=1e-12)
    assert name in {"Ogden"} or "I_{1}" in formulas(material)[0]


def test_letters_of_primes_have_one_superscript() -> None:
    """A prime is a superscript in TeX, which a letter has one of."""
    for name in ("dissipation.0.viscous_stretch_1'", "stretch_rate'", "body_temperature'"):
        typeset(f"{letter(name)}^{{2}}")
    assert letter("material.exponents.0") == "a_{0}"


def test_what_is_too_long_is_said() -> None:
    """The magnet's own field makes equations of pages, which are not shown."""
    shown = SYSTEMS["own field"]._repr_markdown_()
    assert "`rm.equations` has it" in shown
    assert len(shown) < 2000


def test_bars_and_tags_of_a_user_stay_in_their_cell() -> None:
    """A symbol may hold what Markdown and HTML take for their own."""
    own = rm.LagrangianSystem.example().replace(symbols={"delta": r"|\delta|<b>$"})
    row = next(line for line in markdown(own).splitlines() if "`delta`" in line)
    assert row.count("|") == 6
    assert "<" not in row


def test_sizes_in_si_are_told() -> None:
    """Of an actuator with physical sizes: one of tau, of S and of m."""
    film = rm.Actuator.from_si(
        shear_modulus="100 kPa", density="2000 kg/m^3", half_length="5 mm",
        half_thickness="0.5 mm", remanence="143 mT",
    )  # fmt: skip
    shown = film._repr_markdown_()
    for unit, size in (("µs", film.in_unit(1.0, "us")), ("mT", film.in_unit(1.0, "mT"))):
        assert f"{size:.4g} {unit}" in shown
    assert "100 kPa" in shown


def test_building_values_needs_no_sympy() -> None:
    """What a notebook shows is made when it is shown."""
    code = "import sys, remanent as rm; rm.Actuator(); rm.Sine(1, 2); print('sympy' in sys.modules)"
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert told.stdout.strip() == "False"
