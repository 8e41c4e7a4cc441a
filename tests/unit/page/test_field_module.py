"""Equations as a page integrates them are those of the engine, and say which numbers may move."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import remanent as rm
from remanent.models.drives.base import Drive
from remanent.page.model import PageModel, page_model
from remanent.studies.ensemble.layout import lay_out_ensemble
from tests.contracts.exported import CASES, points, require_equal

#: Reads what is asked from a file, and writes what each module says.
NODE = """
import { readFileSync } from "node:fs";
const answers = [];
for (const one of JSON.parse(readFileSync(process.argv[2], "utf8"))) {
  const field = await import(one.path);
  const rates = new Float64Array(field.state_names.length);
  const seen = new Float64Array(field.observable_names.length);
  const p = { ...field.parameters, ...one.changes };
  answers.push({
    period: String(field.period(p)),
    points: one.points.map(([t, y]) => {
      field.rates(t, y, p, rates);
      field.observables(t, y, p, seen);
      return [[...rates].map(String), [...seen].map(String), field.admissible(y, p)];
    }),
  });
}
console.log(JSON.stringify(answers));
"""


def ask(asked: list[dict[str, Any]], folder: Path) -> list[dict[str, Any]]:
    """What modules say, by one process; each entry has its ``source``, points and changes."""
    if shutil.which("node") is None:
        pytest.skip("node is not installed")
    for k, one in enumerate(asked):
        path = folder / f"field_{k}.mjs"
        path.write_text(one.pop("source"), encoding="utf-8")
        one["path"] = str(path)
    (folder / "ask.mjs").write_text(NODE)
    (folder / "asked.json").write_text(json.dumps(asked))
    command = ["node", str(folder / "ask.mjs"), str(folder / "asked.json")]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    answers: list[dict[str, Any]] = json.loads(done.stdout)
    return answers


def observed(system: Any, drive: Drive, model: PageModel, t: float, y: Any) -> list[float]:
    """What the engine observes of a state at a time."""
    ens = lay_out_ensemble(system, drive)
    field, period = ens.vector_field, ens.drive.period
    schedule = ens.drive.load_schedule({}, np.array([min(2.0 * t + 1.0, ens.drive.known_until)]))
    if period is not None:
        phase, p = (t / period) % 1.0, {}
    else:
        lengths = schedule.piece_lengths[:, 0]
        starts = np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
        piece = int(np.searchsorted(starts, t, side="right")) - 1
        phase = (t - starts[piece]) / lengths[piece]
        p = {name: row[piece, 0] for name, row in schedule.piece_parameters.items()}
    p |= {name: float(column[0]) for name, column in ens.parameter_values.items()}
    given = [phase, *y, *(p[name] for name in field.parameter_names)]
    given += [float(x) for x in schedule.waveforms_at_phase(np.array(phase))]
    names = [one["name"] for one in model.description["observables"]]
    return [
        float(field.observables[name](list(map(np.float64, given)), functions=np)[0])
        for name in names
    ]


def test_rates_and_observables_are_those_of_the_engine(tmp_path: Path) -> None:
    """Law: for every kind of system and drive, near rest and at jumps of the load."""
    models = {name: page_model(system, drive) for name, (system, drive) in CASES.items()}
    asked = [
        {"source": models[name].field_source, "changes": {},
         "points": [(t, y.tolist()) for t, y, _ in points(*CASES[name])]}
        for name in CASES
    ]  # fmt: skip
    answers = ask(asked, tmp_path)
    assert len(answers) == len(CASES)
    for name, answered in zip(CASES, answers, strict=True):
        system, drive = CASES[name]
        for (t, y, expected), (rates, seen, inside) in zip(
            points(system, drive), answered["points"], strict=True
        ):
            require_equal(list(map(float, rates)), expected)
            with np.errstate(all="ignore"):
                wanted = np.array(observed(system, drive, models[name], t, y))
            require_equal(list(map(float, seen)), wanted)
            coordinates = [
                y[k]
                for k, one in enumerate(models[name].description["state"])
                if one["role"] == "coordinate"
            ]
            assert inside == bool(system.where_admissible({}, *coordinates)), name


@pytest.mark.parametrize(
    ("drive", "times"),
    [
        (rm.Steps([0.0, 0.5, 1.75], [0.1, 0.3, 0.2]), [0.5, 1.75]),
        (rm.Ramp([0.0, 1.5, 3.75], [0.1, 0.4, 0.2]), [1.5, 3.75]),
        (rm.Constant(0.2), []),
    ],
    ids=["steps", "ramp", "constant"],
)
def test_a_module_says_when_the_load_changes(drive: Drive, times: list[float]) -> None:
    """The times after the start at which a piece of the load begins."""
    source = page_model(rm.Actuator(), drive).field_source
    (text,) = re.findall(r"^export const breaks = (\[.*\]);$", source, re.MULTILINE)
    assert json.loads(text) == times


def test_numbers_move_without_a_new_module(tmp_path: Path) -> None:
    """Law: every number that is not fixed enters as it is given: rates and period follow it."""
    rng = np.random.default_rng(2)
    asked, expected = [], []
    for system, drive in CASES.values():
        model = page_model(system, drive)
        changes = {
            one["name"]: one["value"] + float(rng.uniform(0.01, 0.05))
            for one in model.description["parameters"]
            if one["fixed"] is None and one["name"] != "material.entropic_fraction"
        }
        moved = system
        for name, value in changes.items():
            if name in system.parameter_rules():
                moved = moved.with_parameter(name, value)
        load = {k: x for k, x in changes.items() if k in drive.parameter_rules()}
        other = drive.replace(**load)
        period = other.period
        t, y, _ = points(system, drive)[-1]
        asked.append(
            {"source": model.field_source, "changes": changes, "points": [(t, y.tolist())]}
        )
        expected.append((rm.rates(moved, other)(t, y), period))
    for (rates, period), answered in zip(expected, ask(asked, tmp_path), strict=True):
        require_equal(list(map(float, answered["points"][0][0])), rates)
        np.testing.assert_allclose(
            float(answered["period"]), np.nan if period is None else period, rtol=1e-14
        )


def test_fixed_numbers_say_why() -> None:
    """Law: what the pieces of a load are made of cannot move, with a reason; all else can."""
    chirp = page_model(rm.Actuator(), rm.Chirp.example()).description["parameters"]
    reasons = {one["name"]: one["fixed"] for one in chirp if one["fixed"] is not None}
    assert set(reasons) == {"start", "stop", "duration", "phase"}
    assert all(text.endswith(".") for text in reasons.values())
    for drive in (rm.SineSquared(0.4, 1.25), rm.Sines([0.2, 0.1], [1.0, 2.0**0.5], 0.9)):
        free = page_model(rm.Actuator(), drive).description["parameters"]
        assert [one["name"] for one in free if one["fixed"] is not None] == []


def test_equal_models_have_equal_modules() -> None:
    """Law: the name of a module is a digest of its text."""
    one, same, other = (
        page_model(rm.Actuator(temperature=t), rm.SineSquared(0.4, 1.25)) for t in (300, 300, 310)
    )
    assert one.field_source == same.field_source
    assert one.id == same.id != other.id
    assert re.fullmatch(r"[0-9a-f]{24}", one.id)
