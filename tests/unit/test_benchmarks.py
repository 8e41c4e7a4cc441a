"""What the benchmarks count and judge, without timing anything."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from benchmarks.jobs import JOBS, Job
from benchmarks.machine_code import assembly, work_per_pass
from benchmarks.multiply_add import source
from benchmarks.reference import Reference
from benchmarks.targets import TARGETS, verdicts

from remanent.integrate.kernel.compile import host

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


@pytest.mark.skipif("+fma" not in host().features.split(","), reason="no multiply-add vectors")
def test_the_yardstick_is_multiply_adds_and_nothing_else() -> None:
    """Its loop does whole passes of six chains; a compiler may unroll several into one."""
    work = work_per_pass(assembly(source(host().width), host()))
    assert work.keys() == {"fma"}
    assert work["fma"] > 0
    assert work["fma"] % (6 * host().width) == 0


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
