"""Whole motions: what other tools integrate, from exported equations, ends where ours does."""

from __future__ import annotations

import ctypes
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import remanent as rm
from remanent._typing import FloatArray
from remanent.models.drives.base import Drive
from tests.contracts.exported import CASES, Cases, random_cases, write
from tests.contracts.tools import (
    c_library,
    python_module,
    require_program,
    run_octave,
    run_program,
)

#: How long motions last.
DURATION = 3.0
#: Steps of the classical Runge-Kutta method between jumps of the load: few, and twice as many.
STEPS = (2000, 4000)
#: A time before a jump is this share less: the load after a jump is not met before it.
BEFORE = 1.0 - 2.0**-50
#: Cases of the fast tests.
CHOSEN = {name: CASES[name] for name in ("actuator", "Prony series", "pair", "steps on an actuator",
                                         "Ramp on Duffing", "two loads, samples")}  # fmt: skip


@dataclass(frozen=True)
class Motion:
    """Where a motion ends.

    Attributes
    ----------
    state
        The state at its end.
    error
        By how much it may be wrong.
    """

    state: FloatArray
    error: float

    @property
    def is_known(self) -> bool:
        """Whether it lasts so long, with a small error."""
        return bool(np.isfinite(self.state).all()) and self.error < 1e-8


#: What integrates many cases.
Move = Callable[[Cases, Path], Sequence[Motion]]


def engine_motion(system: Any, drive: Drive, duration: float) -> Motion:
    """The motion from rest by the package; NaN where it does not last so long."""
    run = rm.simulate(system, drive, times=[0.0, duration], tolerance=1e-10)
    names = rm.rates(system, drive).state_names
    state = np.array([float(run[name][-1]) for name in names])
    return Motion(state, float(run["error"].max()))


def lasting(count: int) -> Cases:
    """Random systems that move for as long as is asked, with a known error."""
    known = (
        (name, case)
        for name, case in random_cases(2 * count).items()
        if engine_motion(*case, DURATION).is_known
    )
    return dict(islice(known, count))


def require_motions(chosen: Cases, motions: Sequence[Motion]) -> None:
    """Law: both motions end at the same state, within the errors of both."""
    assert len(motions) == len(chosen) > 0
    for (name, (system, drive)), motion in zip(chosen.items(), motions, strict=True):
        own = engine_motion(system, drive, DURATION)
        scale = max(1.0, float(np.abs(own.state).max()))
        np.testing.assert_allclose(
            motion.state, own.state, rtol=0.0, atol=own.error + motion.error + 1e-9 * scale,
            err_msg=name,
        )  # fmt: skip


def spans(breaks: Sequence[float]) -> list[tuple[float, float]]:
    """Times between which the load is smooth."""
    ends = [0.0, *(one for one in breaks if 0.0 < one < DURATION), DURATION]
    return [(begin, end * BEFORE) for begin, end in pairwise(ends)]


def scipy_motions(chosen: Cases, folder: Path) -> list[Motion]:
    """By DOP853 of SciPy."""
    motions = []
    for name, (system, drive) in chosen.items():
        module = python_module(system, drive, folder / name)
        y = module["initial"]
        for span in spans(module["breaks"]):
            solution = solve_ivp(module["rates"], span, y, method="DOP853", rtol=1e-12, atol=1e-13)
            y = solution.y[:, -1]
        motions.append(Motion(y, 0.0))
    return motions


#: The classical Runge-Kutta method in C.
_C_METHOD = """
typedef void rates_function(double t, const double *y, double *dydt);

void move(rates_function *rates, int count, double begin, double end, int steps, double *y)
{
    const double h = (end - begin)/steps, part[4] = {0.0, 0.5, 0.5, 1.0};
    double k[5][32] = {{0.0}}, at[32];
    for (int step = 0; step < steps; step++) {
        for (int stage = 0; stage < 4; stage++) {
            for (int i = 0; i < count; i++)
                at[i] = y[i] + h*part[stage]*k[stage][i];
            rates(begin + h*(step + part[stage]), at, k[stage + 1]);
        }
        for (int i = 0; i < count; i++) {
            y[i] += h*(k[1][i] + 2.0*k[2][i] + 2.0*k[3][i] + k[4][i])/6.0;
            k[0][i] = 0.0;
        }
    }
}
"""


def c_motions(chosen: Cases, folder: Path) -> list[Motion]:
    """By the classical Runge-Kutta method in C, with two steps."""
    library = c_library(chosen, folder, _C_METHOD)
    motions = []
    for k, (system, drive) in enumerate(chosen.values()):
        module = python_module(system, drive, folder / str(k))
        count = len(module["initial"])
        start = list((ctypes.c_double * count).in_dll(library, f"case_{k}_remanent_initial"))
        rates = getattr(library, f"case_{k}_remanent_rates")
        few, many = (
            _c_motion(library, rates, start, spans(module["breaks"]), steps) for steps in STEPS
        )
        motions.append(_of_two(few, many))
    return motions


def _c_motion(
    library: ctypes.CDLL,
    rates: Any,
    start: Sequence[float],
    between: Sequence[tuple[float, float]],
    steps: int,
) -> FloatArray:
    y = (ctypes.c_double * len(start))(*start)
    for begin, end in between:
        times = ctypes.c_double(begin), ctypes.c_double(end)
        library.move(rates, ctypes.c_int(len(start)), *times, ctypes.c_int(steps), y)
    return np.array(y)


def _of_two(few: FloatArray, many: FloatArray) -> Motion:
    """The motion of many steps; its error is not more than what few change."""
    return Motion(many, float(np.abs(few - many).max()))


#: The same in JavaScript.
_NODE_MOVES = """
import { readFileSync } from "node:fs";

function move(rates, y, begin, end, steps) {
  const h = (end - begin) / steps;
  const moved = (by, k) => y.map((x, i) => x + by * k[i]);
  for (let step = 0; step < steps; step++) {
    const t = begin + h * step;
    const k1 = rates(t, y);
    const k2 = rates(t + h / 2, moved(h / 2, k1));
    const k3 = rates(t + h / 2, moved(h / 2, k2));
    const k4 = rates(t + h, moved(h, k3));
    y = y.map((x, i) => x + h * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]) / 6);
  }
  return y;
}

const given = JSON.parse(readFileSync("cases.json", "utf8"));
const answers = [];
for (let k = 0; k < given.count; k++) {
  const system = await import(`./case_${k}.mjs`);
  const inner = system.breaks.filter((t) => t > 0 && t < given.duration);
  const ends = [0, ...inner, given.duration];
  answers.push(given.steps.map((steps) => {
    let y = system.initial;
    for (let i = 1; i < ends.length; i++) {
      y = move(system.rates, y, ends[i - 1], ends[i] * given.before, steps);
    }
    return y.map(String);
  }));
}
console.log(JSON.stringify(answers));
"""


def node_motions(chosen: Cases, folder: Path) -> list[Motion]:
    """By the classical Runge-Kutta method in JavaScript, with two steps."""
    node = require_program("node")
    for k, case in enumerate(chosen.values()):
        write({f"case_{k}.mjs": rm.export(*case, "javascript")["system.js"]}, folder)
    given = {"count": len(chosen), "duration": DURATION, "steps": STEPS, "before": BEFORE}
    write({"move.mjs": _NODE_MOVES, "cases.json": json.dumps(given)}, folder)
    answers = json.loads(run_program([node, "move.mjs"], folder))
    return [_of_two(*(np.array(y, dtype=float) for y in one)) for one in answers]


#: Runs the script of each folder, and writes where it ends.
_OCTAVE_RUNS = """
1;
function [t, y] = run_here()
  remanent_run
end

top = pwd();
for k = 0:{last}
  cd(fullfile(top, num2str(k)));
  clear -f remanent_run remanent_rates remanent_parameters remanent_pieces
  [t, y] = run_here();
  answer = fopen("answer.txt", "w");
  fprintf(answer, "%.17g ", t(end), y(end, :));
  fclose(answer);
end
"""


def require_script(chosen: Cases, folder: Path) -> None:
    """Law: the script for ode45, run by Octave, ends where `simulate` does, to 1e-7."""
    for k, case in enumerate(chosen.values()):
        write(rm.export(*case, "matlab"), folder / str(k))
    write({"run_all.m": _OCTAVE_RUNS.format(last=len(chosen) - 1)}, folder)
    run_octave("run_all.m", folder)
    for k, (name, case) in enumerate(chosen.items()):
        t, *y = map(float, (folder / f"{k}/answer.txt").read_text().split())
        own = engine_motion(*case, t)
        tolerance = own.error + 1e-7 * max(1.0, float(np.abs(own.state).max()))
        np.testing.assert_allclose(y, own.state, rtol=0.0, atol=tolerance, err_msg=name)


MOVE: Mapping[str, Move] = {"SciPy": scipy_motions, "C": c_motions, "JavaScript": node_motions}


@pytest.mark.parametrize("tool", MOVE)
def test_other_tools_move_as_the_engine_does(tool: str, tmp_path: Path) -> None:
    """Law: exported equations, integrated by another tool, end where `simulate` does."""
    require_motions(CHOSEN, MOVE[tool](CHOSEN, tmp_path))


@pytest.mark.slow
@pytest.mark.parametrize("tool", MOVE)
def test_random_systems_move_as_the_engine_does(tool: str, tmp_path: Path) -> None:
    """The same law, for a hundred random systems."""
    chosen = lasting(100)
    assert len(chosen) == 100
    require_motions(chosen, MOVE[tool](chosen, tmp_path))


def test_octave_runs_the_script(tmp_path: Path) -> None:
    """Law: `remanent_run` in Octave ends where `simulate` does."""
    names = ("two loads, samples", "two samples on Duffing", "steps on an actuator")
    require_script({name: CASES[name] for name in names}, tmp_path)


@pytest.mark.slow
def test_octave_runs_the_script_under_every_load(tmp_path: Path) -> None:
    """The same law, for drives of every kind and for systems of every kind."""
    kinds = ("actuator", "Prony series", "heat", "pair", "reserved names", "functions", "of Gent")
    chosen = {
        name: case for name, case in CASES.items()
        if name in kinds or name.endswith("on Duffing") or name.startswith("two loads")
    }  # fmt: skip
    require_script(chosen, tmp_path)
