"""What ``remanent paper`` writes: complete, self-contained, readable by other tools."""

from __future__ import annotations

import json
import os
import pickle
import re
from html import unescape
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import h5py
import numpy as np
import pytest
from filelock import FileLock
from matplotlib.image import imread

import remanent as rm
from remanent.report import reconstruction
from remanent.report.contents import Paper
from remanent.report.drawings import DRAWINGS
from remanent.report.live import LIVE_PAGE_NAME, live_links, live_page
from remanent.report.paper import reproduce, write_report

ROOT = Path(__file__).parents[2]
VERDICTS = {"supported", "contradicted", "depends"}
SPLIT = {"3", "6", "8", "12", "14", "16", "17"}


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Paper, Path]:
    """The report and its folder, on a coarser map of the unstated choices.

    It is made once for all processes of a run of the tests, by the first that needs it.
    """
    shared = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        shared = shared.parent
    out, kept = shared / "paper", shared / "paper.pickle"
    with FileLock(shared / "paper.lock"):
        if not kept.exists():
            reproduction = reproduce_coarsely()
            write_report(reproduction, out)
            kept.write_bytes(pickle.dumps(reproduction))
    reproduction = pickle.loads(kept.read_bytes())  # noqa: S301 - written above
    return reproduction, out


def reproduce_coarsely() -> Paper:
    """The paper on few of the values that the article leaves open."""
    with pytest.MonkeyPatch.context() as patch:
        coarse = {
            "REFERENCE_TEMPERATURES": [289.0, 293.0, 297.0],
            "ROOT_LOAD_AMPLITUDES": [0.36, 0.38, 0.4],
            "WINDOW_LENGTHS": (100.0,),
        }
        for name, values in coarse.items():
            patch.setattr(reconstruction, name, np.array(values))
        return reproduce()


@pytest.fixture(scope="module")
def summary(made: tuple[Paper, Path]) -> Any:
    return json.loads((made[1] / "report.json").read_text(encoding="utf-8"))


def verdict(summary: Any, number: str) -> str:
    """The verdict on one claim."""
    (text,) = [c["verdict"] for c in summary["claims"] if c["id"] == number]
    return str(text)


def test_the_page_about_the_article_says_what_the_audit_finds(summary: Any) -> None:
    """The kept verdicts are those of the audit made anew, and so are the resonances.

    Where it fails: ``remanent paper``, then ``python docs/make_explanations.py article``.
    """
    kept = json.loads((ROOT / "docs" / "results" / "audit.json").read_text("utf-8"))
    for key in ("id", "claim", "verdict"):
        assert [c[key] for c in kept["claims"]] == [c[key] for c in summary["claims"]]
    for ours, theirs in zip(kept["resonances"], summary["resonances"], strict=True):
        assert ours["omega"] == pytest.approx(theirs["omega"], abs=1e-6)


def test_six_resonances_agree_with_the_published_ones(summary: Any) -> None:
    """All six are within 0.01 of the published digits; the table says by how much they differ."""
    assert len(summary["resonances"]) == 6
    for r in summary["resonances"]:
        assert abs(r["omega"] - r["published"]) <= 0.01
        assert r["difference"] == pytest.approx(r["omega"] - r["published"])


def test_every_claim_has_one_verdict_with_evidence(summary: Any) -> None:
    """The twenty statements of [Thermal] are all judged, each once, by numbers."""
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
    """Law: energy balance without dissipation, closed forms of statics, modulus = θ μ."""
    assert verdict(summary, number) == expected


def test_opposite_statements_do_not_both_hold(summary: Any) -> None:
    """Of a statement and its opposite one is supported and one contradicted."""
    assert {verdict(summary, "12a"), verdict(summary, "12b")} == {"supported", "contradicted"}


def test_the_page_needs_nothing_else(made: tuple[Paper, Path]) -> None:
    """Every picture is inside the page, and every claim has its place and its picture."""
    html = (made[1] / "report.html").read_text(encoding="utf-8")
    sources = list(map(unescape, re.findall(r"(?:src|href)=\"([^\"]*)\"", html)))
    assert sources
    links = [address for _, address in live_links()]
    assert len(links) == 6
    for source in sources:
        assert source.startswith(("data:", "#")) or source in links
    for name in DRAWINGS:
        assert f'id="{name}"' in html
    for v in made[0].verdicts:
        assert f'id="claim-{v.claim.id}"' in html
        assert v.claim.picture_name in DRAWINGS


def test_the_live_page_is_beside_the_report(made: tuple[Paper, Path]) -> None:
    """Law: it is one file; the links give it the motions of figures 5 and 6."""
    text = (made[1] / LIVE_PAGE_NAME).read_text(encoding="utf-8")
    assert text == live_page()
    assert "default-src 'none'" in text
    found = {tuple(map(float, re.findall(r"=([\d.]+)", address))) for _, address in live_links()}
    wanted = {(t, s, w) for s, w in ((0.0, 1.25), (1.0, 1.08)) for t in (250.0, 350.0, 400.0)}
    assert found == wanted


def test_pictures_come_as_vectors_and_as_points(made: tuple[Paper, Path]) -> None:
    """Each picture is a well-formed SVG and a PNG."""
    assert len(DRAWINGS) > 5
    for name in DRAWINGS:
        root = ElementTree.parse(made[1] / "figures" / f"{name}.svg").getroot()
        assert root.tag == "{http://www.w3.org/2000/svg}svg"
        assert len(list(root.iter("{http://www.w3.org/2000/svg}path"))) > 10
        pixels = imread(made[1] / "figures" / f"{name}.png")
        assert pixels[..., :3].std() > 0.01  # not one colour


def test_matlab_can_read_the_data(made: tuple[Paper, Path]) -> None:
    """netCDF without complex, boolean or string variables and without groups."""
    assert made[0].datasets
    for name in made[0].datasets:
        with h5py.File(made[1] / "data" / f"{name}.nc") as file:
            assert len(file) > 0
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


def test_all_six_motions_are_quasi_periodic_with_evidence(summary: Any) -> None:
    """Claims 15 to 18 rest on labels that independent indicators agree on."""
    assert len(summary["regimes"]) == 6
    for motion in summary["regimes"]:
        assert motion["regime"] == "quasi-periodic"
        assert motion["margin"] > 1.0
        assert abs(motion["exponent"]) < 0.01
    for number in ("15", "17a", "18"):
        assert verdict(summary, number) == "contradicted"
    for number in ("16", "17b"):
        assert verdict(summary, number) == "supported"


def test_two_centres_and_a_saddle_stand_behind_every_peak(summary: Any) -> None:
    """Undamped, multipliers of each orbit are a pair whose product is 1."""
    assert len(summary["resonances"]) == 6
    for peak in summary["resonances"]:
        orbits = [
            orbit
            for orbit in summary["orbits"]
            if all(orbit[name] == peak[name] for name in ("temperature", "prestress", "omega"))
        ]
        assert sorted(orbit["stability"] for orbit in orbits) == ["elliptic", "elliptic", "saddle"]
        for orbit in orbits:
            first, second = (complex(*pair) for pair in orbit["multipliers"])
            assert abs(first * second - 1.0) < 1e-8
            assert orbit["residual"] < 1e-8


def test_the_jump_lies_between_bounds_below_the_fold(summary: Any) -> None:
    """The largest amplitude of a finite window lies just above the jump, below the fold."""
    jump = summary["jump"]
    assert jump["error"] <= 1e-9
    assert jump["fold_error"] <= 1e-8
    (peak,) = [
        r["omega"]
        for r in summary["resonances"]
        if all(r[name] == jump[name] for name in ("temperature", "prestress"))
    ]
    assert jump["omega"] < peak < jump["fold"]
    assert peak - jump["omega"] < 1e-3


def test_folds_scale_with_temperature(summary: Any) -> None:
    """Without prestress they are one curve in (b²/θ, ω/√θ); another verb follows it.

    Law: Reversal and scaling.
    """
    folds = [f for f in summary["folds"] if f["prestress"] == 0.0]
    assert len(folds) == 3
    for fold in folds:
        theta = fold["temperature"] / 293.0
        at = rm.continue_orbit(
            rm.Actuator(),
            rm.SineSquared(0.4 / theta**0.5, (fold["omega"] - 0.005) / theta**0.5),
            "omega",
            ((fold["omega"] - 0.01) / theta**0.5, (fold["omega"] + 0.01) / theta**0.5),
            initial=(fold["stretch"], 0.0),
        )
        assert float(at.special_omega[0]) * theta**0.5 == pytest.approx(fold["omega"], abs=1e-8)


def test_chaos_is_far_from_the_published_motions(summary: Any) -> None:
    """Each chaotic point has an exponent above its error; their least load is well above."""
    chaos = summary["chaos"]
    assert sum(chaos["counts"].values()) == len(chaos["b"]) * len(chaos["omega"])
    assert chaos["chaotic"]
    for point in chaos["chaotic"]:
        assert point["exponent"] > point["exponent_error"] > 0.0
        assert point["margin"] > 1.0
    assert chaos["least_b"] > 2.0 * max(motion["b"] for motion in chaos["paper"])
