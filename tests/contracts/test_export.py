"""Exported equations are those that are integrated: every kind of system, drive and language."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

import pytest
import tree_sitter

import remanent as rm
from remanent.codegen.languages.table import LANGUAGES
from remanent.models.drives.base import Drive
from remanent.studies.export.export import EXPORT_LANGUAGES
from tests.contracts.exported import (
    CASES,
    RESERVED,
    SINE,
    random_cases,
    require_engine,
    require_equal,
)
from tests.contracts.public import examples
from tests.contracts.tools import ASK, python_module
from tests.faults.own_systems import DUFFING


@pytest.mark.parametrize("tool", ASK)
def test_exported_rates_and_loads_are_those_of_the_engine(tool: str, tmp_path: Path) -> None:
    """Law: rates to 1e-12, loads to 1e-13, at rest's neighbours and at jumps of the load."""
    require_engine(CASES, ASK[tool](CASES, tmp_path))


@pytest.mark.slow
@pytest.mark.parametrize("tool", ASK)
def test_random_systems_are_exported(tool: str, tmp_path: Path) -> None:
    """The same law, for a hundred random systems under drives of every kind."""
    chosen = random_cases(100)
    given = {type(drive) for _, drive in chosen.values()}
    assert {type(drive) for drive in examples(Drive).values()} <= given  # type: ignore[type-abstract]
    require_engine(chosen, ASK[tool](chosen, tmp_path))


def is_in_language(language: str, text: str) -> bool:
    """Whether a text is in a language, by its grammar."""
    grammar = import_module(f"tree_sitter_{language}")
    parser = tree_sitter.Parser(tree_sitter.Language(grammar.language()))
    return not parser.parse(text.encode()).root_node.has_error


@pytest.mark.parametrize("language", ["julia", "matlab"])
@pytest.mark.parametrize("case", ["reserved names", "functions", "heat", "steps on an actuator"])
def test_grammars_accept_the_text(language: str, case: str) -> None:
    """Law: the text is in the language, by its grammar; one without its last parenthesis is not."""
    for name, text in rm.export(*CASES[case], language).items():
        assert is_in_language(language, text), name
        at = text.rindex(")")
        assert not is_in_language(language, text[:at] + text[at + 1 :]), name


@pytest.mark.slow
@pytest.mark.parametrize("language", ["julia", "matlab"])
def test_grammars_accept_every_text(language: str) -> None:
    """The same law, for every case and a hundred random systems."""
    for name, case in {**CASES, **random_cases(100)}.items():
        for text in rm.export(*case, language).values():
            assert is_in_language(language, text), name


@pytest.mark.parametrize("language", [one for one in EXPORT_LANGUAGES if one != "auto07p"])
def test_headers_say_what_it_is(language: str) -> None:
    """Law: the first file has names, units, values and what made it, in comments of ASCII."""
    system = RESERVED.replace(parameters={"beta": 2.125})
    text = next(iter(rm.export(system, SINE, language).values()))
    mark = LANGUAGES[language].comment
    comments = [line for line in text.splitlines() if line.startswith(mark)]
    said = "\n".join(comments)
    for part in ("LagrangianSystem", "remanent 0", "new (?*/ ?), 0.0", "y (mm)", "beta = 2.125",
                 f"repeats after {SINE.period!r}", "t = 0.125, written t_1"):  # fmt: skip
        assert part in said
    assert text.isascii()


def test_parameters_can_be_changed_in_the_text(tmp_path: Path) -> None:
    """Law: with other values of parameters, the frequency too, it is the system with these."""
    system, drive = rm.Actuator(dissipation=rm.Rayleigh(0.1)), rm.SineSquared(0.4, 1.25)
    module = python_module(system, drive, tmp_path)
    changed = module["parameters"] | {"omega": 2.0, "temperature": 350.0}
    expected = rm.rates(system.replace(temperature=350.0), drive.replace(omega=2.0))
    for t, y in ((0.3, [1.1, 0.2]), (7.0, [0.9, -0.1])):
        require_equal(module["rates"](t, y, changed), expected(t, y))


@pytest.mark.parametrize("language", EXPORT_LANGUAGES)
def test_names_are_free_of_reserved_words(language: str) -> None:
    """Law: identifiers are new, one for each name, and none is a reserved word."""
    words = LANGUAGES[language].reserved_words
    names = [*sorted(words), "x", "X", "a.b", "a_b", "a_b_1", "9", "long" * 30, "long" * 31]
    found = [*import_module("remanent.codegen.languages.identifiers")
             .identifiers_of(names, LANGUAGES[language]).values()]  # fmt: skip
    assert len({*found}) == len(names)
    assert not words & {*found}
    assert all(re.fullmatch(r"[A-Za-z]\w{0,59}", one) for one in found)


class Unsaid(rm.Sine):
    """A drive of somebody else's, which does not say what its waveforms are."""

    waveforms = ()


def test_drives_that_do_not_say_what_they_are_are_refused() -> None:
    """Waveforms of a drive of one's own have to be told as data."""
    with pytest.raises(rm.InputError, match="`drive` must say as data what its waveforms are"):
        rm.export(DUFFING, Unsaid(0.1, 1.0), "c")


@pytest.mark.parametrize("language", [one for one in EXPORT_LANGUAGES if one != "auto07p"])
def test_extreme_numbers_are_written(language: str) -> None:
    """Law: numbers of any size are text, without a warning."""
    extreme = [
        rm.Steps([0.0, 1e308], [0.0, 1e300]), rm.Ramp([0.0, 5e-324, 1.0], [0.0, 0.0, 1.0]),
        rm.Chirp(1e300, 0.0, 1e150, 1e100), rm.Sine(1e-300, 1e300), rm.Sine(0.1, 1e-300),
    ]  # fmt: skip
    for drive in extreme:
        text = "".join(rm.export(DUFFING.replace(parameters={"delta": -1e300}), drive, language)
                       .values())  # fmt: skip
        assert "-1e300" in text.replace("e+", "e")
        assert "nan" not in text.replace("np.nan", "")
