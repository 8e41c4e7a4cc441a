"""What the server answers to a page."""

from __future__ import annotations

import json
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from remanent.page.files import plotly_script
from remanent.page.model import page_model
from remanent.page.presets import presets
from remanent.page.reproduction import reproduction
from remanent.studies.export.export import EXPORT_LANGUAGES
from remanent.web.subjects import read_subject
from tests.unit.web.server import SPEC, Running, result_of

STUDY = """
verb = "classify"
[actuator]
temperature = 320.0
[drive]
kind = "Sine"
m = 0.2
omega = 1.1
[over]
m = [0.1, 0.2]
[options]
periods = 100
"""


def as_json(content: Any) -> Any:
    """Plain data after its way through JSON."""
    return json.loads(json.dumps(content))


def test_the_page_and_its_library_are_files(server: Running) -> None:
    """Law: the page, its modules and plotly.js come from the installed packages, with types that
    browsers run, and a browser that has them asks whether they are new."""
    page = server.ask("GET", "/")
    assert page.status == 200
    assert page.headers["content-type"].startswith("text/html")
    assert page.body == server.ask("GET", "/assets/index.html").body
    module = server.ask("GET", "/assets/app/main.js")
    assert module.headers["content-type"].startswith("text/javascript")
    library = server.ask("GET", "/plotly.js")
    assert library.headers["content-type"].startswith("text/javascript")
    assert library.body == plotly_script().read_bytes()
    assert {one.headers["cache-control"] for one in (page, module, library)} == {"no-cache"}
    again = server.ask(
        "GET", "/assets/app/main.js", None, {"If-None-Match": module.headers["etag"]}
    )
    assert (again.status, again.body) == (304, b"")


def test_a_page_begins_with_what_was_opened(server: Running) -> None:
    """Law: the start has the model, its module, what can be chosen, and how much may be asked."""
    start = server.ask("GET", "/api/start").json
    subject = read_subject(SPEC)
    model = page_model(subject.system, subject.drive)
    assert start["version"] == version("remanent")
    assert start["model"] == as_json(model.description)
    assert start["presets"] == as_json(presets())
    assert start["store"] is None
    assert start["jobs"] == {"slots": 1}
    field = server.ask("GET", start["field"])
    assert field.body.decode() == model.field_source
    assert field.headers["content-type"].startswith("text/javascript")
    assert "immutable" in field.headers["cache-control"]


@pytest.mark.parametrize("preset", presets(), ids=lambda preset: preset["id"])
def test_every_preset_has_a_model(server: Running, preset: dict[str, Any]) -> None:
    """Law: what the page offers can be looked at, and its module is there."""
    answer = server.ask("POST", "/api/model", {"spec": preset["spec"]})
    assert answer.status == 200
    assert server.ask("GET", answer.json["field"]).status == 200
    assert answer.json["field"] == f"/fields/{answer.json['model']['id']}.js"
    told = answer.json["model"]["spec"]
    assert read_subject(told) == read_subject(preset["spec"])


def test_a_study_file_is_read_as_it_is(server: Running) -> None:
    """Law: the text of a study has the model of its system and drive; the rest is left alone."""
    answer = server.ask("POST", "/api/model", {"toml": STUDY}).json
    subject = read_subject(answer["model"]["spec"])
    assert subject.system == rm.Actuator(temperature=320.0)
    assert subject.drive == rm.Sine(0.2, 1.1)


@pytest.mark.parametrize(
    ("content", "table", "key", "words"),
    [
        ({"spec": {**SPEC, "actuator": {"temperature": -1.0}}}, "actuator", "temperature", "-1.0"),
        ({"spec": {**SPEC, "actuator": {"temprature": 1.0}}}, "actuator", "temprature", "Did you"),
        ({"spec": {**SPEC, "drive": {"kind": "Sin"}}}, "drive", "kind", "Sine"),
        ({"spec": {**SPEC, "initial": {"stretch": "x"}}}, "initial", "stretch", "stretch"),
        ({"spec": {"drive": SPEC["drive"]}}, "actuator", "", "actuator"),
        ({"toml": STUDY.replace("0.2\nomega", "true\nomega")}, "drive", "m", "true"),
        ({"toml": STUDY.replace("= 320.0", "320.0")}, "line 4", "", "TOML"),
    ],
)
def test_faults_are_told_where_they_are(
    server: Running, content: dict[str, Any], table: str, key: str, words: str
) -> None:
    """Law: a fault has its table and its key, and the words of the reader of study files."""
    answer = server.ask("POST", "/api/model", content)
    assert answer.status == 422
    fault = answer.json["error"]["faults"][0]
    assert (fault["table"], fault["key"]) == (table, key)
    assert words in fault["message"]
    assert fault["message"] in answer.json["error"]["message"]


@pytest.mark.parametrize(
    "content",
    [{}, {"spec": None}, {"spec": {}, "toml": ""}, {"spec": []}, {"toml": 1}, {"spec": {}, "x": 1}],
)
def test_bodies_have_their_form(server: Running, content: dict[str, Any]) -> None:
    """Law: a body of another form is refused by what is wrong with it."""
    answer = server.ask("POST", "/api/model", content)
    assert answer.status == 422
    assert answer.json["error"]["message"]


def test_what_is_seen_can_be_made_again(server: Running) -> None:
    """Law: the lines and the study file are those of the package, for the length that is seen."""
    answer = server.ask("POST", "/api/reproduce", {"spec": SPEC})
    assert answer.json == reproduction(SPEC)
    answer = server.ask("POST", "/api/reproduce", {"spec": SPEC, "periods": 7})
    assert answer.json == reproduction(SPEC, periods=7)
    assert "periods=7" in answer.json["python"]


@pytest.mark.parametrize("language", EXPORT_LANGUAGES)
def test_equations_can_be_taken_along(server: Running, language: str) -> None:
    """Law: the files are those of the function, in every language."""
    answer = server.ask("POST", "/api/export", {"spec": SPEC, "language": language})
    subject = read_subject(SPEC)
    assert answer.json == {"files": rm.export(subject.system, subject.drive, language)}


def test_an_unknown_language_is_refused(server: Running) -> None:
    """Law: the message has the languages that there are."""
    answer = server.ask("POST", "/api/export", {"spec": SPEC, "language": "fortran"})
    assert answer.status == 422
    assert answer.json["error"]["faults"][0]["key"] == "language"
    assert "matlab" in answer.json["error"]["message"]


@pytest.mark.parametrize(("form", "ending"), [("netcdf", "nc"), ("csv", "csv")])
def test_data_are_those_of_the_engine(
    server: Running, form: str, ending: str, tmp_path: Path
) -> None:
    """Law: the file holds what `simulate` gives, from the start that is seen."""
    spec = {**SPEC, "initial": {"stretch_rate": 0.1}}
    answer = server.ask("POST", "/api/data", {"spec": spec, "periods": 3, "format": form})
    assert answer.status == 200
    assert f'filename="motion.{ending}"' in answer.headers["content-disposition"]
    path = tmp_path / f"motion.{ending}"
    path.write_bytes(answer.body)
    subject = read_subject(SPEC)
    expected = rm.simulate(subject.system, subject.drive, periods=3, initial=[1.0, 0.1])
    found = rm.load(path)
    if form == "netcdf":
        xr.testing.assert_identical(found, expected)
    else:
        np.testing.assert_array_equal(found.stretch.values, expected.stretch.values)


def test_data_need_one_length(server: Running) -> None:
    """Law: neither and both lengths are refused in the words of the verb."""
    for length in ({}, {"periods": 3, "duration": 2.0}):
        answer = server.ask("POST", "/api/data", {"spec": SPEC, **length})
        assert answer.status == 422
        assert "duration" in answer.json["error"]["message"]


@pytest.mark.parametrize("path", ["/fields/0123.js", "/fields/x.txt", "/api", "/api/", "/favicon"])
def test_other_addresses_are_not_found(server: Running, path: str) -> None:
    """Law: what is not there is told in words, also a module of an earlier server."""
    answer = server.ask("GET", path)
    assert answer.status == 404
    assert answer.json["error"]["message"]


def test_jobs_are_those_of_the_verbs(server: Running) -> None:
    """Law: what comes through the socket is what the verb gives."""
    with server.socket() as socket:
        result = result_of(socket, "classify", periods=100)
    subject = read_subject(SPEC)
    regime = rm.classify(subject.system, subject.drive, periods=100)
    (series,) = result["series"]
    assert series["regime"]["values"] == str(regime.regime.values)
    assert series["exponent"]["values"] == float(regime.exponent)


def test_a_job_that_does_not_exist_is_refused(server: Running) -> None:
    """Law: the message has the jobs that there are."""
    with server.socket() as socket:
        error = result_of(socket, "fly")
    assert error["status"] == 422
    assert "frequency_response" in error["message"]
