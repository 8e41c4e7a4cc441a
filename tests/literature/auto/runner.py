"""Run AUTO-07p on an equation file and read what it writes."""

from __future__ import annotations

import re
import shutil
import subprocess
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from remanent._typing import FloatArray

HERE = Path(__file__).parent
LIBRARY = Path("/usr/lib/auto-07p/lib")
#: The Debian package that made the reference.
AUTO_VERSION = "0.9.2"
#: AUTO's two-letter names of the point types it numbers.
KINDS = {1: "BP", 2: "LP", 3: "HB", 4: "UZ", -4: "UZ", 5: "LP", 6: "BP", 7: "PD", 8: "TR",
         9: "EP", -9: "MX"}  # fmt: skip


def installed() -> bool:
    """AUTO's object files and a Fortran compiler are here."""
    return shutil.which("gfortran") is not None and any(LIBRARY.glob("*.o"))


@dataclass(frozen=True)
class Solution:
    """One point of a branch as AUTO stored it.

    Attributes
    ----------
    kind
        "" for a regular point, else BP, LP, PD, TR, UZ or EP.
    t : array (node,)
        Collocation nodes in [0, 1].
    u : array (node, state)
    par : array (parameter,)
        PAR(1), PAR(2) ...
    multipliers : complex array (state,)
        NaN where AUTO printed none.
    """

    kind: str
    number: int
    label: int
    ncol: int
    t: FloatArray
    u: FloatArray
    par: FloatArray
    multipliers: Any


@dataclass(frozen=True)
class Run:
    """What one run left: its points, in order, and how long it took."""

    solutions: list[Solution]
    seconds: float
    points: int
    directory: Path


def compile_equations(name: str, directory: Path) -> Path:
    """Link an equation file of this directory with AUTO."""
    executable = directory / f"{name}.exe"
    objects = sorted(str(path) for path in LIBRARY.glob("*.o"))
    source = str(HERE / f"{name}.f90")
    command = ["gfortran", "-O3", "-march=native", "-fopenmp", "-w", source, *objects]
    subprocess.run([*command, "-o", str(executable)], check=True, cwd=directory)
    return executable


def write_start(directory: Path, par: Sequence[float], orbit: FloatArray | None) -> None:
    """Start values of the parameters and, if there is one, an orbit (node, 1 + state)."""
    (directory / "start.par").write_text(" ".join(f"{x:.17g}" for x in par) + "\n")
    if orbit is not None:
        np.savetxt(directory / "start.dat", orbit, fmt="%.17g")


def run(
    executable: Path,
    constants: str,
    *,
    restart: str | None = None,
    **changes: Any,
) -> Run:
    """Run with the constants file ``c.<constants>``, changed by keywords.

    `restart` is the text of a fort.8 to start from (IRS > 0).
    """
    directory = executable.parent
    for old in directory.glob("fort.*"):
        old.unlink()
    text = (HERE / f"c.{constants}").read_text()
    if restart is not None:
        (directory / "fort.3").write_text(restart)
    lines = [f"{key} = {_constant(value)}" for key, value in changes.items()]
    (directory / "fort.2").write_text(text + "\n".join(lines) + "\n")
    begin = time.perf_counter()
    done = subprocess.run(
        [str(executable)], cwd=directory, capture_output=True, text=True, check=True,
        env={"OMP_NUM_THREADS": "1"},
    )  # fmt: skip
    seconds = time.perf_counter() - begin
    if "Error" in done.stdout or not (directory / "fort.7").exists():
        raise RuntimeError(done.stdout + done.stderr)
    rows = [line.split() for line in (directory / "fort.7").read_text().splitlines()]
    points = sum(row[0] != "0" for row in rows)
    return Run(_solutions(directory), seconds, points, directory)


def _constant(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{k}: {_constant(v)}" for k, v in value.items()) + "}"
    return repr(value)


def _solutions(directory: Path) -> list[Solution]:
    path = directory / "fort.8"
    if not path.exists():
        return []
    tokens = path.read_text().split("\n")
    table = _multipliers(directory)
    found = []
    at = 0
    while at < len(tokens) and tokens[at].strip():
        head = [int(x) for x in tokens[at].split()[:18]]
        number, kind, label = abs(head[1]), head[2], head[3]
        rows, lines, ncol, npar = head[6], head[8], head[10], head[11]
        body = tokens[at + 1 : at + 1 + lines]
        # each node may be wrapped over lines of seven numbers; the whole block is one list
        wide = head[7]
        values = np.array(" ".join(body).replace("D", "E").split(), dtype=float)
        nodes = values[: rows * wide].reshape(rows, wide)
        par = values[-npar:]
        name = "" if abs(kind) % 10 == 4 and kind > 0 else KINDS.get(kind % 10, "")
        if kind == -4:
            name = "UZ"
        if kind in (9, -9):
            name = "EP"
        found.append(
            Solution(
                name,
                number,
                label,
                ncol,
                nodes[:, 0],
                nodes[:, 1:],
                par,
                table.get(number, np.array([np.nan])),
            )
        )
        at += 1 + lines
    return found


def _multipliers(directory: Path) -> dict[int, Any]:
    """Multipliers by point number, from the diagnostics (the last ones printed count)."""
    found: dict[int, list[complex]] = {}
    pattern = re.compile(r"^\s*\d+\s+(\d+)\s+Multiplier\s+(\d+)\s+(\S+)\s+(\S+)")
    for line in (directory / "fort.9").read_text().splitlines():
        match = pattern.match(line)
        if match:
            point, index = int(match[1]), int(match[2])
            if index == 1:
                found[point] = []
            found[point].append(complex(_number(match[3]), _number(match[4])))
    return {key: np.array(value) for key, value in found.items()}


def _number(text: str) -> float:
    """A Fortran number; overflow, printed without its letter, is infinite."""
    try:
        return float(text)
    except ValueError:
        return float("inf")
