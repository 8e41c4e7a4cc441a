"""Stores that are opened: their chart, their points, and those that are broken."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from remanent.studies.sweep.store import open_store
from remanent.web.errors import RefusalError
from remanent.web.opening import open_source
from remanent.web.stores import point_spec, store_view
from remanent.web.subjects import read_subject
from tests.unit.web.server import running

B, OMEGA = [0.2, 0.4, 0.6], [1.0, 1.7]
#: A name that a page must not take for markup.
HOSTILE = "<img src=x onerror=alert(1)>"


def sweep(path: Path, over: dict[str, Any], **options: Any) -> xr.Dataset:
    """A small chart of a damped actuator, in a store."""
    system = rm.Actuator(temperature=350.0, dissipation=rm.Rayleigh(0.1))
    result: xr.Dataset = rm.sweep(
        system, rm.SineSquared(0.4, 1.25), over, "classify", store=path, periods=100, **options
    )
    return result


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("stores") / "chart.zarr"
    sweep(path, {"b": B, "omega": OMEGA})
    return path


@pytest.fixture
def broken(store: Path, tmp_path: Path) -> Path:
    """A copy of which a chunk is damaged."""
    path = tmp_path / "broken.zarr"
    shutil.copytree(store, path)
    (chunk,) = (one for one in (path / "margin" / "c").rglob("*") if one.is_file())
    content = bytearray(chunk.read_bytes())
    content[len(content) // 2] ^= 1
    chunk.write_bytes(content)
    return path


def test_the_chart_is_what_the_store_holds(store: Path) -> None:
    """Law: grid, variables and status are those of the result, with null for NaN."""
    result = rm.load(store)
    view = json.loads(json.dumps(store_view(store), allow_nan=False))
    assert view["title"] == "chart.zarr"
    assert view["verb"] == "classify"
    assert view["dims"] == [{"name": "b", "size": 3}, {"name": "omega", "size": 2}]
    assert view["coords"]["b"]["values"] == B
    assert view["variables"]["regime"]["values"] == result.regime.values.tolist()
    margin = np.array(view["variables"]["margin"]["values"], dtype=np.float64)
    np.testing.assert_array_equal(margin, result.margin.values)
    assert view["status"] == {"dims": ["b", "omega"], "values": [["ok"] * 2] * 3}


def test_a_point_is_the_study_there(store: Path) -> None:
    """Law: the spec of a point has the values of the grid at its place, and the rest as it was."""
    for i, b in enumerate(B):
        for j, omega in enumerate(OMEGA):
            subject = read_subject(point_spec(store, [i, j]))
            assert subject.drive == rm.SineSquared(b, omega)
            assert subject.system == open_store(store).study.system


@pytest.mark.parametrize("index", [[], [0], [3, 0], [0, 2], [-1, 0], [0, 0, 0]])
def test_other_points_are_refused(store: Path, index: list[int]) -> None:
    """Law: an index outside the grid is refused, with the size of the grid."""
    with pytest.raises(RefusalError, match="3 x 2"):
        point_spec(store, index)


def test_parts_and_starts_are_points_too(tmp_path: Path) -> None:
    """Law: values of parts and of the state at the start are found by their names."""
    path = tmp_path / "parts.zarr"
    over = {"dissipation.0.eta": [0.1, 0.2], "initial.stretch": [1.0, 1.2]}
    sweep(path, over, initial=[1.0, 0.3])
    subject = read_subject(point_spec(path, [1, 1]))
    assert subject.system.parameter_values()["dissipation.0.eta"] == 0.2
    assert subject.initial == {"stretch": 1.2, "stretch_rate": 0.3}


def test_a_store_opens_with_its_study(store: Path) -> None:
    """Law: the page of a store begins with the study itself."""
    opened = open_source(store)
    assert opened.store == store
    assert read_subject(opened.spec).drive == rm.SineSquared(0.4, 1.25)


def test_equilibria_are_looked_at_under_their_load(tmp_path: Path) -> None:
    """Law: a study without a drive has the constant load of its points."""
    path = tmp_path / "rest.zarr"
    rm.sweep(rm.Actuator(), None, {"m": [0.0, 0.2]}, "equilibria", store=path)
    assert read_subject(point_spec(path, [1])).drive == rm.Constant(0.2)


def test_what_is_no_store_is_refused(tmp_path: Path, store: Path) -> None:
    """Law: a folder that is none, and one without its description, are refused by name."""
    torn = tmp_path / "torn.zarr"
    shutil.copytree(store, torn)
    (torn / "zarr.json").write_text("{", "utf-8")
    for path in (tmp_path, torn):
        with pytest.raises(rm.InputError, match="must be a store"):
            open_source(path)


def test_a_damaged_store_says_so(broken: Path) -> None:
    """Law: damage is told with what finds and mends it."""
    with pytest.raises(rm.RemanentError, match="remanent verify"):
        store_view(broken)


def test_stores_through_the_server(store: Path, broken: Path) -> None:
    """Law: chart, points and damage are told by the server too, without the path of the store."""
    with running(open_source(store)) as server:
        start = server.ask("GET", "/api/start").json
        assert start["store"] == {"title": "chart.zarr"}
        chart = server.ask("GET", "/api/store").json
        assert chart == json.loads(json.dumps(store_view(store)))
        point = server.ask("POST", "/api/store/point", {"index": [2, 1]})
        assert point.json == {"spec": point_spec(store, [2, 1])}
        outside = server.ask("POST", "/api/store/point", {"index": [9, 9]})
        assert outside.status == 422
        assert str(store.parent) not in json.dumps([start, chart, point.json, outside.json])
    with running(open_source(broken)) as server:
        answer = server.ask("GET", "/api/store")
        assert answer.status == 422
        assert "remanent verify" in answer.json["error"]["message"]
        assert str(broken.parent) not in answer.json["error"]["message"]
        assert broken.name in answer.json["error"]["message"]
        assert str(broken.parent) not in answer.body.decode()
        assert server.ask("GET", "/api/start").status == 200


def test_without_a_store_there_is_no_chart() -> None:
    """Law: a page that opened none is told how to open one."""
    with running() as server:
        for method, path in (("GET", "/api/store"), ("POST", "/api/store/point")):
            content = {"index": [0]} if method == "POST" else None
            answer = server.ask(method, path, content)
            assert answer.status == 404
            assert "remanent explore STORE" in answer.json["error"]["message"]


def test_names_in_stores_are_data(tmp_path: Path) -> None:
    """Law: a name that looks like markup is sent as text of JSON, which no browser renders."""
    path = tmp_path / f"{HOSTILE}.zarr"
    case = xr.DataArray([0.3, 0.4], dims="case", coords={"case": [HOSTILE, "</script>"]})
    sweep(path, {"b": case})
    with running(open_source(path)) as server:
        for place in ("/api/start", "/api/store"):
            answer = server.ask("GET", place)
            assert answer.headers["content-type"] == "application/json"
            assert answer.headers["x-content-type-options"] == "nosniff"
        assert answer.json["coords"]["case"]["values"] == [HOSTILE, "</script>"]
        assert answer.json["title"] == path.name
        page = server.ask("GET", "/")
        assert HOSTILE.encode() not in page.body


@pytest.mark.slow
def test_hardware_that_varies_is_refused(tmp_path: Path) -> None:
    """Law: a study over what the scales are made of has no one page, and says so."""
    path = tmp_path / "hardware.zarr"
    actuator = rm.Actuator.from_si(
        shear_modulus="100 kPa", density="2000 kg/m^3", half_length="5 mm", half_thickness="1 mm",
        remanence="100 mT",
    )  # fmt: skip
    over = {"shear_modulus": [90e3, 110e3]}
    rm.sweep(actuator, rm.SineSquared(0.4, 1.25), over, "classify", store=path, periods=100)
    assert store_view(path)["dims"] == [{"name": "shear_modulus", "size": 2}]
    with pytest.raises(RefusalError, match="varies shear_modulus"):
        point_spec(path, [0])
