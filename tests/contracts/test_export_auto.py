"""Files for AUTO-07p say what the engine does: routines as they are compiled, constants, orbit."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np
import pytest
import tree_sitter
import tree_sitter_fortran
from scipy.integrate import solve_ivp

import remanent as rm
from remanent._load_schedule import LoadSchedule
from remanent._typing import ArrayLike, FloatArray
from remanent.models.drives.base import Drive, Waveform, periodic_load_schedule
from remanent.studies.export import export as export_module
from tests.contracts.auto07p import FORCED, compiled, exported
from tests.contracts.exported import (
    SINE,
    random_cases,
    random_state,
    require_equal,
)
from tests.faults.own_systems import DUFFING


def require_rates(system: Any, drive: Drive, text: str, folder: Path) -> None:
    """Law: F is the period times the rates at its phase, to 1e-12; 1e30 where they are infinite."""
    rates, period = rm.rates(system, drive), drive.period
    assert period is not None
    rng = np.random.default_rng(2)
    file = compiled(text, len(rates.state_names) + 1, folder)
    for phase in [0.0, *rng.uniform(0.0, 1.0, 4)]:
        y = random_state(system, drive, rng)
        found = file.over_period(np.array([*y, phase]))
        expected = period * rates(phase * period, y)
        known = np.abs(expected) < 1e30
        require_equal(found[:-1][known], expected[known], str(folder))
        assert (found[:-1][~known] == 1e30).all()
        assert found[-1] == 1.0


@pytest.mark.parametrize("case", FORCED)
def test_equations_for_auto_are_those_of_the_engine(case: str, tmp_path: Path) -> None:
    """Law: F is the period times the rates at its phase, to 1e-12."""
    files = exported(case)
    assert list(files) == ["system.f90", "c.system", "system.dat"]
    assert max(map(len, files["system.f90"].splitlines())) <= 132
    require_rates(*FORCED[case], files["system.f90"], tmp_path)


@pytest.mark.parametrize("case", FORCED)
def test_orbits_for_auto_are_orbits(case: str, tmp_path: Path) -> None:
    """Law: the orbit ends where it begins, as boundary values ask, and is a motion, by DOP853."""
    files = exported(case)
    rows = np.array([line.split() for line in files["system.dat"].splitlines()], dtype=float)
    file = compiled(files["system.f90"], rows.shape[1] - 1, tmp_path)
    np.testing.assert_array_equal(rows[:, 0], rows[:, -1])
    ends = file.boundary_values(rows[0, 1:], rows[-1, 1:])
    np.testing.assert_allclose(ends, 0.0, rtol=0.0, atol=1e-7)
    solution = solve_ivp(
        lambda _, u: file.over_period(u), (0.0, 1.0), rows[0, 1:], method="DOP853", rtol=1e-11,
        atol=1e-12, t_eval=rows[:, 0],
    )  # fmt: skip
    np.testing.assert_allclose(solution.y.T, rows[:, 1:], rtol=0.0, atol=1e-6)


def test_auto_is_told_where_rates_do_not_exist(tmp_path: Path) -> None:
    """Law: F is 1e30 there, and not NaN, which AUTO takes for converged."""
    system = rm.FirstOrderSystem(rates={"x": "1 - sqrt(x) + load", "y": "x - y"}, rest={"x": 1.0})
    file = compiled(rm.export(system, SINE, "auto07p")["system.f90"], 3, tmp_path)
    np.testing.assert_array_equal(file.over_period(np.array([-0.5, 0.0, 0.2]))[[0, 2]], [1e30, 1.0])
    assert np.abs(file.over_period(np.array([0.5, 0.0, 0.2]))).max() < 10.0


@pytest.mark.slow
def test_random_systems_are_exported_to_auto(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The law of rates, for a hundred random systems under loads with a period.

    Most of them have no orbit, which their equations do not need.
    """
    monkeypatch.setattr(export_module, "_starting_orbit", _no_orbit)
    cases = random_cases(300).items()
    forced = dict(islice(((k, one) for k, one in cases if one[1].period is not None), 100))
    assert len(forced) == 100
    for name, (system, drive) in forced.items():
        text = rm.export(system, drive, "auto07p")["system.f90"]
        require_rates(system, drive, text, tmp_path / name)


def _no_orbit(ens: Any) -> tuple[FloatArray, FloatArray, bool]:
    return np.zeros(2), np.zeros((2, ens.initial_states.shape[1])), False


def test_constants_for_auto_fit_the_equations() -> None:
    """Law: dimensions, conditions, parameters and the data file are those of the equations."""
    files = exported("actuator")
    text = re.sub(r"= +", "=", re.sub(r" +=", "=", files["c.system"]))
    for part in ("dat='system'", "NDIM=3,", "IPS=7,", "NBC=3,", "NINT=0", "ICP=[1, 14]",
                 "NPAR=14,", "UZSTOP={1: [0.625, 2.5]}"):  # fmt: skip
        assert part in text
    assert "PAR(1) = omega\n" in files["system.f90"]
    assert 'PAR(14) = GETP("BV0",1,U)' in files["system.f90"]
    assert "TR0" not in text
    assert "SP = ['TR0', 'PD0']" in exported("undamped")["c.system"]


def test_parameters_are_not_where_auto_writes() -> None:
    """Law: PAR(10), the period PAR(11) and the angle of a torus PAR(12) hold no parameters."""
    text = exported("actuator")["system.f90"]
    indices = {int(k) for k in re.findall(r"PAR\((\d+)\) = ", text)}
    assert indices == {*range(1, 10), 13, 14}


@pytest.mark.parametrize("case", FORCED)
def test_the_grammar_of_fortran_accepts_the_equations(case: str) -> None:
    """Law: the text is in the language, by its grammar."""
    parser = tree_sitter.Parser(tree_sitter.Language(tree_sitter_fortran.language()))
    text = exported(case)["system.f90"]
    assert not parser.parse(text.encode()).root_node.has_error
    broken = text.replace("= U(1)\n", "= U(1\n", 1)
    assert parser.parse(broken.encode()).root_node.has_error


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


@dataclass(frozen=True)
class Clock(Drive):
    """A load with a period that no number changes."""

    waveform_names: ClassVar[tuple[str, ...]] = ("sine",)
    waveforms: ClassVar[tuple[Waveform, ...]] = (Waveform("sin", 2.0 * np.pi),)

    @classmethod
    def example(cls) -> Self:
        return cls()

    def __call__(self, tau: ArrayLike) -> FloatArray:
        return np.asarray(np.sin(2.0 * np.pi * np.asarray(tau)))

    def load(self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any) -> Any:
        return u["sine"]

    def periods(self, values: Mapping[str, FloatArray]) -> FloatArray:
        return np.asarray(1.0)

    def load_schedule(self, values: Mapping[str, FloatArray], duration: FloatArray) -> LoadSchedule:
        return periodic_load_schedule(self.periods(values), duration, lambda s: self(s)[np.newaxis])


def test_auto_needs_something_to_vary(tmp_path: Path) -> None:
    """Law: a parameter will do where the load has no frequency; without any it is refused."""
    system = rm.LagrangianSystem(
        coordinates="x", kinetic="x_rate**2/2", potential="x**2/2 - load*x",
        dissipation="0.2*x_rate**2",
    )  # fmt: skip
    with pytest.raises(rm.InputError, match="`system` must have a parameter"):
        rm.export(system, Clock(), "auto07p")
    varied = system.replace(potential="k*x**2/2 - load*x", parameters={"k": 1.0})
    require_rates(varied, Clock(), rm.export(varied, Clock(), "auto07p")["system.f90"], tmp_path)
