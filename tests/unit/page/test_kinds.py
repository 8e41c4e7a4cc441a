"""Everything that can be chosen and moved has a name, a text and a useful range."""

from __future__ import annotations

import json
import math
import re
from typing import Any

import numpy as np
import pytest

import remanent as rm
from remanent.models.dissipation import Dissipation
from remanent.models.drives.base import Drive
from remanent.models.materials.base import Material
from remanent.page.kinds import kinds
from remanent.page.model import page_model
from remanent.page.ranges import limits_of, range_of
from remanent.page.spec import read_spec
from tests.contracts.exported import CASES
from tests.contracts.public import examples

MENUS = kinds()
ENTRIES = [(group, one["name"]) for group, entries in MENUS.items() for one in entries]
SQUARED = {"kind": "SineSquared", "b": 0.4, "omega": 1.25}


def entry(group: str, name: str) -> dict[str, Any]:
    return next(one for one in MENUS[group] if one["name"] == name)


def test_every_public_kind_is_offered() -> None:
    """Law: each public drive, material and element, several loads aside, is in a menu."""
    for group, kind in (("drive", Drive), ("material", Material), ("dissipation", Dissipation)):
        names = {*examples(kind)} - {"Loads"}
        assert {one["name"] for one in MENUS[group]} == names
    json.dumps(MENUS, allow_nan=False)


@pytest.mark.parametrize(("group", "name"), ENTRIES)
def test_a_chosen_kind_can_be_shown(group: str, name: str) -> None:
    """Law: its table is read as a study file's, and its numbers are those of the model."""
    chosen = entry(group, name)
    assert chosen["text"]
    assert not re.search(r"[`\\]", " ".join(f["help"] for f in chosen["fields"]) + chosen["text"])
    table = chosen["table"]
    if group == "drive":
        spec: dict[str, Any] = {"actuator": {}, "drive": table}
    elif group == "shift":
        element = {"kind": "Rayleigh", "eta": 0.1, "shift": table}
        spec = {"actuator": {"dissipation": [element]}, "drive": SQUARED}
    else:
        part = [table] if group == "dissipation" else table
        spec = {"actuator": {group: part}, "drive": SQUARED}
    system, drive, _ = read_spec(spec)
    prefix = {"drive": "", "dissipation": "dissipation.0.", "shift": "dissipation.0.shift."}
    parameters = page_model(system, drive).description["parameters"]
    values = {one["name"]: one["value"] for one in parameters}
    for field in chosen["fields"]:
        assert values[f"{prefix.get(group, f'{group}.')}{field['name']}"] == field["value"]


def all_parameters() -> list[tuple[str, dict[str, Any], Any]]:
    """Every number of every kind of model, with its rule."""
    found = []
    for case, (system, drive) in CASES.items():
        rules = {**system.parameter_rules(), **drive.parameter_rules()}
        for one in page_model(system, drive).description["parameters"]:
            found.append((case, one, rules[one["name"]]))
    return found


def test_ranges_hold_the_value_and_only_what_is_allowed() -> None:
    """Law: the slider's ends and all between obey the rule; logarithms start above 0."""
    for case, one, rule in all_parameters():
        assert one["min"] < one["max"], (case, one)
        assert one["min"] <= one["value"] <= one["max"], (case, one)
        places = np.linspace(one["min"], one["max"], 50)
        holds = np.asarray(rule.is_satisfied_by(places))
        if "other than 0" not in rule.must:
            assert holds.all(), (case, one)
        if one["scale"] == "log":
            assert one["min"] > 0.0
        assert one["symbol"]
        assert one["text"]
        assert one["unit"]
        assert one["rule"].startswith("It must ")


def test_limits_are_those_of_the_rule() -> None:
    """Law: on random numbers, what lies between the limits is what the rule allows."""
    rng = np.random.default_rng(3)
    for _, one, rule in all_parameters():
        limits = one["limits"]
        least = -math.inf if limits["least"] is None else limits["least"]
        most = math.inf if limits["most"] is None else limits["most"]
        for x in [*rng.normal(0.0, 3.0, 20), 0.0, 1.0]:
            allowed = least < x < most or (x == least and limits["least_included"])
            allowed = allowed or (x == most and limits["most_included"])
            if "other than 0" not in rule.must:
                assert allowed == bool(rule.is_satisfied_by(x)), (one["name"], x)


def test_a_value_beyond_the_usual_range_widens_it() -> None:
    """Law: no value is out of reach of its own slider."""
    assert range_of("temperature", 500.0).high == 500.0
    assert range_of("temperature", 300.0).high == 450.0
    assert range_of("own", -2.0).low == -6.0
    assert range_of("own", 0.0) == range_of("other", 0.0)


def test_limits_of_known_rules() -> None:
    """Law: positive, not negative, a share, any number."""
    rules = rm.Actuator(material=rm.Gent(30.0), dissipation=rm.Rayleigh(0.1)).parameter_rules()
    assert limits_of(rules["c"])["least"] == 0.0
    assert limits_of(rules["c"])["least_included"] is False
    assert limits_of(rules["dissipation.0.eta"])["least_included"] is True
    share = limits_of(rules["material.entropic_fraction"])
    assert (share["least"], share["most"]) == (0.0, 1.0)
    assert limits_of(rules["prestress"])["least"] is None


def test_every_number_has_its_group_and_help() -> None:
    """Law: groups are the controls'; numbers of parts are explained by their class."""
    model = page_model(
        rm.Actuator(
            material=rm.Gent(30.0),
            dissipation=rm.Zener(0.5, 1.0, shift=rm.WLF(8.0, 200.0)),
            heat=rm.Heat(),
        ),
        rm.SineSquared(0.4, 1.25),
    )
    found = {one["name"]: one for one in model.description["parameters"]}
    assert found["c"]["group"] == "actuator"
    assert found["material.jm"]["group"] == "material"
    assert found["dissipation.0.modulus"]["group"] == "dissipation"
    assert found["heat.exchange"]["group"] == "heat"
    assert found["omega"]["group"] == "drive"
    assert "activation" not in found["dissipation.0.shift.c2"]["help"]
    assert all(one["help"] for one in found.values()), [
        k for k, v in found.items() if not v["help"]
    ]
