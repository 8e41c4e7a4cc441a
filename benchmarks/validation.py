"""The page about validation, from the tests and from what benchmarks measured.

``python -m benchmarks.validation`` writes ``docs/validation.md``.  Every number on the page is read
from a file of the repository: nothing is measured here.
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from benchmarks import page, store, tables
from benchmarks.errors.row import Promise
from benchmarks.targets import Results

#: The repository.
ROOT = Path(__file__).parents[1]
#: The page.
TARGET = ROOT / "docs" / "validation.md"
#: Law whose tests are listed one by one.
EXACT = "Exact solutions"
#: Files of tests on systems whose answers textbooks give.
TEXTBOOKS = (
    "tests/physics/test_textbooks.py",
    "tests/physics/test_textbook_oscillators.py",
    "tests/physics/test_balloon.py",
)
#: Rows of the benchmarks in which each tool does the same work.
_SAME_WORK = (
    ("response", "response of a cube"),
    ("film", "response of a film"),
)
#: Coverage that bounds are asked to have.
_ASKED_COVERAGE = 0.995
#: Largest median of their ratios to true errors that they are asked to have.
_ASKED_MEDIAN_RATIO = 100.0

_INTRODUCTION = """\
# Validation

<!-- Written by `python -m benchmarks.validation`; do not edit. -->

What the numbers of this package are checked against, and what came out. The page is made from the
tests and from the files that the benchmarks wrote: no number on it is typed, and a test compares
it with what these files say.
"""
_LAWS = """\
## Laws

A law is a statement that is true of every result, whatever the parameters. The tests that hold it
cite it by its name; [the page on laws](explanation/laws.md) has the equations.
In the table $p$ is the order of a method, $e$ the true error, $\\hat e$ the reported one and
$\\varepsilon$ the tolerance.
"""
_EXACT = """\
## Exact cases

Where a solution is known in closed form, by quadrature or as a convergent series, the result has
to agree with it within its own reported error. Of balloons, l is the stretch, P the pressure and
V the voltage, dimensionless.
"""
_ENGINES = """\
## Independent engines

Programs that share no code with this package, to which results are compared. Versions of Python
packages are those that the tests install; the others are those that made the kept reference data.
"""
_ERRORS = """\
## Coverage of every error

Results carry an error for each number. Each kind of error was compared with the true one in
random cases; the [tables and pictures](results.md#every-other-error) have every kind by itself,
and [the page on the error bound](explanation/error-bound.md) says how the bounds are made. A
test, `tests/contracts/test_shown_errors.py`, fails where a verb returns an error that is not
among them.

Bounds are asked to cover the true error in 99.5 % of the cases, and to be at most a hundred times
as large at the median.
"""
_STANDARD = """\
Standard errors promise that 68 % of the true errors are smaller:
"""
_TESTS = """\
## How much the tests see

Coverage of lines and branches by the tests of `make test`, counted together, by subpackage.
`make coverage` measures it, and fails where the numeric core, which decides the numbers that a user
gets, is not above 95 %.
"""
_SPEED = """\
## Speed against peers

Times are in microseconds of one core per trajectory and unit of $\\tau$, each tool at the
cheapest of its settings with which its worst error is within $10^{-8}$; [measured
speed and errors](results.md) has what each tool was given to do.
"""
_FURTHER_WORK = 'Further work, with its targets; a row "not measured" has no result yet.\n'


@dataclass(frozen=True)
class Law:
    """A law of the page on laws.

    Attributes
    ----------
    name : str
    passes : str
        What passes, as the page says it.
    files : tuple of str
        Test files that cite it.
    """

    name: str
    passes: str
    files: tuple[str, ...]


def laws() -> list[Law]:
    """Every law, in the order of the page."""
    text = (ROOT / "docs" / "explanation" / "laws.md").read_text("utf-8")
    found = []
    for section in re.split(r"^## ", text, flags=re.M)[1:]:
        passes = re.search(r"\*Passes:\*(.*?)\n\n", section, re.S)
        if passes:
            files = tuple(re.findall(r"`(tests/[\w/]+\.py)`", section))
            criterion = " ".join(passes[1].split()).replace(
                "](../", "]("
            )  # this page is one higher
            found.append(Law(section.split("\n", 1)[0], criterion, files))
    return found


@cache
def _tree(file: str) -> ast.Module:
    return ast.parse((ROOT / file).read_text("utf-8"))


@cache
def tests_of(file: str) -> list[tuple[str, str]]:
    """Name and docstring of each test function of a file."""
    return [
        (node.name, ast.get_docstring(node) or "")
        for node in _tree(file).body
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    ]


def citing_tests(law: str, file: str) -> list[tuple[str, str]]:
    """Tests of a file that cite a law; all of them where the file cites it as a whole."""
    cited = re.compile(rf"^{law}:|[Ll]aws?: (?:[\w\' ]+, )*{law}\b")
    whole = ast.get_docstring(_tree(file)) or ""
    tests = tests_of(file)
    if cited.search(whole):
        return tests
    return [test for test in tests if cited.search(test[1])] or tests


# The engines --------------------------------------------------------------------------------


@dataclass(frozen=True)
class Engine:
    """A program to compare with.

    Attributes
    ----------
    name : str
    method : str
        How it computes.
    sign : str
        A regular expression that finds it in a test file or in a module that tests import.
    version : callable
        From pinned versions by package, to the text.
    """

    name: str
    method: str
    sign: str
    version: Callable[[Mapping[str, str]], str]


def _pinned(package: str) -> Callable[[Mapping[str, str]], str]:
    return lambda versions: versions[package]


def _of_auto(_: Mapping[str, str]) -> str:
    reference = ROOT / "tests" / "literature" / "auto" / "reference" / "actuator.json"
    return str(json.loads(reference.read_text("utf-8"))["versions"]["auto"])


def _of_octave(_: Mapping[str, str]) -> str:
    tools = _results()["response"]["data"]["tools"].values()
    return next(str(tool["version"]) for tool in tools if "Octave" in tool["name"])


ENGINES = (
    Engine("heyoka.py", "Taylor series, in double and extended precision",
           r"import heyoka|importorskip\(\"heyoka", _pinned("heyoka")),
    Engine("SciPy", "DOP853 and Radau: other Runge–Kutta methods, with step control",
           r"solve_ivp|DOP853", _pinned("scipy")),
    Engine("AUTO-07p", "collocation and continuation: branches, folds, doublings",
           r"literature\.auto|auto07p", _of_auto),
    Engine("mpmath", "arithmetic of fifty digits and special functions",
           r"^\s*(?:import|from) mpmath", _pinned("mpmath")),
    Engine("GNU Octave", "runs the exported equations, as a C compiler and Node do",
           r"require_program\(\"octave", _of_octave),
)  # fmt: skip


def pinned_versions() -> dict[str, str]:
    """Versions in the file of constraints."""
    text = (ROOT / "constraints.txt").read_text("utf-8")
    return dict(re.findall(r"^([\w.-]+)==([^\s;]+)", text, re.M))


@cache
def _test_texts() -> dict[str, str]:
    """The text of each Python file of the tests, by its path."""
    return {
        path.relative_to(ROOT).as_posix(): path.read_text("utf-8")
        for path in sorted((ROOT / "tests").rglob("*.py"))
    }


def files_with(sign: str) -> list[str]:
    """Test files that use an engine, by themselves or through a module beside them."""
    pattern = re.compile(sign, re.M)
    texts = _test_texts()
    direct = {file for file, text in texts.items() if pattern.search(text)}
    helpers = {file for file in direct if not Path(file).name.startswith("test_")}
    modules = [re.escape(file.removesuffix(".py").replace("/", ".")) for file in helpers]
    through = re.compile(rf"^from (?:{'|'.join(modules)}) import", re.M) if modules else None
    return [
        file
        for file, text in texts.items()
        if Path(file).name.startswith("test_")
        and (file in direct or (through is not None and through.search(text)))
    ]


# The page -----------------------------------------------------------------------------------


def _results() -> Results:
    """What benchmarks measured, by row."""
    names = [path.stem for path in sorted(store.FOLDER.glob("*.json"))]
    loaded = {name: store.load(name) for name in names if name not in ("coverage", "orbit_search")}
    return {name: result for name, result in loaded.items() if result}


def _errors() -> list[dict[str, Any]]:
    return [
        json.loads(path.read_text("utf-8"))
        for path in sorted((store.FOLDER / "errors").glob("*.json"))
    ]


def _table(head: Sequence[str], rows: Iterator[Sequence[str]]) -> str:
    align = ["---:" if title.endswith(":") else "---" for title in head]
    lines = [[title.rstrip(":") for title in head], align, *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def _statement(docstring: str) -> str:
    """What a test states: the summary of its docstring, without the name of a law."""
    summary = " ".join(docstring.partition("\n\n")[0].split())
    without_law = re.sub(rf"^{EXACT}: (\w)", lambda first: first[1].upper(), summary)
    return re.sub(r"([|*_])", r"\\\1", without_law)


def _of_laws(found: Sequence[Law]) -> Iterator[str]:
    def rows() -> Iterator[Sequence[str]]:
        for law in found:
            count = sum(len(citing_tests(law.name, file)) for file in law.files)
            anchor = law.name.lower().replace("'", "").replace(" ", "-")
            link = f"[{law.name}](explanation/laws.md#{anchor})"
            yield link, law.passes, str(count), str(len(law.files))

    yield _LAWS
    yield _table(["law", "what passes", "tests:", "files:"], rows())


def _of_exact_cases(found: Sequence[Law]) -> Iterator[str]:
    (exact,) = [law for law in found if law.name == EXACT]
    sources = [(file, citing_tests(EXACT, file)) for file in exact.files]
    sources += [(file, tests_of(file)) for file in TEXTBOOKS]

    def rows() -> Iterator[Sequence[str]]:
        for file, listed in sources:
            for _, docstring in listed:
                yield _statement(docstring), f"`{Path(file).name}`"

    yield _EXACT
    yield _table(["what must hold", "file"], rows())


def _of_engines() -> Iterator[str]:
    versions = pinned_versions()

    def rows() -> Iterator[Sequence[str]]:
        for engine in ENGINES:
            files = files_with(engine.sign)
            count = sum(len(tests_of(file)) for file in files)
            version = engine.version(versions)
            yield engine.name, version, engine.method, str(count), str(len(files))

    yield _ENGINES
    head = ["program", "version", "method", "tests in files that use it:", "files:"]
    yield _table(head, rows())
    cases = json.loads(
        (ROOT / "tests" / "literature" / "regimes" / "cases.json").read_text("utf-8")
    )
    counts = ", ".join(f"{count} {truth}" for truth, count in sorted(cases["counts"].items()))
    yield (
        f"Regimes are compared with {len(cases['cases'])} motions whose kind is known, by "
        f"construction or from reference orbits of heyoka.py {cases['heyoka']}: {counts}. None may "
        "have a wrong label.\n"
    )
    search = json.loads((store.FOLDER / "orbit_search.json").read_text("utf-8"))
    for kind in ("damped", "undamped"):
        one = search[kind]
        yield (
            f"The search for periodic orbits was set beside brute force for {one['cases']} {kind} "
            f"actuators: of {one['orbits']} orbits that brute force found, "
            f"{one['missed in silence']} were missed without notice; of {one['listed']} that were "
            f"listed, {one['not orbits']} are none.\n"
        )


def _of_errors(measured: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    bounds = [row for row in measured if row["promise"] == Promise.BOUND.value]
    standard = [row for row in measured if row["promise"] == Promise.STANDARD.value]
    coverage = json.loads((store.FOLDER / "coverage.json").read_text("utf-8"))
    total = coverage["total"]
    yield _ERRORS
    yield (
        f"The bounds of states and extremes were measured on {total['cases']} trajectories of "
        f"random systems, drives and tolerances, against {coverage['reference']}: "
        f"{_percent(total['coverage'])} of those that met the tolerance are covered (at least "
        f"{_percent(total['coverage_at_least'])} at 95 % confidence), and the bound is "
        f"{total['median_ratio']:.1f} times the true error at the median.\n"
    )
    cases = sum(row["total"]["cases"] for row in bounds)
    least = min(bounds, key=lambda row: row["total"]["coverage"])
    short = [row["name"] for row in bounds if row["total"]["coverage"] < _ASKED_COVERAGE]
    wide = [row["name"] for row in bounds if row["total"]["median_ratio"] > _ASKED_MEDIAN_RATIO]
    yield (
        f"The bounds of {len(bounds)} further kinds of numbers were measured in {cases} cases. The "
        f"least covered are {least['name']}, at {_percent(least['total']['coverage'])}; "
        + (f"below 99.5 %: {', '.join(short)}. " if short else "none is below 99.5 %. ")
        + (
            f"More than a hundred times as large at the median: {', '.join(wide)}.\n"
            if wide
            else "None is more than a hundred times as large at the median.\n"
        )
    )
    head = ["verb", "kinds of numbers:", "cases:", "least covered:", "largest median ratio:"]
    yield _table(head, _rows_by_verb(bounds))
    yield "```{figure} results/coverage.svg\n:alt: Reported against true errors; share covered\n"
    yield "Reported against true errors of states and extremes.\n```\n"
    yield _STANDARD
    rows = (
        (row["name"], f"`{row['variable']}`", str(row["total"]["cases"]),
         _percent(row["total"]["coverage"]))
        for row in standard
    )  # fmt: skip
    yield _table(["number", "error", "cases:", "covered:"], rows)


def _rows_by_verb(bounds: Sequence[Mapping[str, Any]]) -> Iterator[Sequence[str]]:
    by_verb: dict[str, list[Mapping[str, Any]]] = {}
    for row in bounds:
        by_verb.setdefault(row["variable"].partition(":")[0], []).append(row["total"])
    for verb, totals in sorted(by_verb.items()):
        yield (
            f"{{py:obj}}`~remanent.{verb}`",
            str(len(totals)),
            str(sum(total["cases"] for total in totals)),
            _percent(min(total["coverage"] for total in totals)),
            f"{max(total['median_ratio'] for total in totals):.1f}",
        )


def _percent(share: float) -> str:
    return f"{100.0 * share:.2f} %"


def _of_tests() -> Iterator[str]:
    lines, mutants = (store.load(f"tests/{name}") for name in ("lines", "mutants"))
    if lines is None:
        return
    yield _TESTS
    rows = (
        (f"**{name}**" if name == "numeric core" else name, str(row["num_statements"]),
         str(row["num_branches"]), _percent(row["share"]))
        for name, row in lines["packages"].items()
    )  # fmt: skip
    yield _table(["subpackage", "lines:", "branches:", "covered:"], rows)
    if mutants is not None:
        yield _sentence_on_mutants(mutants["at first"], mutants["packages"]["in all"])


def _sentence_on_mutants(at_first: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    low, high = at_first["interval"]
    return (
        f"Of {now['mutants']} random changes of the numeric core (`make mutants`) "
        f"{now['equivalent']} change no result beyond its error. Of the others the tests noticed "
        f"{_percent(at_first['score'])} when these were drawn ({_percent(low)} to "
        f"{_percent(high)} at 95 % confidence), and {_percent(now['score'])} with the tests that "
        "were written for those they had missed.\n"
    )


def _of_speed(results: Results) -> Iterator[str]:
    yield _SPEED
    yield from page.warnings(results)

    def rows() -> Iterator[Sequence[str]]:
        for row, work in _SAME_WORK:
            if row not in results:
                continue
            data = results[row]["data"]["tools"]
            ours = data["remanent"]["microseconds"]
            for tool in sorted(data.values(), key=lambda one: one["microseconds"]):
                ratio = tool["microseconds"] / ours
                yield (
                    work, tool["name"], tool["version"], _digits(tool["microseconds"]),
                    _digits(ratio), f"{tool['worst']:.0e}",
                )  # fmt: skip

    yield _table(
        ["work", "tool", "version", "µs:", "of ours with its error:", "worst error:"], rows()
    )
    yield _FURTHER_WORK
    yield page.TARGETS
    yield tables.targets(results).markdown() + "\n"
    yield "## Machine and versions\n"
    yield tables.environment(results.values()).markdown() + "\n"


def _digits(value: float) -> str:
    """Three digits, without an exponent."""
    return f"{value:.0f}" if value >= 100.0 else f"{value:.3g}"


def text() -> str:
    """The page."""
    found, measured, results = laws(), _errors(), _results()
    parts = [
        _INTRODUCTION,
        *_of_laws(found),
        *_of_exact_cases(found),
        *_of_engines(),
        *_of_errors(measured),
        *_of_tests(),
        *_of_speed(results),
    ]
    return "\n".join(parts).rstrip() + "\n"


def write() -> Path:
    """Write the page; return its path."""
    TARGET.write_text(text(), encoding="utf-8")
    return TARGET


if __name__ == "__main__":
    print(f"wrote {write().name}")
