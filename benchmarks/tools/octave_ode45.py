"""GNU Octave's ode45, where ``octave-cli`` is on the path.

[Thermal] uses MATLAB's function of that name.  Octave's own clock is read, so that its start
does not count.
"""

from __future__ import annotations

import shutil
import subprocess
from functools import cache

import numpy as np

from benchmarks.jobs import Job, thickness_stretch
from benchmarks.tools.tool import TOLERANCES, Answer, Run, Tool
from remanent._typing import FloatArray

_PROGRAM = "octave-cli"
#: The work as Octave reads it, with products in place of powers; ends, then seconds, come back.
_SCRIPT = """
function dy = rates(tau, y, omega)
  x = y(1); v = y(2);
  m = {half} * (1 - cos(2 * omega * tau));
  x2 = x * x; x4 = x2 * x2; x7 = x4 * x2 * x;
  force = {theta} * (x4 * x4 - x2) + m * x4 - {prestress} * x7;
  dy = [v; (6 * {c} * v * v - 3 * force) / (x7 + 2 * {c} * x)];
end
options = odeset("RelTol", {tolerance}, "AbsTol", {tolerance});
tic;
for omega = [{omegas}]
  [t, y] = ode45(@(t, y) rates(t, y, omega), [0 {window}], [1; 0], options);
  printf("%.17g\\n", y(end, 1));
end
printf("%.17g\\n", toc);
"""


class Octave:
    """Octave's command line, as a source of a tool."""

    def missing(self) -> str:
        if shutil.which(_PROGRAM):
            return ""
        return f"{_PROGRAM} is not on the path; install it with `apt install octave` or the like"

    def version(self) -> str:
        return _execute("disp(version)").strip()


def build(job: Job) -> Run:
    """The thickness stretch at the end, one motion after another."""

    def run(omegas: FloatArray, tolerance: float) -> Answer:
        script = _SCRIPT.format(
            half=repr(0.5 * job.b**2), theta=repr(job.theta), prestress=job.prestress, c=job.c,
            window=job.window, tolerance=tolerance, omegas=" ".join(map(repr, omegas.tolist())),
        )  # fmt: skip
        *ends, seconds = map(float, _execute(script).split())
        return Answer(np.asarray(thickness_stretch(np.array(ends)))[:, None], seconds)

    return run


@cache
def _path() -> str:
    path = shutil.which(_PROGRAM)
    assert path is not None
    return path


def _execute(script: str) -> str:
    command = [_path(), "--norc", "--quiet", "--eval", script]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


SOURCE = Octave()
TOOL = Tool(
    "octave",
    "GNU Octave ode45, end state only",
    SOURCE,
    "end",
    build,
    settings=tuple(t for t in TOLERANCES if 1e-12 < t < 2e-8),
    sample=1,
    compiles=False,
)
