"""The paper, reproduced and audited: everything that ``remanent paper`` does."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import xarray as xr

from remanent.report import page, reconstruction, tolerance
from remanent.report.audit import Verdict, audit
from remanent.report.drawings import DRAWINGS, draw
from remanent.report.evidence import Evidence, gather
from remanent.report.processes import pool
from remanent.report.settings import LAWS, PRESTRESSES, REFERENCE, TEMPERATURES
from remanent.results import store

#: Called with the name of a stage and the share of the whole that is done.
Report = Callable[[str, float], None]


@dataclass(frozen=True)
class Paper:
    """All that was computed.

    Attributes
    ----------
    evidence
        For the reference setting.
    verdicts
        Of every claim.
    datasets
        By name.
    """

    evidence: Evidence
    verdicts: list[Verdict]
    datasets: Mapping[str, xr.Dataset]


def _silent(_stage: str, _share: float) -> None:
    pass


def reproduce(report: Report = _silent, *, processes: int = 1) -> Paper:
    """Compute the data of all figures, the reconstruction and the audit.

    Parameters
    ----------
    report
        Called with the name of a stage and the share of the whole that is done.
    processes
        See :func:`remanent.report.processes.pool`.
    """
    report("figures 2 to 6", 0.0)
    reference = gather(REFERENCE)
    with pool(processes) as aside:
        script = aside.submit(_scripts, reference)
        valleys = _reconstruct(report)
        sections, drift = script.result()
    report("audit", 0.6)
    least = {law: float(valley["misfit"].min()) for law, valley in valleys.items()}
    reference = replace(reference, misfits=least)
    settings = reconstruction.admissible(valleys["sin2"], "sin2")
    with ThreadPoolExecutor(max_workers=2) as together:
        others = list(together.map(lambda setting: gather(setting, 1e-7, every=3), settings))
    verdicts = audit(reference, others)
    return Paper(reference, verdicts, _datasets(reference, valleys, sections, drift))


def write(paper: Paper, out: Path, *, processes: int = 1) -> Path:
    """Write page, JSON, pictures and data into a folder; return the page's path.

    Parameters
    ----------
    processes
        See :func:`remanent.report.processes.pool`.
    """
    for folder in ("figures", "data"):
        (out / folder).mkdir(parents=True, exist_ok=True)
    _draw(paper.datasets, out / "figures", processes)
    for name, dataset in paper.datasets.items():
        store.write(dataset, out / "data" / f"{name}.nc")
    summary = summarise(paper)
    (out / "report.json").write_text(
        json.dumps(summary, indent=2, ensure_ascii=False) + "\n", encoding="utf-8"
    )
    drawings = {n: (out / "figures" / f"{n}.svg").read_text(encoding="utf-8") for n in DRAWINGS}
    target = out / "report.html"
    target.write_text(page.render(paper, summary, drawings), encoding="utf-8")
    return target


def _draw(datasets: Mapping[str, xr.Dataset], folder: Path, processes: int) -> None:
    """Draw every picture, slow ones first."""
    jobs = [(name, {k: datasets[k] for k in DRAWINGS[name].needs}, folder) for name in DRAWINGS]
    with pool(processes) as others:
        for done in [others.submit(draw, *job) for job in jobs]:
            done.result()


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
    windows = dict.fromkeys(LAWS, (100.0,)) | {"sin2": reconstruction.WINDOWS}
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
