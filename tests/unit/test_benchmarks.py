"""What the benchmarks count and judge, without timing anything."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from benchmarks.jobs import JOBS, RESPONSE, Job
from benchmarks.machine_code import assembly, work_per_pass
from benchmarks.multiply_add import CHAINS, source
from benchmarks.reference import Reference
from benchmarks.targets import TARGETS, verdicts
from benchmarks.tools import ours

from remanent.integrate.ensemble.problem import Request
from remanent.integrate.ensemble.resolution import method_for
from remanent.integrate.kernel.compile import Target, host
from remanent.integrate.kernel.kernel import Options

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
    """Neither the loop around, nor the branch that may be skipped; lanes by register size."""
    assert work_per_pass(NESTED) == {"fma": 8, "add": 8, "mul": 4}


PROCESSORS = {
    "znver4": "+avx,+avx2,+fma,+avx512f,+avx512vl",
    "skylake-avx512": "+avx,+avx2,+fma,+avx512f,+avx512vl",
    "haswell": "+avx,+avx2,+fma",
}
TARGETS_X86 = [Target("x86_64-unknown-linux-gnu", *item) for item in PROCESSORS.items()]
x86 = pytest.mark.skipif(
    not host().triple.startswith("x86_64"), reason="LLVM makes code for its own processor only"
)


@x86
@pytest.mark.parametrize("target", TARGETS_X86, ids=lambda target: target.cpu)
def test_the_yardstick_is_one_multiply_add_per_chain(target: Target) -> None:
    """A pass is one multiply-add of each chain and lane, however often LLVM would unroll it."""
    work = work_per_pass(assembly(source(target.width), target))
    assert work == {"fma": CHAINS * target.width}


@x86
def test_operations_of_a_step_do_not_depend_on_the_processor() -> None:
    """Per lane a kernel does the same arithmetic on processors of one vector width."""
    method = method_for(Request(extremes=True), 1e-9)
    field = ours.asked(RESPONSE, RESPONSE.omegas[:1]).field
    counts = [
        work_per_pass(assembly(target.source(field, method, Options(extremes=True)), target))
        for target in TARGETS_X86[:2]
    ]
    assert counts[0] == counts[1]
    assert counts[0]["fma"] > 10 * TARGETS_X86[0].width


@pytest.mark.parametrize("job", JOBS.values(), ids=lambda job: job.name)
def test_acceleration_is_equation_16(job: Job) -> None:
    """The form with one division equals the equation as [Thermal, eq. 16] has it."""
    rng = np.random.default_rng(16)
    m, x, v = rng.uniform(0, 1, 99), rng.uniform(0.5, 2, 99), rng.uniform(-2, 2, 99)
    force = job.theta * (x - x**-5) - job.prestress + m * x**-3
    expected = (6 * job.c * x**-7 * v**2 - 3 * force) / (1 + 2 * job.c * x**-6)
    np.testing.assert_allclose(job.acceleration(m, x, v), expected, rtol=1e-12, atol=1e-12)


def test_errors_leave_out_what_nobody_resolves_and_show_what_has_no_value() -> None:
    truth = Reference({"end": np.zeros((3, 1))}, np.array([True, False, True]))
    error = truth.error("end", np.array([[2.0], [9.0], [np.nan]]))
    np.testing.assert_array_equal(error, [2.0, np.nan])


def test_nothing_is_judged_without_results() -> None:
    assert [verdict.text for verdict in verdicts({})] == ["not measured"] * len(TARGETS)


@pytest.mark.parametrize("path", RESULTS, ids=lambda path: path.stem)
def test_results_name_no_path(path: Path) -> None:
    """Versions and a processor, but no path."""
    text = path.read_text("utf-8")
    if path.stem != "coverage":  # which measures no time
        assert json.loads(text)["environment"]["processor"]
    assert not re.search(r"/(?:home|root|tmp|usr|work)\b", text)
