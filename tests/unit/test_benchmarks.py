"""What the benchmarks count and judge, without timing anything."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from benchmarks import targets
from benchmarks.__main__ import missing_peers
from benchmarks.accuracy import cheapest
from benchmarks.jobs import FILM, JOBS, RESPONSE, Job
from benchmarks.machine_code import assembly, work_per_pass
from benchmarks.multiply_add import CHAINS, source
from benchmarks.reference import Reference
from benchmarks.targets import TARGETS, Verdict, verdicts
from benchmarks.tools import double_well, heyoka_batch, ours, scipy_dop853
from benchmarks.tools.tool import TOLERANCES, Answer, Run
from remanent.integrate.ensemble.problem import Request
from remanent.integrate.ensemble.resolution import choose_method
from remanent.integrate.kernel.compile import TargetProcessor, host_processor
from remanent.integrate.kernel.options import KernelOptions

RESULTS = sorted((Path(__file__).parents[2] / "benchmarks" / "results").glob("*.json"))

NESTED = """
kernel:
\tvmulpd\t%zmm1, %zmm1, %zmm1
.outer:
\tvaddpd\t%zmm1, %zmm1, %zmm1
.inner:
\tvfmadd231pd\t%zmm1, %zmm2, %zmm3
\tvsubpd\t(%rdi), %zmm1, %zmm1
\tje\t.always
\tvdivpd\t%zmm1, %zmm1, %zmm1
.always:
\tvmulpd\t%ymm1, %ymm1, %ymm1
\tjne\t.inner
\tjne\t.outer
\tretq
"""


def test_only_what_every_pass_of_the_inner_loop_does_counts() -> None:
    """Neither the loop around, nor the branch that may be skipped; lanes by register size.

    Law: what is done in every pass are the blocks that dominate the jump back.
    """
    assert work_per_pass(NESTED) == {"fma": 8, "add": 8, "mul": 4}


PROCESSORS = {
    "znver4": "+avx,+avx2,+fma,+avx512f,+avx512vl",
    "skylake-avx512": "+avx,+avx2,+fma,+avx512f,+avx512vl",
    "haswell": "+avx,+avx2,+fma",
}
TARGETS_X86 = [TargetProcessor("x86_64-unknown-linux-gnu", *item) for item in PROCESSORS.items()]
x86 = pytest.mark.skipif(
    not host_processor().triple.startswith("x86_64"),
    reason="LLVM makes code for its own processor only",
)


@x86
@pytest.mark.parametrize("target", TARGETS_X86, ids=lambda target: target.cpu)
def test_the_yardstick_is_one_multiply_add_per_chain(target: TargetProcessor) -> None:
    """A pass is one multiply-add of each chain and lane, however often LLVM would unroll it."""
    work = work_per_pass(assembly(source(target.lane_count), target))
    assert work == {"fma": CHAINS * target.lane_count}


@x86
def test_operations_of_a_step_do_not_depend_on_the_processor() -> None:
    """Per lane a kernel does the same arithmetic on processors of one vector width."""
    method = choose_method(Request(wants_extremes=True), 1e-9)
    field = ours.response_problem(RESPONSE, RESPONSE.omegas[:1]).field
    counts = [
        work_per_pass(
            assembly(
                target.kernel_source(field, method, KernelOptions(follows_extremes=True)), target
            )
        )
        for target in TARGETS_X86[:2]
    ]
    assert counts[0] == counts[1]
    assert counts[0]["fma"] > 10 * TARGETS_X86[0].lane_count


@pytest.mark.parametrize("job", JOBS.values(), ids=lambda job: job.name)
def test_acceleration_is_equation_16(job: Job) -> None:
    """The form with one division equals the equation as [Thermal, eq. 16] has it.

    Law: multiplying numerator and denominator by x⁷ changes nothing.
    """
    rng = np.random.default_rng(16)
    m, x, v = rng.uniform(0, 1, 99), rng.uniform(0.5, 2, 99), rng.uniform(-2, 2, 99)
    force = job.theta * (x - x**-5) - job.prestress + m * x**-3
    expected = (6 * job.c * x**-7 * v**2 - 3 * force) / (1 + 2 * job.c * x**-6)
    np.testing.assert_allclose(job.acceleration(m, x, v), expected, rtol=1e-12, atol=1e-12)


def test_errors_leave_out_what_nobody_resolves_and_show_what_has_no_value() -> None:
    """Unresolved motions are left out; a missing value stays NaN, and the worst value counts."""
    truth = Reference({"extremes": np.zeros((3, 2))}, np.array([True, False, True]))
    error = truth.error("extremes", np.array([[2.0, -3.0], [9.0, 9.0], [np.nan, 1.0]]))
    np.testing.assert_array_equal(error, [3.0, np.nan])


def test_the_double_well_is_the_same_for_heyoka() -> None:
    """A motion for one drive period, and the exponent of regular motion, as ours has them."""
    pytest.importorskip("heyoka")
    omega, m = np.array([0.9, 1.3]), np.array([0.06, 0.05])
    well = rm.LagrangianSystem.example().replace(
        parameters={"delta": double_well.DELTA}, rest={"x": double_well.REST[0]}
    )
    over = {"omega": xr.DataArray(omega, dims="case"), "m": xr.DataArray(m, dims="case")}
    drive = rm.Sine(0.05, 1.0, phase=np.pi / 2.0)
    form = heyoka_batch.FORMS[0]
    states = double_well.heyoka_ends(form)(
        omega, m, np.tile(double_well.REST, (2, 1)), 2.0 * np.pi / omega, 1e-15
    )
    section = rm.poincare_section(well, drive, periods=1, over=over).isel(period=1)
    ours = np.column_stack([section.x, section.x_rate])
    assert (np.abs(states - ours).max(axis=1) <= section.error.values + 1e-13).all()
    # Motion spirals into an orbit: by Liouville's formula both exponents are -delta/2.
    exponents = double_well.heyoka_exponents(form)(omega, m, 2000, 1e-12)
    np.testing.assert_allclose(exponents, -double_well.DELTA / 2.0, rtol=0.0, atol=5e-4)


def test_the_cosine_of_twice_the_frequency_is_the_squared_sine() -> None:
    """Law: (b sin ωτ)² = ½ b² (1 − cos 2ωτ), as heyoka.py evaluates it."""
    hy = pytest.importorskip("heyoka")
    rng = np.random.default_rng(2)
    omega, tau = rng.uniform(0.5, 4.0, 99), rng.uniform(0.0, 100.0, 99)
    function = hy.cfunc([heyoka_batch.sine_squared(0.9)], [])
    values = function(np.empty((0, 99)), pars=omega[None], time=tau)[0]
    np.testing.assert_allclose(values, (0.9 * np.sin(omega * tau)) ** 2, atol=1e-12)


@pytest.mark.parametrize("compact", [False, True])
def test_both_forms_of_the_load_give_heyoka_one_trajectory(compact: bool) -> None:
    """The fast form of the peer ends where [Thermal, eq. 16] as it stands does, to 1e-12."""
    hy = pytest.importorskip("heyoka")
    omegas = np.linspace(RESPONSE.low, RESPONSE.high, 8)
    wave = RESPONSE.b * hy.sin(hy.par[0] * hy.time)
    form = heyoka_batch.Form(8, compact)
    ends = []
    for load in (wave * wave, heyoka_batch.sine_squared(RESPONSE.b)):
        _, system = heyoka_batch.equations(RESPONSE, load)
        ta = heyoka_batch.batch_integrator(system, [1.0, 0.0], 1e-13, form)
        ta.pars[0] = omegas
        ta.propagate_until([RESPONSE.window] * 8)
        ends.append(ta.state.copy())
    np.testing.assert_allclose(ends[0], ends[1], rtol=0.0, atol=1e-12)
    assert np.abs(ends[0][0] - 1.0).max() > 1e-3  # it moves


@pytest.mark.parametrize("build", [scipy_dop853.build, scipy_dop853.build_together])
def test_scipy_agrees_with_heyoka(build: Callable[[Job], Run]) -> None:
    """Two programs and three forms of one equation end at the same thickness stretch."""
    pytest.importorskip("heyoka")
    job, omegas = replace(FILM, window=10.0), np.linspace(0.5, 4.0, 5)
    exact = heyoka_batch.build_end(job)(omegas, 1e-15).values
    assert np.abs(build(job)(omegas, 1e-12).values - exact).max() < 1e-9


@dataclass(frozen=True)
class Fake:
    """A tool whose error is its setting, by a factor."""

    factor: float
    compiles: bool = False
    settings: tuple[float, ...] = TOLERANCES
    gives: str = "end"

    def checked(self, job: Job) -> slice:
        return slice(None)

    def run(self, omegas: np.ndarray, setting: float) -> Answer:
        return Answer(np.full((omegas.size, 1), self.factor * setting), 1.0)


@pytest.mark.parametrize(("factor", "expected"), [(1.0, 1e-8), (30.0, 10**-9.5), (1e9, 1e-15)])
def test_the_cheapest_setting_within_the_limit_is_taken(factor: float, expected: float) -> None:
    """Loosest first until the worst error is at most 1e-8; the most exact where none is."""
    tool: Any = Fake(factor)
    checked = RESPONSE.omegas[RESPONSE.subset].size
    truth = Reference({"end": np.zeros((checked, 1))}, np.ones(checked, dtype=bool))
    result = cheapest(tool, tool.run, RESPONSE, truth)
    assert result.setting == pytest.approx(expected)
    assert result.met == (factor < 1e9)


def test_nothing_is_judged_without_results() -> None:
    """A target without results is neither met nor missed."""
    assert [verdict.text for verdict in verdicts({})] == ["not measured"] * len(TARGETS)


@pytest.mark.parametrize(
    ("larger", "value", "text"),
    [(True, 5.0, "aim"), (True, 2.0, "yes"), (True, 1.9, "no"),
     (False, 1.0, "aim"), (False, 2.0, "yes"), (False, 2.1, "no")],
)  # fmt: skip
def test_targets_are_met_at_their_limits(larger: bool, value: float, text: str) -> None:
    """At the limit a target is met, beyond it on the wrong side it is not."""
    aim = 5.0 if larger else 1.0
    target = targets.Target("row", "work", "peer", float, 2.0, aim, larger=larger)
    assert Verdict(target, value).text == text


def test_start_is_not_judged_without_numba() -> None:
    """A process that was left out makes its ratio unknown, and no other."""
    seconds = dict.fromkeys(("import numpy", "import remanent", "first figure"), 1.0)
    rows = {"start": {"data": {"seconds": seconds | {"first figure, cold": 2.0}}}}
    texts = {v.target.work: v.text for v in verdicts(rows) if v.target.row == "start"}
    assert texts == {
        "`import remanent`": "aim",
        "first figure, kernels cached": "not measured",
        "first figure, nothing cached": "aim",
    }


def test_a_missing_peer_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """One line for each peer that is not here, with the command that installs it."""
    monkeypatch.setattr("benchmarks.tools.tool.find_spec", lambda _name: None)
    monkeypatch.setattr("shutil.which", lambda _name: None)
    lines = missing_peers()
    assert len(lines) == 5
    for line in lines:
        assert re.search(r"`(?:pip|apt) install [^`]+`", line)
        assert "\n" not in line


@pytest.mark.parametrize("path", RESULTS, ids=lambda path: path.stem)
def test_results_name_no_path(path: Path) -> None:
    """Results are kept with their processor, and tell nothing about where they were made."""
    text = path.read_text("utf-8")
    if path.stem not in ("coverage", "orbit_search"):  # which measure no speed
        assert json.loads(text)["environment"]["processor"]
    assert not re.search(r"/(?:home|root|tmp|usr|work)\b", text)
