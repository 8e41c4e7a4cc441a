"""A thousand motions whose regime is known: ``python -m tests.literature.regimes.make_cases``.

Writes ``cases.json`` beside this file (README.md says what is in it). About a quarter of an
hour of one core.
"""

from __future__ import annotations

import json
import sys
import time
from collections import Counter
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from remanent._typing import FloatArray
from tests.literature.regimes import flows, verdict
from tests.literature.regimes.families import FAMILIES, SEED, Case, Family, cases
from tests.literature.regimes.flows import Orbit

OUT = Path(__file__).parent / "cases.json"
#: Drive periods of a flow, iterates of a map.
FLOW_LENGTH, MAP_LENGTH = 10_000, 200_000
#: An orbit that escapes later than this is left undecided.
LATEST_ESCAPE = 500


def main() -> None:
    """Integrate all cases and write what they are."""
    everything = cases()
    rows: list[dict[str, Any] | None] = [None] * len(everything)
    begin = time.process_time()
    for name, family in FAMILIES.items():
        members = [i for i, case in enumerate(everything) if case.family == name]
        some = [everything[i] for i in members]
        run = _maps if family.rates is None else _flows
        for done, (k, orbit) in enumerate(run(name, family, some)):
            rows[members[k]] = _row(members[k], some[k], family, orbit)
            if done % 80 == 79 or done + 1 == len(some):
                spent = time.process_time() - begin
                print(f"{name} {done + 1}/{len(some)} {spent:.0f} s", file=sys.stderr)
    _write([row for row in rows if row is not None])


def _flows(name: str, family: Family, some: list[Case]) -> Iterator[tuple[int, Orbit]]:
    parameters = np.array([case.parameters for case in some])
    initial = np.array([case.initial for case in some])
    pace = 1.0 / parameters[:, 0]
    if name == "actuator":
        pace = pace / np.sqrt(parameters[:, 4])
    if family.rates is None:
        raise TypeError(f"{name} is a map")
    resting = (np.array(family.resting[0]), np.array(family.resting[1]))
    return flows.orbits(
        family.rates,
        parameters,
        initial,
        FLOW_LENGTH,
        resting=resting,
        lost=family.lost,
        sweep=pace,
        turn=family.turn,
    )


def _maps(name: str, family: Family, some: list[Case]) -> Iterator[tuple[int, Orbit]]:
    """All cases of a map at once."""
    par = np.array([case.parameters for case in some]).T
    x, v = np.array([case.initial for case in some]).T
    p = q = np.full(len(some), np.sqrt(0.5))
    strobes = np.full((MAP_LENGTH + 1, len(some), 2), np.nan)
    growth = np.zeros((MAP_LENGTH // flows.CHUNK, len(some)))
    strobes[0] = np.column_stack([x, v])
    with np.errstate(all="ignore"):
        for k in range(MAP_LENGTH):
            x, v, p, q = _step(name, par, x, v, p, q)
            strobes[k + 1, :, 0], strobes[k + 1, :, 1] = x, v
            size = np.maximum(np.hypot(p, q), 1e-300)
            growth[k // flows.CHUNK] += np.log(size)
            p, q = p / size, q / size
    for i in range(len(some)):
        lost = np.flatnonzero(family.lost(strobes[:, i]))
        end = MAP_LENGTH if len(lost) == 0 else (int(lost[0]) // flows.CHUNK) * flows.CHUNK
        ending = "escaped" if len(lost) else ""
        yield i, Orbit(strobes[: end + 1, i], growth[: end // flows.CHUNK, i], ending)


def _step(
    name: str, par: FloatArray, x: FloatArray, v: FloatArray, p: FloatArray, q: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """One iterate of state and tangent."""
    if name == "standard":
        v, q = v + par[0] * np.sin(x), q + par[0] * np.cos(x) * p
        x, p = x + v, p + q
        turn = 2 * np.pi
        return np.mod(x, turn), np.mod(v, turn), p, q
    if name == "logistic":
        return par[0] * x * (1 - x), v, par[0] * (1 - 2 * x) * p, 0 * q
    return 1 - par[0] * x * x + v, par[1] * x, -2 * par[0] * x * p + q, par[1] * p


def _row(index: int, case: Case, family: Family, orbit: Orbit) -> dict[str, Any]:
    """One case as it is written."""
    row: dict[str, Any] = {
        "id": index,
        "family": case.family,
        "group": case.group,
        "parameters": list(case.parameters),
        "initial": list(case.initial),
        "dissipative": case.dissipative,
    }
    if orbit.ending:
        length = len(orbit.strobes) - 1
        known = orbit.ending == "escaped" and length <= LATEST_ESCAPE
        truth, period = ("escaped" if known else "undecided"), None
        row["evidence"] = {"ending": orbit.ending, "length": length}
    else:
        evidence = verdict.gather(family.observables(orbit.strobes), orbit.growth)
        truth = verdict.regime(evidence, dissipative=case.dissipative)
        period = evidence.period if truth == "periodic" else None
        row["evidence"] = verdict.row(evidence)
    row |= {"truth": truth, "period": period, "basis": "reference"}
    if case.truth is not None:
        row |= {"truth": case.truth, "period": case.period, "basis": "construction"}
        if (truth, period) != (case.truth, case.period):
            row["reference"] = [truth, period]
    return row


def _write(rows: list[dict[str, Any]]) -> None:
    families = {
        name: {"parameters": list(family.names), "equation": family.equation}
        for name, family in FAMILIES.items()
    }
    head = {
        "seed": SEED,
        "heyoka": version("heyoka"),
        "tolerance": flows.TOLERANCE,
        "flow_length": FLOW_LENGTH,
        "map_length": MAP_LENGTH,
        "families": families,
        "counts": dict(sorted(Counter(row["truth"] for row in rows).items())),
    }
    body = ",\n".join(json.dumps(row, separators=(",", ":")) for row in rows)
    text = json.dumps(head, indent=1)
    OUT.write_text(text[:-2] + ',\n "cases": [\n' + body + "\n ]\n}\n")
    print(head["counts"])


if __name__ == "__main__":
    main()
