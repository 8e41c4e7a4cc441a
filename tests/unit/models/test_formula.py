"""Formulas are read, never run: what is understood, and what is refused."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from hypothesis import example, given
from hypothesis import strategies as st

import remanent as rm
from remanent._errors import InputError
from remanent.models.formula import MAX_CHARACTERS, parse_formula, sympy_as_formula_text
from tests.unit.models.attacks import ATTACKS


@pytest.mark.parametrize("name", ATTACKS)
def test_anything_but_arithmetic_is_refused(name: str) -> None:
    """With the message of this package, by the parser and by the material."""
    for call in (parse_formula, rm.StrainEnergy):
        with pytest.raises(InputError, match=r"`expression` must .*; got .*\. .* Write for") as e:
            call(ATTACKS[name])
        assert len(str(e.value)) < 500


@given(st.text(max_size=60))
@example("I1**2 - 3")
def test_any_text_is_read_or_refused(text: str) -> None:
    """Any text is refused with an InputError, or has a canonical form that is read as itself."""
    try:
        formula = parse_formula(text)
    except InputError:
        return
    assert parse_formula(formula.text).text == formula.text


TOKENS = st.sampled_from(["I1", "l1", "2", "0.5", "+", "-", "*", "/", "**", "(", ")", "log(", " "])


@given(st.lists(TOKENS, max_size=25).map("".join))
@example("(I1 - 2)**2/l1 + log(I1)")
@example("-l1**-2*0.5")
def test_what_is_read_has_the_value_that_python_gives(text: str) -> None:
    """A formula that is read has the value of the same expression in Python."""
    try:
        formula = parse_formula(text)
    except InputError:
        return
    known = {"I1": np.float64(3.7), "l1": np.float64(1.3)}
    # I1l1 is a name too.
    values = {name: known.get(name, np.float64(0.7)) for name in formula.variable_names}
    with np.errstate(all="ignore"):
        ours = formula(values, np)
        try:
            python = eval(text.strip(), {**values, "log": np.log})  # noqa: S307
        except (ZeroDivisionError, OverflowError):
            return
    assert ours == pytest.approx(python, rel=1e-12, nan_ok=True) or np.iscomplexobj(python)


def test_numbers_are_taken_as_they_are_written() -> None:
    """A tenth is 1/10 for SymPy, and the nearest float for NumPy."""
    found = parse_formula("0.1*x + 1/3")({"x": sp.Symbol("x")}, sp)
    assert found == sp.Symbol("x") / 10 + sp.Rational(1, 3)
    assert parse_formula("0.1*x + 1/3")({"x": 2.0}, np) == 0.2 + 1 / 3


def test_sympy_expressions_become_text() -> None:
    """Text made of an expression is read as that expression; what has no text is refused."""
    x, y = sp.symbols("x y")
    expression = sp.sqrt(x) * sp.exp(-y / 3) + 0.1 * x ** sp.Rational(3, 2) + sp.pi - 1 / y
    again = parse_formula(sympy_as_formula_text(expression))({"x": x, "y": y}, sp)
    assert sp.simplify(again - sp.nsimplify(expression)) == 0
    for bad in (sp.Symbol("x") > 1, sp.Function("f")(x), sp.Symbol("a.b"), sp.I * x, sp.oo):
        with pytest.raises(InputError):
            rm.StrainEnergy(bad)


def test_parts_with_a_sign_are_known() -> None:
    """Logarithms, roots, denominators in which a variable occurs and that may change sign."""
    names = frozenset({"x", "y"})
    text = "log(1 - x/j) + sqrt(x*y) + 1/(x - 2) + (x - y)**0.5 + a/j + (x - 3)**2 + x**-2"
    found = [part.text for part in parse_formula(text).sign_sensitive_parts(names, names)]
    assert sorted(found) == ["1 - x / j", "x - 2", "x - y"]


@pytest.mark.parametrize(
    ("name", "is_known"), [("a", False), ("j", False), ("q", False), ("z", False), ("pi", True)]
)
def test_of_all_names_only_pi_is_positive_by_itself(name: str, is_known: bool) -> None:
    """The logarithm of a number times a positive variable has a sign that must not change."""
    found = parse_formula(f"log({name}*x)").sign_sensitive_parts(frozenset("x"), frozenset("x"))
    assert [part.text for part in found] == ([] if is_known else [f"{name} * x"])


def test_size_is_bounded() -> None:
    """Length of the text and size of the exponents have limits, which are themselves allowed.

    A file keeps formulas as text, so that the first limit is one of files too.
    """
    assert MAX_CHARACTERS == 2000
    assert parse_formula("x" + " " * (MAX_CHARACTERS - 1)).text == "x"
    assert parse_formula("(x**8)**8").text == "(x ** 8) ** 8"
    for text in ("x" + " " * MAX_CHARACTERS, "(x**8)**9", "x**-65"):
        with pytest.raises(InputError):
            parse_formula(text)


def test_a_formula_that_is_known_needs_no_sympy(tmp_path: Path) -> None:
    """On a warm start its compiled equations come from the cache, for any constants."""
    script = (
        "import sys, remanent as rm\n"
        "solid = rm.StrainEnergy('a*(I1 - 3) + b*(I1 - 3)**2', {'a': float(sys.argv[1]), 'b': 1})\n"
        "rm.simulate(rm.Actuator(material=solid), rm.Constant(0.1), duration=1.0)\n"
        "print('sympy' in sys.modules)"
    )
    environment = {**os.environ, "REMANENT_CACHE_DIR": str(tmp_path / "cache")}
    runs = [
        subprocess.run(
            [sys.executable, "-c", script, a], env=environment, capture_output=True, text=True,
            check=True,
        ).stdout.strip()
        for a in ("2", "3")
    ]  # fmt: skip
    assert runs == ["True", "False"]


def test_pi_is_known() -> None:
    """The name `pi` is the number."""
    assert parse_formula("2*pi")({}, math) == 2.0 * math.pi
