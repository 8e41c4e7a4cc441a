"""Exported equations are those that are integrated: every kind of system, drive and language."""

from __future__ import annotations

import ctypes
import json
import re
import runpy
import shutil
import subprocess
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tree_sitter
from scipy.integrate import solve_ivp

import remanent as rm
from remanent._typing import FloatArray
from remanent.codegen.languages.table import LANGUAGES
from remanent.models.drives.base import Drive
from remanent.models.materials.base import Material
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.export.export import EXPORT_LANGUAGES
from tests.contracts.public import examples
from tests.faults.own_systems import BOTH, DUFFING, FREE, PAIR, TWO_LOADS
from tests.faults.test_random_systems import random_system

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


def cases() -> dict[str, tuple[Any, Drive]]:
    """Each system under a sine, each drive on an oscillator, and several loads."""
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
    return {
        **{name: (system, SINE) for name, system in systems().items()},
        **{f"{name} on Duffing": (DUFFING, drive) for name, drive in drives().items()},
        "steps on an actuator": (rm.Actuator(), rm.Steps.example()),
        "two loads": (TWO_LOADS, BOTH),
        **{f"two loads, {name}": (TWO_LOADS, rm.Loads(one)) for name, one in both.items()},
    }


CASES = cases()


@dataclass(frozen=True)
class Exported:
    """Exported equations that can be called, in one language."""

    rates: Callable[[float, FloatArray], Sequence[float]]
    loads: Mapping[str, Callable[[float], float]]


def times_of(drive: Drive, rng: np.random.Generator) -> list[float]:
    """Times at which a load is known: random ones, and those of its jumps."""
    end = min(drive.known_until, 20.0)
    breaks = [one for one in getattr(drive, "times", ()) if one <= end]
    return [0.0, *breaks, *rng.uniform(0.0, end, 3)]


@cache
def points(system: Any, drive: Drive) -> list[tuple[float, FloatArray, FloatArray]]:
    """Times, states, and the rates that are integrated."""
    rng = np.random.default_rng(1)
    rates = rm.rates(system, drive)
    rest = lay_out_ensemble(system, drive).initial_states[0]
    found = []
    for t in times_of(drive, rng):
        y = rest * rng.uniform(0.98, 1.05, rest.size) + rng.uniform(-0.03, 0.05, rest.size)
        found.append((float(t), y, rates(t, y)))
    return found


def require_equal(seen: Any, expected: FloatArray) -> None:
    """Equal to 1e-12 of the largest rate, and infinite or NaN where the other is."""
    finite = expected[np.isfinite(expected)]
    scale = float(np.abs(finite).max(initial=1e-300))
    np.testing.assert_allclose(seen, expected, rtol=1e-12, atol=1e-12 * scale)


def require_loads(exported: Exported, drive: Drive, t: float) -> None:
    """The loads in the text are those of the drive."""
    seen = [exported.loads[name](t) for name in drive.load_names]
    np.testing.assert_allclose(seen, np.ravel(drive(t)), rtol=0.0, atol=1e-13)


def write(files: Mapping[str, str], folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text, encoding="ascii")


def load_names(drive: Drive) -> dict[str, str]:
    return {name: "load" if name == "load" else f"load_{name}" for name in drive.load_names}


# Languages that are run ------------------------------------------------------------------


def python_of(system: Any, drive: Drive, folder: Path) -> Exported:
    write(rm.export(system, drive, "python"), folder)
    module = runpy.run_path(str(folder / "system.py"))
    assert list(module["initial"].shape) == [len(module["state_names"])]
    return Exported(module["rates"], {k: module[v] for k, v in load_names(drive).items()})


#: Names of a file in C, which get a number where many files are one library.
C_NAMES = [
    *("pieces", "piece_at", "remanent_load", "remanent_load_pressure", "remanent_load_voltage"),
    *(f"remanent_{name}" for name in ("rates", "initial", "state_names", "parameters", "breaks")),
]


def c_of(chosen: Mapping[str, tuple[Any, Drive]], folder: Path) -> list[Exported]:
    """One library with all cases."""
    text = []
    for k, (system, drive) in enumerate(chosen.values()):
        write({f"system_{k}.c": rm.export(system, drive, "c")["system.c"]}, folder)
        text += [f"#define {name} case_{k}_{name}" for name in C_NAMES]
        text += [f'#include "system_{k}.c"', "#undef REMANENT_STATES"]
        text += [f"#undef {name}" for name in C_NAMES]
    write({"all.c": "\n".join(text) + "\n"}, folder)
    library = folder / "all.so"
    command = ["cc", "-std=c99", "-O0", "-Wall", "-Wextra", "-Werror", "-pedantic", "-fPIC",
               "-shared", "-ffp-contract=off", "all.c", "-o", str(library), "-lm"]  # fmt: skip
    subprocess.run(command, check=True, cwd=folder)
    functions = ctypes.CDLL(str(library))
    return [
        _c_functions(functions, f"case_{k}_remanent_", drive)
        for k, (_, drive) in enumerate(chosen.values())
    ]


def _c_functions(functions: ctypes.CDLL, start: str, drive: Drive) -> Exported:
    row = ctypes.POINTER(ctypes.c_double)
    of_rates = getattr(functions, f"{start}rates")
    of_rates.argtypes, of_rates.restype = [ctypes.c_double, row, row], None
    loads = {}
    for name, function in load_names(drive).items():
        loads[name] = getattr(functions, f"{start}{function}")
        loads[name].argtypes, loads[name].restype = [ctypes.c_double], ctypes.c_double

    def rates(t: float, y: FloatArray) -> list[float]:
        array = ctypes.c_double * len(y)
        result = array()
        of_rates(t, array(*y), result)
        return list(result)

    return Exported(rates, loads)


def require_c(chosen: Mapping[str, tuple[Any, Drive]], folder: Path) -> None:
    """Law: functions of C give the rates and loads of the engine."""
    for (system, drive), exported in zip(chosen.values(), c_of(chosen, folder), strict=True):
        for t, y, expected in points(system, drive):
            require_equal(exported.rates(t, y), expected)
            require_loads(exported, drive, t)


#: Reads cases from a file, and writes what the module of each says.
NODE = """
import { readFileSync } from "node:fs";
const answers = [];
for (const one of JSON.parse(readFileSync(process.argv[2], "utf8"))) {
  const module = await import(one.path);
  answers.push(one.points.map(([t, y]) => [
    module.rates(t, y).map(String), one.loads.map((name) => String(module[name](t)))]));
}
console.log(JSON.stringify(answers));
"""


def javascript_answers(chosen: Mapping[str, tuple[Any, Drive]], folder: Path) -> list[Any]:
    """Rates and loads of all cases by one process."""
    given = []
    for k, (system, drive) in enumerate(chosen.values()):
        files = rm.export(system, drive, "javascript")
        write({f"case_{k}.mjs": files["system.js"]}, folder)
        asked = [(t, y.tolist()) for t, y, _ in points(system, drive)]
        path = str(folder / f"case_{k}.mjs")
        given.append({"path": path, "points": asked, "loads": [*load_names(drive).values()]})
    (folder / "ask.mjs").write_text(NODE)
    (folder / "cases.json").write_text(json.dumps(given))
    command = ["node", str(folder / "ask.mjs"), str(folder / "cases.json")]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    answers: list[Any] = json.loads(done.stdout)
    return answers


def require_javascript(chosen: Mapping[str, tuple[Any, Drive]], folder: Path) -> None:
    """Law: modules of JavaScript give the rates and loads of the engine."""
    answers = javascript_answers(chosen, folder)
    assert len(answers) == len(chosen) > 0
    for (system, drive), answered in zip(chosen.values(), answers, strict=True):
        for (t, _, expected), (rates, loads) in zip(points(system, drive), answered, strict=True):
            require_equal(list(map(float, rates)), expected)
            seen = {
                name: lambda _, x=x: float(x)
                for name, x in zip(drive.load_names, loads, strict=True)
            }
            require_loads(Exported(lambda *_: [], seen), drive, t)


# Languages that are translated to Python -----------------------------------------------------

#: Before a text that was translated.
PROLOGUE = """
import numpy as np
from bisect import bisect_right as searchsortedlast
from types import SimpleNamespace
from numpy import sqrt, exp, log, sin, cos, floor
atan, NaN, Inf = np.arctan, np.nan, np.inf
real_sqrt, real_log, real_sin, real_cos = sqrt, log, sin, cos
class OneBased(list):
    def __getitem__(self, k):
        return np.float64(list.__getitem__(self, k - 1))
    def __setitem__(self, k, x):
        list.__setitem__(self, k - 1, x)
class Rows(list):
    def __getitem__(self, k):
        return OneBased(list.__getitem__(self, k - 1))
"""


def translated_julia(files: Mapping[str, str]) -> str:
    """Functions of Julia as functions of Python."""
    text = re.sub(r"^real_\w+\(x\) = .*$", "", files["system.jl"], flags=re.M)
    text = text.replace("const parameters = NamedTuple()", "parameters = SimpleNamespace()")
    text = text.replace("const parameters = (", "parameters = SimpleNamespace(")
    text = re.sub(r"const pieces = (\[.*?^\])", r"pieces = Rows(\1)", text, flags=re.S | re.M)
    text = re.sub(r"const (\w+) = (?:Float64)?", r"\1 = ", text)
    text = text.replace("piece_starts = [row[1] for", "piece_starts = [row[0] for")
    text = re.sub(r"^function (\w+)!?(.*)$", r"def \1\2:", text, flags=re.M)
    return re.sub(r"^end$", "", text, flags=re.M).replace("return nothing", "return dydt")


def translated_matlab(files: Mapping[str, str]) -> str:
    """Functions of MATLAB as functions of Python."""
    text = "\n".join(
        re.sub(r"^function z = real_.*?^end$", "", one, flags=re.S | re.M)
        for name, one in files.items() if name != "remanent_run.m"
    )  # fmt: skip
    text = re.sub(r"^function (\w+) = (\w+)(.*?)$(.*?)^end$", r"def \2\3:\4  return \1", text,
                  flags=re.S | re.M)  # fmt: skip
    text = re.sub(r"  if nargin < (\d), .*$", "", text.replace("%", "#"), flags=re.M)
    text = text.replace("dydt = zeros(", "dydt = OneBased([0.0]*30); (")
    text = re.sub(r"\b(y|dydt|row)\((\d+)\)", r"\1[\2]", text)
    text = text.replace("p = struct()", "p = SimpleNamespace()")
    text = re.sub(r"  persistent.*?pieces = \[(.*?)\];\n  end", _matrix, text, flags=re.S)
    found = "  row = OneBased(pieces[max(sum(r[0] <= t for r in pieces), 1) - 1])"
    return re.sub(r"^  row = pieces\(.*$", found, text, flags=re.M)


def _matrix(found: re.Match[str]) -> str:
    rows = ", ".join(f"[{row}]" for row in re.findall(r"^ *([^;\n]+);$", found[1], re.M))
    return f"  pieces = [{rows}]"


def translated(language: str, system: Any, drive: Drive, folder: Path) -> Exported:
    """What a language that is not installed says, as far as its statements go."""
    files = rm.export(system, drive, language)
    translate = {"julia": translated_julia, "matlab": translated_matlab}[language]
    write({"translated.py": PROLOGUE + translate(files)}, folder)
    with np.errstate(all="ignore"):
        module = runpy.run_path(str(folder / "translated.py"))
    start = "remanent_" if language == "matlab" else ""
    p = module["remanent_parameters"]() if language == "matlab" else module["parameters"]
    one_based = module["OneBased"]

    def rates(t: float, y: FloatArray) -> list[float]:
        with np.errstate(all="ignore"):
            if language == "matlab":
                return list(module["remanent_rates"](t, one_based(y), p))[: len(y)]
            dydt = one_based([0.0] * len(y))
            return list(module["rates"](dydt, one_based(y), p, t))

    loads = {
        name: lambda t, of=module[f"{start}{function}"]: float(of(t, p))
        for name, function in load_names(drive).items()
    }
    return Exported(rates, loads)


def makers() -> dict[str, Callable[[Any, Drive, Path], Exported]]:
    """Languages that are run one case after another."""
    return {
        "python": python_of,
        "julia": lambda *given: translated("julia", *given),
        "matlab": lambda *given: translated("matlab", *given),
    }


def is_in_language(language: str, text: str) -> bool:
    """Whether a text is in a language, by its grammar."""
    grammar = import_module(f"tree_sitter_{language}")
    parser = tree_sitter.Parser(tree_sitter.Language(grammar.language()))
    return not parser.parse(text.encode()).root_node.has_error


def require_installed(language: str) -> None:
    program = {"c": "cc", "javascript": "node"}.get(language)
    if program is not None and shutil.which(program) is None:
        pytest.skip(f"{program} is not installed")


@pytest.mark.parametrize("language", ["python", "julia", "matlab"])
@pytest.mark.parametrize("case", CASES)
def test_exported_rates_and_loads_are_those_of_the_engine(
    language: str, case: str, tmp_path: Path
) -> None:
    """Law: rates to 1e-12, loads to 1e-13, at rest's neighbours and at jumps of the load."""
    system, drive = CASES[case]
    exported = makers()[language](system, drive, tmp_path)
    for t, y, expected in points(system, drive):
        require_equal(exported.rates(t, y), expected)
        require_loads(exported, drive, t)


@pytest.mark.parametrize("language", ["c", "javascript"])
def test_compiled_rates_and_loads_are_those_of_the_engine(language: str, tmp_path: Path) -> None:
    """The same law, all cases in one library or process."""
    require_installed(language)
    {"c": require_c, "javascript": require_javascript}[language](CASES, tmp_path)


@pytest.mark.parametrize("case", ["actuator", "Prony series", "pair", "steps on an actuator"])
def test_scipy_integrates_the_exported_python(case: str, tmp_path: Path) -> None:
    """Law: DOP853 on the exported rates ends where `simulate` does, within the error of both."""
    system, drive = CASES[case]
    write(rm.export(system, drive, "python"), tmp_path)
    module = runpy.run_path(str(tmp_path / "system.py"))
    y, ends = module["initial"], [0.0, *module["breaks"], 8.0]
    for begin, end in pairwise(ends):
        span = (begin, end * (1.0 - 1e-15))  # the load after a jump is not met before it
        solution = solve_ivp(module["rates"], span, y, method="DOP853", rtol=1e-12, atol=1e-13)
        y = solution.y[:, -1]
    run = rm.simulate(system, drive, times=[0.0, 8.0], tolerance=1e-9)
    for name, value in zip(module["state_names"], y, strict=True):
        assert abs(float(run[name][-1]) - value) < float(run["error"].max()) + 1e-9


@pytest.mark.parametrize("language", ["julia", "matlab"])
@pytest.mark.parametrize("case", ["reserved names", "functions", "heat", "steps on an actuator"])
def test_grammars_accept_the_text(language: str, case: str) -> None:
    """Law: the text is in the language, by its grammar; one without its last parenthesis is not."""
    for name, text in rm.export(*CASES[case], language).items():
        assert is_in_language(language, text), name
        at = text.rindex(")")
        assert not is_in_language(language, text[:at] + text[at + 1 :]), name


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
    write(rm.export(system, drive, "python"), tmp_path)
    module = runpy.run_path(str(tmp_path / "system.py"))
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


def random_cases(count: int) -> dict[str, tuple[Any, Drive]]:
    """Random systems, each under one of the drives."""
    chosen: dict[str, tuple[Any, Drive]] = {}
    all_drives, seed = [*drives().values()], 0
    while len(chosen) < count:
        seed += 1
        drive = all_drives[seed % len(all_drives)]
        try:
            system = random_system(np.random.default_rng(seed))
            rm.rates(system, drive)
        except rm.InputError:
            continue
        chosen[str(seed)] = (system, drive)
    return chosen


@pytest.mark.slow
@pytest.mark.parametrize("language", ["python", "julia", "matlab", "c", "javascript"])
def test_random_systems_are_exported(language: str, tmp_path: Path) -> None:
    """The law of rates and loads, for a hundred random systems."""
    require_installed(language)
    chosen = random_cases(100)
    if language in ("c", "javascript"):
        {"c": require_c, "javascript": require_javascript}[language](chosen, tmp_path)
        return
    for name, (system, drive) in chosen.items():
        exported = makers()[language](system, drive, tmp_path / name)
        for t, y, expected in points(system, drive):
            require_equal(exported.rates(t, y), expected)
            require_loads(exported, drive, t)


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


# AUTO-07p ---------------------------------------------------------------------------------

#: Systems under loads with a period, which AUTO continues.
FORCED: dict[str, tuple[Any, Drive]] = {
    "actuator": (rm.Actuator(dissipation=rm.Rayleigh(0.1)), rm.SineSquared(0.4, 1.25, phase=0.3)),
    "undamped": (rm.Actuator(temperature=350.0), rm.SineSquared(0.4, 1.25)),
    "Zener": (rm.Actuator(dissipation=rm.Zener(0.4, 1.0)), SINE),
    "Duffing": (DUFFING, rm.Sines([0.2, -0.1], [1, 2], 0.7, phases=[0.3, 1.0])),
    "case of names": (
        rm.LagrangianSystem(coordinates="F", kinetic="F_rate**2/2", potential="f*F**2/2 - load*F",
                            dissipation="PAR*F_rate**2/2", parameters={"f": 2.0, "PAR": 0.3}), SINE,
    ),
    "two loads": (TWO_LOADS, rm.Loads({"pressure": rm.Sine(0.1, 1.3),
                                       "voltage": rm.SineSquared(0.3, 2.6, phase=0.1)})),
}  # fmt: skip


def translated_auto(text: str, folder: Path) -> Callable[[FloatArray], FloatArray]:
    """The routines FUNC and STPNT as a function of U."""
    joined = re.sub(r"&\n +", "", text)
    assert max(map(len, text.splitlines())) <= 132
    statements = re.findall(r"^      ([A-Za-z]\w*(?:\(\d+\))?) = (.*)$", joined, re.M)
    start = [
        one for one in statements if re.fullmatch(r"PAR\(\d+\)", one[0]) and "GETP" not in one[1]
    ]
    func = [one for one in statements if not re.match(r"(PAR|FB)\(", one[0])]
    declared = [one.lower() for one in re.findall(r"DOUBLE PRECISION (\w+)$", joined, re.M)]
    assert sorted(declared) == sorted({name.lower() for name, _ in func if "(" not in name})
    body = [f"    {name} = {value}" for name, value in (*start, *func)]
    code = re.sub(r"(\d)D(-?\d)", r"\1e\2", "\n".join(body))
    for name in ("SIN", "COS", "EXP", "LOG", "SQRT", "ATAN"):
        code = code.replace(f"{name}(", f"np.{'arctan' if name == 'ATAN' else name.lower()}(")
    code = re.sub(r"\b(U|PAR|F)\((\d+)\)", r"\1_[\2]", code)
    head = "import numpy as np\ndef over_period(U):\n    PAR_, F_ = {}, {}\n"
    head += "    U_ = dict(enumerate(U, 1))\n"
    write({"translated.py": f"{head}{code}\n    return np.array(list(F_.values()))\n"}, folder)
    return runpy.run_path(str(folder / "translated.py"))["over_period"]  # type: ignore[no-any-return]


@pytest.mark.parametrize("case", FORCED)
def test_equations_for_auto_are_those_of_the_engine(case: str, tmp_path: Path) -> None:
    """Laws: F is the period times the rates at its phase, and the orbit is one, by DOP853."""
    system, drive = FORCED[case]
    files = rm.export(system, drive, "auto07p")
    assert list(files) == ["system.f90", "c.system", "system.dat"]
    over_period = translated_auto(files["system.f90"], tmp_path)
    rates, period = rm.rates(system, drive), drive.period
    assert period is not None
    rng = np.random.default_rng(2)
    rest = lay_out_ensemble(system, drive).initial_states[0]
    for phase in rng.uniform(0.0, 1.0, 4):
        y = rest + rng.uniform(-0.03, 0.05, rest.size)
        found = over_period(np.array([*y, phase]))
        require_equal(found[:-1], period * rates(phase * period, y))
        assert found[-1] == 1.0
    rows = np.array([line.split() for line in files["system.dat"].splitlines()], dtype=float)
    np.testing.assert_array_equal(rows[:, 0], rows[:, -1])
    np.testing.assert_allclose(rows[-1, 1:-1], rows[0, 1:-1], rtol=0.0, atol=1e-7)
    solution = solve_ivp(
        lambda _, u: over_period(u), (0.0, 1.0), rows[0, 1:], method="DOP853", rtol=1e-11,
        atol=1e-12, t_eval=rows[:, 0],
    )  # fmt: skip
    np.testing.assert_allclose(solution.y.T, rows[:, 1:], rtol=0.0, atol=1e-6)


def test_constants_for_auto_fit_the_equations() -> None:
    """Law: dimensions, conditions, parameters and the data file are those of the equations."""
    files = rm.export(*FORCED["actuator"], "auto07p")
    text = re.sub(r"= +", "=", re.sub(r" +=", "=", files["c.system"]))
    for part in ("dat='system'", "NDIM=3,", "IPS=7,", "NBC=3,", "NINT=0", "ICP=[1, 13]",
                 "NPAR=13,", "UZSTOP={1: [0.625, 2.5]}"):  # fmt: skip
        assert part in text
    assert "PAR(1) = omega\n" in files["system.f90"]
    assert 'PAR(13) = GETP("BV0",1,U)' in files["system.f90"]
    assert "TR0" not in text
    assert "SP = ['TR0', 'PD0']" in rm.export(*FORCED["undamped"], "auto07p")["c.system"]


@pytest.mark.parametrize("case", FORCED)
def test_the_grammar_of_fortran_accepts_the_equations(case: str) -> None:
    """Law: the text is in the language, by its grammar."""
    text = rm.export(*FORCED[case], "auto07p")["system.f90"]
    assert is_in_language("fortran", text)
    assert not is_in_language("fortran", text.replace("= U(1)\n", "= U(1\n", 1))


@pytest.mark.parametrize("drive", [rm.Constant(0.1), rm.Steps([0.0, 1.0], [0.1, 0.2])])
def test_loads_without_a_period_are_refused_for_auto(drive: Drive) -> None:
    """AUTO continues orbits, of the period of the load."""
    with pytest.raises(rm.InputError, match="`drive` must have a period"):
        rm.export(DUFFING, drive, "auto07p")


def test_motion_without_an_orbit_is_refused_for_auto() -> None:
    """Where no orbit is found there is none to start from."""
    away = rm.FirstOrderSystem(rates={"x": "1 + x**2 + load"})
    with pytest.raises(rm.InputError, match="periodic orbit that is found"):
        rm.export(away, SINE, "auto07p")
