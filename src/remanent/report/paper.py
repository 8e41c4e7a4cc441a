"""The paper, reproduced and audited: everything that ``remanent paper`` does."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from remanent.report import evidence_figures, figures, page, reconstruction, tolerance
from remanent.report.audit import Verdict, audit
from remanent.report.evidence import Evidence, gather
from remanent.report.settings import LAWS, PRESTRESSES, REFERENCE, TEMPERATURES
from remanent.results import store

#: Called with the name of a stage and the share of the whole that is done.
Report = Callable[[str, float], None]
#: Width of the figures in the page is set by the page; PNGs are for slides.
_DPI = 200


@dataclass(frozen=True)
class Paper:
    """All that was computed.

    Attributes
    ----------
    evidence
        For the reference setting.
    verdicts
        Of every claim.
    datasets, figures
        By name.
    """

    evidence: Evidence
    verdicts: list[Verdict]
    datasets: Mapping[str, xr.Dataset]
    figures: Mapping[str, Figure]


def reproduce(report: Report = lambda stage, share: None) -> Paper:
    """Compute figures, reconstruction and audit."""
    report("figures 2 to 6", 0.0)
    reference = gather(REFERENCE)
    with ThreadPoolExecutor(max_workers=1) as aside:
        script = aside.submit(_scripts, reference)
        valleys = _reconstruct(report)
        sections, drift = script.result()
    report("audit", 0.6)
    least = {law: float(valley["misfit"].min()) for law, valley in valleys.items()}
    reference = replace(reference, misfits=least)
    settings = reconstruction.admissible(valleys["sin2"], "sin2")
    with ThreadPoolExecutor(max_workers=2) as together:
        others = list(together.map(lambda setting: gather(setting, tolerance=1e-7), settings))
    verdicts = audit(reference, others)
    report("pictures", 0.75)
    datasets = _datasets(reference, valleys, sections, drift)
    return Paper(reference, verdicts, datasets, _figures(datasets))


def write(paper: Paper, out: Path) -> Path:
    """Write page, JSON, pictures and data into a folder; return the page's path."""
    out.mkdir(parents=True, exist_ok=True)
    for folder in ("figures", "data"):
        (out / folder).mkdir(exist_ok=True)
    drawings = {}
    for name, figure in paper.figures.items():
        figure.savefig(out / "figures" / f"{name}.svg", metadata={"Date": None})
        figure.savefig(out / "figures" / f"{name}.png", dpi=_DPI)
        drawings[name] = (out / "figures" / f"{name}.svg").read_text(encoding="utf-8")
    for name, dataset in paper.datasets.items():
        store.write(dataset, out / "data" / f"{name}.nc")
    summary = summarise(paper)
    (out / "report.json").write_text(
        json.dumps(summary, indent=2, ensure_ascii=False) + "\n", encoding="utf-8"
    )
    target = out / "report.html"
    target.write_text(page.render(paper, summary, drawings), encoding="utf-8")
    return target


def summarise(paper: Paper) -> dict[str, Any]:
    """What programs read: resonances and claims."""
    response = paper.evidence.response.transpose("prestress", "temperature", ...)
    resonances = [
        {
            "temperature": t,
            "prestress": s,
            "omega": float(response["resonance"][i, j]),
            "error": float(response["resonance_error"][i, j]),
            "published": float(response["published"][i, j]),
            "difference": float(response["resonance"][i, j] - response["published"][i, j]),
        }
        for i, s in enumerate(PRESTRESSES)
        for j, t in enumerate(TEMPERATURES)
    ]
    claims = [
        {
            "id": v.claim.id,
            "claim": v.claim.claim,
            "verdict": v.verdict,
            "evidence": v.evidence,
            "figure": f"figures/{v.claim.figure}.svg",
        }
        for v in paper.verdicts
    ]
    return {
        "setting": str(REFERENCE),
        "versions": paper.evidence.response.attrs["versions"],
        "resonances": resonances,
        "claims": claims,
    }


def _scripts(reference: Evidence) -> tuple[xr.Dataset, xr.Dataset]:
    return tolerance.section_story(reference), tolerance.energy_story(REFERENCE)


def _reconstruct(report: Report) -> dict[str, xr.Dataset]:
    """Misfits of every law; the paper's own reading over every window."""
    windows = {law: (100.0,) for law in LAWS} | {"sin2": reconstruction.WINDOWS}
    total, done = sum(map(len, windows.values())), 0
    found = {}
    for law, lengths in windows.items():

        def step() -> None:
            nonlocal done
            done += 1
            report("reconstruction of what is unstated", 0.1 + 0.5 * done / total)

        every = 1 if law == "sin2" else 2
        found[law] = reconstruction.misfits(law, lengths, step, every=every)
    return found


def _datasets(
    e: Evidence,
    valleys: Mapping[str, xr.Dataset],
    sections: xr.Dataset,
    drift: xr.Dataset,
) -> dict[str, xr.Dataset]:
    return {
        "constant_load": e.constant,
        "landscape": e.landscape,
        "frequency_response": e.response,
        "periodic_load": e.motion,
        "sections": e.section,
        "neighbours": e.neighbour,
        "valley_windows": valleys["sin2"],
        "valley_laws": xr.concat(
            [valleys[law].sel(window=[100.0]) for law in LAWS],
            "law",
            join="inner",
            combine_attrs="override",
        ),
        "tolerance_sections": sections,
        "tolerance_energy": drift,
    }


def _figures(data: Mapping[str, xr.Dataset]) -> dict[str, Figure]:
    motion, section = data["periodic_load"], data["sections"].isel(period=slice(0, 501))
    found = {
        "figure_2": figures.figure_2(data["constant_load"]),
        "figure_3": figures.figure_3(data["constant_load"]),
        "figure_4": figures.figure_4(data["frequency_response"]),
    }
    for name, s in zip(("figure_5", "figure_6"), PRESTRESSES, strict=True):
        found[name] = figures.figure_5_or_6(motion.sel(prestress=s), section.sel(prestress=s))
    return found | {
        "landscapes": evidence_figures.landscapes(data["landscape"]),
        "tolerance": evidence_figures.tolerance_story(
            data["tolerance_sections"], data["tolerance_energy"]
        ),
        "valley": evidence_figures.valley(data["valley_windows"]),
        "laws": evidence_figures.valley(data["valley_laws"]),
    }


