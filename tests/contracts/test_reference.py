"""Every public docstring says what the reference promises.

Types, shapes and units of arguments, what is returned, what is raised, a source, an example, and
where to go on.
"""

from __future__ import annotations

import enum
import inspect
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from numpydoc.docscrape import FunctionDoc, NumpyDocString
from numpydoc.validate import validate

import remanent as rm
from remanent.plots import style
from tests.contracts.sound_calls import SOUND

ROOT = Path(__file__).parents[2]
#: What numpydoc asks for and is not asked here: a second paragraph, a capital where a sentence
#: begins with a symbol, and a verb where a summary is a noun that ends in "s".
NOT_ASKED = {"ES01", "PR08", "SS05"}
#: Of methods no example is asked: their class has one.
NOT_ASKED_OF_METHODS = {"EX01", "SA01"}


def families() -> Iterator[tuple[str, list[str]]]:
    """Heading and names of each family of public names."""
    stub = Path(str(rm.__file__)).with_suffix(".pyi").read_text("utf-8")
    for part in stub.split("# Family: ")[1:]:
        heading, _, lines = part.partition("\n")
        yield heading, re.findall(r"^from \S+ import (\w+) as \1$", lines, re.M)


FAMILIES = dict(families())
PUBLIC: dict[str, Any] = {
    **{name: getattr(rm, name) for names in FAMILIES.values() for name in names},
    **{f"plot.{name}": getattr(rm.plot, name) for name in rm.plot.__all__},
    **{f"plot.style.{name}": getattr(style, name) for name in ("subplots", "context")},
    "plot.style.save_figure": style.save_figure,
}
#: Methods of actuators that the reference shows.
METHODS = {
    name: getattr(rm.Actuator, name)
    for name in (
        "from_si", "in_unit", "load", "frequency", "time", "stress", "viscosity", "coupling",
        "parameter_values", "replace",
    )
}  # fmt: skip
#: Families whose names stand for equations or methods, so that they have a source or notes.
WITH_A_SOURCE = (
    "The actuator", "Materials and the magnet", "Dissipation and heat", "Motion",
    "Forced response", "Periodic orbits and bifurcations", "Regimes", "Equilibria", "Commands",
)  # fmt: skip
#: What the text on an argument of this name has to say of its unit.
UNITS = {
    "temperature": r"kelvin|\bK\b|\bT\b",
    "omega": r"[Aa]ngular frequency|radians",
    "phase": r"radians",
    "duration": r"\btau\b|τ",
    "periods": r"periods of the load|drive periods|\btau\b",
    "omega_range": r"radians",
}


def import_name(value: Any) -> str:
    """Where numpydoc finds a value."""
    inner = inspect.unwrap(value)
    if inner.__module__ == "remanent":
        return f"remanent.{value.__name__}"
    return f"{inner.__module__}.{inner.__qualname__}"


def faults(name: str) -> set[str]:
    """What numpydoc finds in a docstring, as ``code: message``."""
    return {f"{code}: {text}" for code, text in validate(name)["errors"]}


def asked(found: set[str], left_out: set[str] = NOT_ASKED) -> set[str]:
    return {fault for fault in found if fault[:4] not in left_out}


def sections(value: Any) -> NumpyDocString:
    return NumpyDocString(inspect.getdoc(value) or "")


@pytest.mark.parametrize("name", PUBLIC)
def test_docstrings_are_complete(name: str) -> None:
    """Summary, every argument with its type, what is returned, an example, where to go on."""
    value = PUBLIC[name]
    found = asked(faults(import_name(value)))
    if isinstance(value, type) and issubclass(value, enum.Enum | Exception):
        found = {fault for fault in found if "PR01" not in fault}  # not called by users
    assert not found


@pytest.mark.parametrize("name", METHODS)
def test_methods_of_actuators_are_complete(name: str) -> None:
    """Summary, every argument with its type, what is returned and what is raised."""
    found = asked(faults(f"remanent.Actuator.{name}"), NOT_ASKED | NOT_ASKED_OF_METHODS)
    # Numbers that belong together are told together, in another order than in the signature.
    assert not {fault for fault in found if "PR03" not in fault}


def undocumented(a: float, b: float) -> float:
    """Add two numbers.

    Parameters
    ----------
    a
        One of them.
    """
    return a + b


def test_an_incomplete_docstring_is_found() -> None:
    """An argument without text or type, no returns, no example: each is told."""
    codes = {fault[:4] for fault in asked(faults(f"{__name__}.undocumented"))}
    assert codes >= {"PR01", "PR04", "RT01", "EX01", "SA01"}


def takes_arguments(value: Any) -> bool:
    called_by_users = not (isinstance(value, type) and issubclass(value, enum.Enum | Exception))
    return called_by_users and bool(inspect.signature(value).parameters)


@pytest.mark.parametrize(
    "name", [n for n, v in PUBLIC.items() if takes_arguments(v) and "style" not in n]
)
def test_errors_are_named(name: str) -> None:
    """Whatever takes arguments refuses bad ones by an InputError, and says when."""
    raised = {entry.type: " ".join(entry.desc) for entry in sections(PUBLIC[name])["Raises"]}
    assert len(raised.get("InputError", "")) > 10


@pytest.mark.parametrize("family", WITH_A_SOURCE)
def test_equations_and_methods_have_a_source(family: str) -> None:
    """Notes, references, or an equation of the article."""
    assert FAMILIES[family]
    for name in FAMILIES[family]:
        doc = sections(PUBLIC[name])
        text = inspect.getdoc(PUBLIC[name]) or ""
        assert doc["Notes"] or doc["References"] or "[Thermal, eq. " in text, name


def test_citations_are_on_the_page_of_sources() -> None:
    """Whom a docstring cites by name and year, the page of sources has."""
    sources = (ROOT / "docs" / "explanation" / "sources.md").read_text("utf-8")
    text = "\n".join(inspect.getdoc(value) or "" for value in PUBLIC.values())
    cited = re.findall(r"\b([A-Z]\w+)(?: et al\.| and [A-Z]\w+)?,? (\d{4})\b", text)
    references = "\n".join(
        line for value in PUBLIC.values() for line in sections(value)["References"]
    )
    authors = re.findall(r"(?:[A-Z]\. )+([A-Z]\w+)[ ,]", references)
    assert len(cited) > 3
    assert len(authors) > 8
    missing = {name for name, _ in cited if name not in sources}
    assert not missing | {name for name in authors if name not in sources}


def arguments(value: Any) -> Iterator[tuple[str, str]]:
    """Each documented argument with its text; those that are told together, one by one."""
    for entry in sections(value)["Parameters"]:
        for name in entry.name.split(", "):
            yield name, f"{entry.type} {' '.join(entry.desc)}"


@pytest.mark.parametrize("argument", UNITS)
def test_units_of_arguments_are_told(argument: str) -> None:
    """Kelvin, radians, units of τ: wherever an argument of that name is taken."""
    texts = {
        name: text
        for name, value in PUBLIC.items()
        for found, text in arguments(value)
        if found == argument
    }
    assert texts
    silent = {name for name, text in texts.items() if not re.search(UNITS[argument], text)}
    assert not silent


def other_names() -> Iterator[tuple[str, str]]:
    """Each name under See Also, with the name whose docstring it is in."""
    for name, value in PUBLIC.items():
        for entries, _ in sections(value)["See Also"]:
            for other, _role in entries:
                yield name, other


@pytest.mark.parametrize(("name", "other"), list(other_names()))
def test_see_also_names_what_is_public(name: str, other: str) -> None:
    """What is referred to exists, under the name that is written, and is another one."""
    short = other.removeprefix("remanent.").removeprefix("plots.")
    owner, _, method = short.partition(".")
    known = short in PUBLIC or f"plot.{short}" in PUBLIC or f"plot.style.{short}" in PUBLIC
    assert known or (owner == "Actuator" and method in METHODS)
    assert short != name


def returned_text(verb: Callable[..., Any]) -> str:
    doc = FunctionDoc(inspect.unwrap(verb))
    return " ".join(line for entry in doc["Returns"] for line in [entry.type, *entry.desc])


#: Verbs whose results are those of another verb, to whose page theirs refers, or what they are
#: given, and those that return no Dataset.
NOT_OF_THEIR_OWN = {
    "regime_chart", "basins", "response_diagram", "switch_branch", "rescale", "to_si",
    "read_measurements", "uncertainty", "read_system", "read_drive", "shape_command",
}  # fmt: skip
#: Variables that the text calls the state and the parameter.
STATE_AND_PARAMETERS = {"stretch", "stretch_rate", "omega", "b", "m", "temperature"}


def is_told(variable: str, text: str) -> bool:
    """Whether a text names a variable, or the family that it belongs to."""
    prefix, _, base = variable.partition("_")
    family = base in STATE_AND_PARAMETERS and (
        f"``{prefix}_<" in text or f"``{prefix}_stretch``" in text
    )
    return f"``{variable}``" in text or variable in STATE_AND_PARAMETERS or family


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(set(SOUND) - NOT_OF_THEIR_OWN))
def test_variables_of_results_are_told(name: str) -> None:
    """Every variable of a result is named under Returns, but for state, parameters, errors."""
    result = getattr(rm, name)(**SOUND[name]())
    assert isinstance(result, xr.Dataset)
    told = returned_text(getattr(rm, name))
    names = {str(variable) for variable in result.data_vars}
    values = {variable for variable in names if not variable.endswith("_error")}
    assert values
    assert not {variable for variable in values if not is_told(variable, told)}
