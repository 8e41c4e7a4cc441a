"""Tools that run exported equations: Python, C, Node and Octave; Julia's text is translated."""

from __future__ import annotations

import ctypes
import json
import os
import re
import runpy
import shutil
import subprocess
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import remanent as rm
from remanent._typing import FloatArray
from remanent.models.drives.base import Drive
from tests.contracts.exported import Answer, Cases, load_names, points, write

#: What answers for many cases: rates and loads at each of their points.
Ask = Callable[[Cases, Path], Sequence[Sequence[Answer]]]


def require_program(*names: str) -> str:
    """The path of the first of some programs; the test is skipped where none is installed."""
    found = next(filter(None, map(shutil.which, names)), None)
    if found is None:
        pytest.skip(f"{' or '.join(names)} is not installed")
    return found


def run_program(command: list[str], folder: Path, **further: str) -> str:
    """What a program writes; the test fails with all of it where the program does."""
    alone = {"OMP_NUM_THREADS": "1"}  # threads that wait for each other are slow on a busy machine
    done = subprocess.run(
        command, cwd=folder, env=os.environ | alone | further, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def asked(
    drive: Drive, system: Any, rates: Callable[..., Any], loads: Mapping[str, Callable[..., Any]]
) -> list[Answer]:
    """What functions of Python answer."""
    return [
        (list(rates(t, y)), [float(loads[name](t)) for name in drive.load_names])
        for t, y, _ in points(system, drive)
    ]


# Python ----------------------------------------------------------------------------------


def python_module(system: Any, drive: Drive, folder: Path) -> dict[str, Any]:
    """The names of the exported module."""
    write(rm.export(system, drive, "python"), folder)
    return runpy.run_path(str(folder / "system.py"))


def python_answers(chosen: Cases, folder: Path) -> list[list[Answer]]:
    """Rates and loads by modules of Python."""
    answers = []
    for k, (system, drive) in enumerate(chosen.values()):
        module = python_module(system, drive, folder / str(k))
        assert list(module["initial"].shape) == [len(module["state_names"])]
        loads = {name: module[function] for name, function in load_names(drive).items()}
        answers.append(asked(drive, system, module["rates"], loads))
    return answers


# C -----------------------------------------------------------------------------------------

#: Names of a file in C, which get a number where many files are one library.
C_NAMES = [
    *("pieces", "piece_at", "remanent_load", "remanent_load_pressure", "remanent_load_voltage"),
    *(f"remanent_{name}" for name in ("rates", "initial", "state_names", "parameters", "breaks")),
]
#: A type of C.
_ROW = ctypes.POINTER(ctypes.c_double)


def c_library(chosen: Cases, folder: Path, further: str = "") -> ctypes.CDLL:
    """One library with the files of all cases, and a `further` text."""
    compiler, text = require_program("cc"), [further]
    for k, (system, drive) in enumerate(chosen.values()):
        write({f"system_{k}.c": rm.export(system, drive, "c")["system.c"]}, folder)
        text += [f"#define {name} case_{k}_{name}" for name in C_NAMES]
        text += [f'#include "system_{k}.c"', "#undef REMANENT_STATES"]
        text += [f"#undef {name}" for name in C_NAMES]
    write({"all.c": "\n".join(text) + "\n"}, folder)
    library = folder / "all.so"
    command = [compiler, "-std=c99", "-O0", "-Wall", "-Wextra", "-Werror", "-pedantic", "-fPIC",
               "-shared", "-ffp-contract=off", "all.c", "-o", str(library), "-lm"]  # fmt: skip
    run_program(command, folder)
    return ctypes.CDLL(str(library))


def c_answers(chosen: Cases, folder: Path) -> list[list[Answer]]:
    """Rates and loads by functions of C, compiled without a warning."""
    library, answers = c_library(chosen, folder), []
    for k, (system, drive) in enumerate(chosen.values()):
        start = f"case_{k}_remanent_"
        loads = {name: _c_load(library, start + f) for name, f in load_names(drive).items()}
        answers.append(asked(drive, system, _c_rates(library, f"{start}rates"), loads))
    return answers


def _c_load(library: ctypes.CDLL, name: str) -> Callable[[float], float]:
    function = getattr(library, name)
    function.argtypes, function.restype = [ctypes.c_double], ctypes.c_double
    return function  # type: ignore[no-any-return]


def _c_rates(library: ctypes.CDLL, name: str) -> Callable[[float, FloatArray], list[float]]:
    function = getattr(library, name)
    function.argtypes, function.restype = [ctypes.c_double, _ROW, _ROW], None

    def rates(t: float, y: FloatArray) -> list[float]:
        array = ctypes.c_double * len(y)
        result = array()
        function(t, array(*y), result)
        return list(result)

    return rates


# JavaScript --------------------------------------------------------------------------------

#: Reads cases from a file, and writes what the module of each says.
_NODE_ASKS = """
import { readFileSync } from "node:fs";
const answers = [];
for (const one of JSON.parse(readFileSync(process.argv[2], "utf8"))) {
  const module = await import(one.path);
  answers.push(one.points.map(([t, y]) => [
    module.rates(t, y).map(String), one.loads.map((name) => String(module[name](t)))]));
}
console.log(JSON.stringify(answers));
"""


def javascript_questions(chosen: Cases) -> list[dict[str, Any]]:
    """The text of each module, the points, and the names of the loads."""
    return [
        {
            "text": rm.export(system, drive, "javascript")["system.js"],
            "points": [(t, y.tolist()) for t, y, _ in points(system, drive)],
            "loads": [*load_names(drive).values()],
        }
        for system, drive in chosen.values()
    ]


def as_numbers(answers: Any) -> list[list[Answer]]:
    """Answers in texts as numbers."""
    return [
        [(list(map(float, rates)), list(map(float, loads))) for rates, loads in one]
        for one in answers
    ]


def node_answers(chosen: Cases, folder: Path) -> list[list[Answer]]:
    """Rates and loads by modules of JavaScript, in one process of Node."""
    node, given = require_program("node"), []
    for k, question in enumerate(javascript_questions(chosen)):
        write({f"case_{k}.mjs": question.pop("text")}, folder)
        given.append({"path": str(folder / f"case_{k}.mjs"), **question})
    write({"ask.mjs": _NODE_ASKS, "cases.json": json.dumps(given)}, folder)
    return as_numbers(json.loads(run_program([node, "ask.mjs", "cases.json"], folder)))


#: The same in a page, where a module is taken from its text.
_PAGE_ASKS = """
async (given) => {
  const answers = [];
  for (const one of given) {
    const text = new Blob([one.text], { type: "text/javascript" });
    const module = await import(URL.createObjectURL(text));
    answers.push(one.points.map(([t, y]) => [
      module.rates(t, y).map(String), one.loads.map((name) => String(module[name](t)))]));
  }
  return answers;
}
"""


def browser_answers(chosen: Cases, _folder: Path) -> list[list[Answer]]:
    """Rates and loads by modules of JavaScript, in one page of Chromium."""
    program = require_program("chromium", "chromium-browser", "google-chrome")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        page = browser.new_page()
        try:
            return as_numbers(page.evaluate(_PAGE_ASKS, javascript_questions(chosen)))
        finally:
            browser.close()


# Octave ------------------------------------------------------------------------------------

#: Rates and loads by the functions of many folders, into a file in each.
_OCTAVE_ASKS = """
top = pwd();
for k = 0:{last}
  cd(fullfile(top, num2str(k)));
  clear -f
  loads = strsplit(strtrim(fileread("loads.txt")), "\\n");
  answers = fopen("answers.txt", "w");
  for row = dlmread("points.txt", " ").'
    fprintf(answers, "%.17g ", remanent_rates(row(1), row(2:end)));
    fprintf(answers, "%.17g ", cellfun(@(name) feval(name, row(1)), loads));
    fprintf(answers, "\\n");
  end
  fclose(answers);
end
"""


def run_octave(script: str, folder: Path) -> str:
    """What a script writes, without settings of one's own and without a screen."""
    octave = require_program("octave-cli", "octave")
    return run_program([octave, "--norc", "--no-history", "--no-window-system", script], folder)


def octave_answers(chosen: Cases, folder: Path) -> list[list[Answer]]:
    """Rates and loads by functions of MATLAB, in one process of Octave."""
    for k, (system, drive) in enumerate(chosen.values()):
        rows = (" ".join(map(repr, [t, *map(float, y)])) for t, y, _ in points(system, drive))
        names = (f"remanent_{name}" for name in load_names(drive).values())
        texts = {"points.txt": "\n".join(rows) + "\n", "loads.txt": "\n".join(names) + "\n"}
        write(rm.export(system, drive, "matlab") | texts, folder / str(k))
    write({"ask.m": _OCTAVE_ASKS.format(last=len(chosen) - 1)}, folder)
    run_octave("ask.m", folder)
    return [
        [_split(line, drive) for line in (folder / f"{k}/answers.txt").read_text().splitlines()]
        for k, (_, drive) in enumerate(chosen.values())
    ]


def _split(line: str, drive: Drive) -> Answer:
    """Rates and loads in one line."""
    numbers, loads = [*map(float, line.split())], len(drive.load_names)
    return numbers[:-loads], numbers[-loads:]


# Julia, translated to Python ---------------------------------------------------------------

#: Before a text that was translated.
_PROLOGUE = """
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


def _translated(text: str) -> str:
    """Functions of Julia as functions of Python."""
    text = re.sub(r"^real_\w+\(x\) = .*$", "", text, flags=re.M)
    text = text.replace("const parameters = NamedTuple()", "parameters = SimpleNamespace()")
    text = text.replace("const parameters = (", "parameters = SimpleNamespace(")
    text = re.sub(r"const pieces = (\[.*?^\])", r"pieces = Rows(\1)", text, flags=re.S | re.M)
    text = re.sub(r"const (\w+) = (?:Float64)?", r"\1 = ", text)
    text = text.replace("piece_starts = [row[1] for", "piece_starts = [row[0] for")
    text = re.sub(r"^function (\w+)!?(.*)$", r"def \1\2:", text, flags=re.M)
    return re.sub(r"^end$", "", text, flags=re.M).replace("return nothing", "return dydt")


def julia_answers(chosen: Cases, folder: Path) -> list[list[Answer]]:
    """Rates and loads by what the text in Julia says, as far as its statements go."""
    answers = []
    for k, (system, drive) in enumerate(chosen.values()):
        text = rm.export(system, drive, "julia")["system.jl"]
        write({"translated.py": _PROLOGUE + _translated(text)}, folder / str(k))
        with np.errstate(all="ignore"):
            module = runpy.run_path(str(folder / f"{k}/translated.py"))
            answers.append(asked(drive, system, _julia_rates(module), _julia_loads(module, drive)))
    return answers


def _julia_rates(module: Mapping[str, Any]) -> Callable[[float, FloatArray], list[float]]:
    one_based, p = module["OneBased"], module["parameters"]
    return lambda t, y: list(module["rates"](one_based([0.0] * len(y)), one_based(y), p, t))


def _julia_loads(module: Mapping[str, Any], drive: Drive) -> dict[str, Callable[[float], float]]:
    p = module["parameters"]
    return {
        name: partial(lambda of, t: float(of(t, p)), module[function])
        for name, function in load_names(drive).items()
    }


#: Who answers, by the name of the tool.
ASK: Mapping[str, Ask] = {
    "Python": python_answers,
    "C": c_answers,
    "Node": node_answers,
    "Chromium": browser_answers,
    "Octave": octave_answers,
    "Julia, translated": julia_answers,
}
