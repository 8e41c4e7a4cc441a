"""AUTO-07p itself, with exported files: its orbits are those of the engine, and its folds."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import remanent as rm
from remanent.models.drives.base import Drive
from tests.contracts.auto07p import FORCED, exported
from tests.contracts.exported import Cases, random_actuator, write
from tests.contracts.tools import require_program, run_program
from tests.repetitions import fast_and_slow

#: Response of a damped actuator to this load turns back twice.
FOLDING = rm.Actuator(dissipation=rm.Rayleigh(0.05)), rm.SineSquared(0.4, 1.1, phase=0.3)
#: What is typed in AUTO, and what is found written down.
_CONTINUE = """
import json

found = []
for given in {given!r}:
    for solution in run("system", **given)():
        u = [float(row[0]) for row in solution.coordarray[:-1]]
        found.append([solution["TY"], float(solution["PAR(1)"]), u])
with open("found.json", "w") as file:
    json.dump(found, file)
"""


@dataclass(frozen=True)
class Solution:
    """A solution that AUTO found.

    Attributes
    ----------
    kind
        AUTO's name of its kind: ``"LP"`` is a fold.
    omega
        The frequency of the load.
    state
        At phase 0.
    """

    kind: str
    omega: float
    state: list[float]


def continued(
    files: Mapping[str, str], folder: Path, given: Sequence[dict[str, Any]] = ({},)
) -> list[Solution]:
    """Solutions of AUTO with the exported files, for each of some settings."""
    auto = require_program("auto-07p", "auto")
    require_program("gfortran")
    write(files, folder)
    write({"continue.auto": _CONTINUE.format(given=[*given])}, folder)
    run_program([auto, "continue.auto"], folder)
    found = json.loads((folder / "found.json").read_text())
    return [Solution(*one) for one in found]


def at_frequency(drive: Drive, omega: float) -> Drive:
    """The drive with another frequency; those of several loads keep their ratio."""
    if not isinstance(drive, rm.Loads):
        return drive.replace(omega=omega)
    loads = dict(drive.drives)
    ratio = omega / next(iter(loads.values())).omega  # type: ignore[attr-defined]
    return rm.Loads({k: one.replace(omega=ratio * one.omega) for k, one in loads.items()})  # type: ignore[attr-defined]


def require_orbits(case: tuple[Any, Drive], solutions: Sequence[Solution]) -> None:
    """Law: each solution is an orbit of the engine: a period later it is where it was, to 1e-6."""
    system, drive = case
    assert solutions
    for one in solutions:
        slower = at_frequency(drive, one.omega)
        run = rm.simulate(system, slower, periods=1, initial=one.state, tolerance=1e-9)
        names = rm.rates(system, slower).state_names
        ends = [float(run[name][-1]) for name in names]
        np.testing.assert_allclose(ends, one.state, rtol=0.0, atol=1e-6, err_msg=str(one))


def require_folds(case: tuple[Any, Drive], solutions: Sequence[Solution]) -> int:
    """Law: where AUTO has a fold there is one of ours, within 1e-6; the number of folds."""
    system, drive = case
    folds = [one for one in solutions if one.kind == "LP"]
    for one in folds:
        near = at_frequency(drive, one.omega)
        own = rm.locate_bifurcation(system, near, "fold", "omega", initial=one.state)
        assert abs(float(own.omega) - one.omega) < 1e-6
    return len(folds)


@pytest.mark.slow
def test_auto_finds_the_folds(tmp_path: Path) -> None:
    """Law: folds of a damped actuator are those of `continue_orbit`, within 1e-6."""
    solutions = continued(rm.export(*FOLDING, "auto07p"), tmp_path)
    assert require_folds(FOLDING, solutions) == 2
    require_orbits(FOLDING, solutions)
    branch = rm.continue_orbit(
        *FOLDING, "omega", (1.05, 1.3), initial=solutions[0].state, tolerance=1e-9
    )
    own = branch.special_omega.values[branch.special_kind.values == "fold"]
    seen = [one.omega for one in solutions if one.kind == "LP"]
    np.testing.assert_allclose(np.sort(seen), np.sort(own), rtol=0.0, atol=1e-6)


@pytest.mark.parametrize(
    "case", fast_and_slow(list(FORCED), ("Zener", "two loads", "case of names"))
)
def test_auto_continues_orbits(case: str, tmp_path: Path) -> None:
    """Law: what AUTO finds from the exported files are orbits of the engine."""
    solutions = continued(exported(case), tmp_path, [{"NMX": 9, "NPR": 3}])
    assert len(solutions) >= 4
    require_orbits(FORCED[case], solutions)


def test_the_command_of_auto_runs_the_files(tmp_path: Path) -> None:
    """Law: `@r system` in their folder goes along the branch to twice the frequency."""
    require_program("auto-07p")
    require_program("gfortran")
    require_program("make")
    folder = os.environ.get("AUTO_DIR", "/usr/lib/auto-07p")
    write(exported("actuator"), tmp_path)
    path = os.pathsep.join([os.environ["PATH"], f"{folder}/cmds"])
    run_program(["sh", "-c", "@r system"], tmp_path, AUTO_DIR=folder, PATH=path)
    last = (tmp_path / "fort.7").read_text().splitlines()[-1].split()
    assert int(last[2]) == -4  # where UZSTOP ends it
    assert float(last[4]) == pytest.approx(2.5, abs=1e-6)


def random_forced(count: int) -> Cases:
    """Random actuators with losses under loads of every kind that have a period."""
    chosen = {}
    for seed in range(count):
        rng = np.random.default_rng(seed)
        m, omega, phase = rng.uniform((0.05, 0.8, 0.0), (0.4, 1.2, 3.0))
        forced = [
            rm.SineSquared(2.0 * m, omega, phase=phase),
            rm.Sine(m, omega, mean=0.05, phase=phase),
            rm.Sines([m, 0.05], [1, 2], omega, phases=[phase, 1.0]),
        ]
        losses = rm.Rayleigh(rng.uniform(0.02, 0.1))
        chosen[str(seed)] = (random_actuator(rng).replace(dissipation=losses), forced[seed % 3])
    return chosen


@pytest.mark.slow
def test_auto_continues_orbits_of_random_systems(tmp_path: Path) -> None:
    """Laws: what AUTO finds of a hundred random actuators are orbits, and their folds ours."""
    folds = 0
    for name, case in random_forced(100).items():
        ways: list[dict[str, Any]] = [{"NMX": 150}, {"NMX": 20, "DS": "-"}]
        solutions = continued(rm.export(*case, "auto07p"), tmp_path / name, ways)
        require_orbits(case, solutions)
        folds += require_folds(case, solutions)
    assert folds > 20
