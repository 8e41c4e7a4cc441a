"""What ``remanent paper`` writes: complete, self-contained, readable by other tools."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from remanent.report import reconstruction
from remanent.report.drawings import DRAWINGS
from remanent.report.paper import Paper, reproduce, write

VERDICTS = {"supported", "contradicted", "depends"}
SPLIT = {"3", "6", "8", "12", "14", "16", "17"}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Paper, Path]:
    """The whole report, on a coarser map of the unstated choices."""
    with pytest.MonkeyPatch.context() as patch:
        coarse = {
            "REFERENCE_TEMPERATURES": [289.0, 293.0, 297.0],
            "AMPLITUDES": [0.36, 0.38, 0.4],
            "WINDOWS": (100.0,),
        }
        for name, values in coarse.items():
            patch.setattr(reconstruction, name, np.array(values))
        found = reproduce()
    out = tmp_path_factory.mktemp("paper")
    write(found, out)
    return found, out


@pytest.fixture(scope="module")
def summary(made: tuple[Paper, Path]) -> Any:
    return json.loads((made[1] / "report.json").read_text(encoding="utf-8"))


def verdict(summary: Any, number: str) -> str:
    """The verdict on one claim."""
    (found,) = [c["verdict"] for c in summary["claims"] if c["id"] == number]
    return str(found)


def test_six_resonances_agree_with_the_published_ones(summary: Any) -> None:
    assert len(summary["resonances"]) == 6
    for r in summary["resonances"]:
        assert abs(r["omega"] - r["published"]) <= 0.01
        assert r["difference"] == pytest.approx(r["omega"] - r["published"])


def test_every_claim_has_one_verdict_with_evidence(summary: Any) -> None:
    ids = [c["id"] for c in summary["claims"]]
    assert len(set(ids)) == len(ids)
    assert {re.sub(r"[a-z]$", "", i) for i in ids} == {str(n) for n in range(1, 21)}
    assert {i[:-1] for i in ids if i[-1].isalpha()} <= SPLIT
    for claim in summary["claims"]:
        assert claim["verdict"] in VERDICTS
        assert re.search(r"\d", claim["evidence"])


@pytest.mark.parametrize(
    ("number", "expected"),
    [
        ("1", "supported"),  # energy is conserved: an identity of the model
        ("2", "contradicted"),  # no dissipation, no settling
        ("5", "contradicted"),  # modulus = theta mu, exactly
        ("7", "supported"),  # by the closed forms for equilibria
        ("13", "contradicted"),  # no dissipation at any temperature
        ("15", "contradicted"),  # a clean closed curve when integrated accurately
        ("19", "contradicted"),
    ],
)
def test_verdicts_that_follow_from_identities(summary: Any, number: str, expected: str) -> None:
    assert verdict(summary, number) == expected


def test_opposite_statements_do_not_both_hold(summary: Any) -> None:
    assert {verdict(summary, "12a"), verdict(summary, "12b")} == {"supported", "contradicted"}


def test_the_page_needs_nothing_else(made: tuple[Paper, Path]) -> None:
    html = (made[1] / "report.html").read_text(encoding="utf-8")
    sources = re.findall(r"(?:src|href)=\"([^\"]*)\"", html)
    assert sources
    for source in sources:
        assert source.startswith(("data:", "#"))
    for name in DRAWINGS:
        assert f'id="{name}"' in html
    for v in made[0].verdicts:
        assert f'id="claim-{v.claim.id}"' in html
        assert v.claim.figure in DRAWINGS


def test_pictures_come_as_vectors_and_as_points(made: tuple[Paper, Path]) -> None:
    for name in DRAWINGS:
        assert (made[1] / "figures" / f"{name}.svg").stat().st_size > 1000
        assert (made[1] / "figures" / f"{name}.png").stat().st_size > 1000


def test_matlab_can_read_the_data(made: tuple[Paper, Path]) -> None:
    """netCDF without complex, boolean or string variables and without groups."""
    for name in made[0].datasets:
        with h5py.File(made[1] / "data" / f"{name}.nc") as file:
            for variable in file.values():
                assert isinstance(variable, h5py.Dataset)
                assert variable.dtype.kind in "iuf"


def test_converged_and_default_tolerances_tell_different_stories(made: tuple[Paper, Path]) -> None:
    """The published disorder is the integrator's: energy drifts, the section is no curve."""
    data = made[0].datasets
    drift = abs(data["tolerance_energy"]["energy_drift"]).max("time")
    ours, script = (drift.sel(solver=s).values for s in drift["solver"].values)
    assert (ours < 1e-10).all()
    assert (script > 1e4 * ours).all()
