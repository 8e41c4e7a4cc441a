"""What a page can begin with: it can be shown, and the article's numbers are the report's."""

from __future__ import annotations

from typing import Any

import pytest

import remanent as rm
from remanent.page.model import page_model_of_spec
from remanent.page.presets import presets
from remanent.report.settings import (
    MOTION_FREQUENCIES,
    PRESTRESSES,
    REFERENCE_SETTING,
    TEMPERATURES,
)
from remanent.web.subjects import initial_state, read_subject

PRESETS = {one["id"]: one for one in presets()}


def test_names_are_given_once() -> None:
    """Law: an address means one preset; titles differ too."""
    assert len(PRESETS) == len(presets())
    assert len({one["title"] for one in PRESETS.values()}) == len(PRESETS)


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_can_be_shown(name: str) -> None:
    """Law: it is read, and it says how long its motion is."""
    preset = PRESETS[name]
    model = page_model_of_spec(preset["spec"])
    periodic = model.description["drive"]["periodic"]
    assert set(preset["view"]) == {"periods" if periodic else "duration", "views"}
    assert not model.description["warnings"]
    assert preset["text"].endswith(".")


@pytest.mark.parametrize("figure", ["2", "3", "4", "5", "6"])
def test_figures_of_the_article_have_its_numbers(figure: str) -> None:
    """Law: temperature, prestress, frequency and load are those of the report."""
    chosen = [one for name, one in PRESETS.items() if name.startswith(f"figure-{figure}")]
    assert chosen
    for preset in chosen:
        actuator, drive = preset["spec"]["actuator"], preset["spec"]["drive"]
        assert actuator["temperature"] in TEMPERATURES
        assert actuator["prestress"] in PRESTRESSES
        if drive["kind"] == "Constant":
            assert drive["m"] == pytest.approx(REFERENCE_SETTING.b**2)
        else:
            row = PRESTRESSES.index(actuator["prestress"])
            assert drive["omega"] == MOTION_FREQUENCIES[row]
            assert drive["b"] == REFERENCE_SETTING.b


@pytest.mark.parametrize(
    ("name", "regime"), [("quasi-periodic", "quasi-periodic"), ("two-wells", "chaotic"),
                         ("damped-resonance", "periodic")],
)  # fmt: skip
def test_presets_are_what_they_are_called(name: str, regime: str) -> None:
    """Law: the engine's classification agrees with the title."""
    spec: dict[str, Any] = PRESETS[name]["spec"]
    from remanent.page.spec import read_spec

    system, drive, _ = read_spec(spec)
    assert str(rm.classify(system, drive, periods=500)["regime"].item()) == regime


PERIODIC = [name for name, one in PRESETS.items() if "periods" in one["view"]]


@pytest.mark.slow
@pytest.mark.parametrize("name", PERIODIC)
def test_presets_begin_with_a_regime(name: str) -> None:
    """Law: the run that a preset begins with is long enough to tell its regime."""
    subject = read_subject(PRESETS[name]["spec"])
    regime = rm.classify(
        subject.system, subject.drive, initial=initial_state(subject),
        periods=PRESETS[name]["view"]["periods"],
    )  # fmt: skip
    assert str(regime["regime"].item()) in ("periodic", "quasi-periodic", "chaotic")
