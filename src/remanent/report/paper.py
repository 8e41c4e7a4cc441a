"""[Thermal], reproduced and audited: everything that ``remanent paper`` does."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import xarray as xr

from remanent.report import dynamics, live, page, reconstruction, tolerance
from remanent.report.audit import ClaimVerdict, audit
from remanent.report.contents import Paper
from remanent.report.drawings import DRAWINGS, draw_files
from remanent.report.evidence import ClaimEvidence, compute_regimes, gather_evidence
from remanent.report.processes import work_executor
from remanent.report.settings import (
    FORCING_LAWS,
    PRESTRESSES,
    REFERENCE_SETTING,
    TEMPERATURES,
    Setting,
)
from remanent.results import netcdf

#: Called with the name of a stage and the share of all work that is done.
ProgressCallback = Callable[[str, float], None]
#: Tolerance of the reference setting.
_REFERENCE_SETTING_TOLERANCE = 1e-8
#: Tolerance of the further settings.
_ALTERNATIVE_SETTING_TOLERANCE = 1e-7
#: Further settings tabulate responses at every so many frequencies.
_ALTERNATIVE_SETTING_FREQUENCY_STRIDE = 3
#: Length of the response window for which forcing laws are compared.
_LAW_COMPARISON_WINDOW = 100.0
#: Name of the forcing law that is mapped over every window.
_PUBLISHED_LAW_NAME = "sin2"


def _ignore_progress(_stage: str, _share: float) -> None:
    pass


def reproduce(report: ProgressCallback = _ignore_progress, *, processes: int = 1) -> Paper:
    """Compute the data of all figures, the reconstruction and the audit.

    Parameters
    ----------
    report : callable
        Called with the name of a stage and the share of all work that is done, 0 to 1.
    processes : int
        How many share the work; 1 means a thread of this process.  With more, a script that
        calls this must guard its own start with ``if __name__ == "__main__"``.

    Returns
    -------
    Paper
        The evidence, the verdicts, the data and the pictures.
    """
    report("figures 2 to 6", 0.0)
    reference = gather_evidence(REFERENCE_SETTING, _REFERENCE_SETTING_TOLERANCE)
    data = _reference_datasets(reference)
    resonance = reference.response["resonance"]
    with work_executor(processes) as executor:
        futures = [
            executor.submit(_compare_solvers, reference),
            executor.submit(dynamics.compute_chaos_chart),
            executor.submit(dynamics.compute_branches_and_orbits, resonance),
            executor.submit(dynamics.locate_jump, resonance),
        ]
        drawn = _start_new_drawings(executor, data, ())
        valleys = _misfits_by_law(report)
        report("audit", 0.6)
        verdicts, reference = _audit_all_claims_with_alternatives(reference, valleys)
        names_before = tuple(data)
        data |= _misfit_datasets(valleys) | {"regimes": reference.regimes}
        for future in futures:
            data |= future.result()
        drawn |= _start_new_drawings(executor, data, names_before)
        report("pictures", 0.8)
        pictures = {name: drawn[name].result() for name in DRAWINGS}
    return Paper(reference, verdicts, data, pictures)


def _start_new_drawings(
    executor: Executor, data: Mapping[str, xr.Dataset], before: Sequence[str]
) -> dict[str, Future[dict[str, bytes]]]:
    """Have those pictures drawn for which the last data have just come."""
    return {
        name: executor.submit(draw_files, name, {k: data[k] for k in drawing.dataset_names})
        for name, drawing in DRAWINGS.items()
        if set(drawing.dataset_names) <= set(data) and not set(drawing.dataset_names) <= set(before)
    }


def _audit_all_claims_with_alternatives(
    reference: ClaimEvidence, valleys: Mapping[str, xr.Dataset]
) -> tuple[list[ClaimVerdict], ClaimEvidence]:
    """Verdicts, and the evidence with what the reconstruction adds to it."""
    least = {law: float(valley["misfit"].min()) for law, valley in valleys.items()}
    reference = replace(reference, least_misfits=least)
    settings = reconstruction.admissible_settings(valleys[_PUBLISHED_LAW_NAME], _PUBLISHED_LAW_NAME)
    with ThreadPoolExecutor(max_workers=2) as together:
        classified = together.submit(
            compute_regimes, [REFERENCE_SETTING, *settings], _REFERENCE_SETTING_TOLERANCE
        )
        alternatives = list(together.map(_gather_alternative_evidence, settings))
    reference, *alternatives = [
        replace(evidence, regimes=dataset)
        for evidence, dataset in zip([reference, *alternatives], classified.result(), strict=True)
    ]
    return audit(reference, alternatives), reference


def _gather_alternative_evidence(setting: Setting) -> ClaimEvidence:
    """Evidence for a further setting, whose numbers are not reported: a coarser one will do."""
    return gather_evidence(
        setting, _ALTERNATIVE_SETTING_TOLERANCE, every=_ALTERNATIVE_SETTING_FREQUENCY_STRIDE
    )


def make_folders(out: Path) -> None:
    """Make the folders of a report; an OSError says before any work why they cannot be made."""
    for folder in ("figures", "data"):
        (out / folder).mkdir(parents=True, exist_ok=True)


def write_report(paper: Paper, out: Path) -> Path:
    """Write page, JSON, pictures, data and the live page into a folder; return the page's path."""
    make_folders(out)
    for name, files in paper.pictures.items():
        for suffix, content in files.items():
            (out / "figures" / f"{name}{suffix}").write_bytes(content)
    for name, dataset in paper.datasets.items():
        netcdf.write(dataset, out / "data" / f"{name}.nc")
    summary = summarise(paper)
    (out / "report.json").write_text(
        json.dumps(summary, indent=2, ensure_ascii=False) + "\n", encoding="utf-8"
    )
    drawings = {name: files[".svg"].decode() for name, files in paper.pictures.items()}
    alive = live.live_page()
    if alive is not None:
        (out / live.LIVE_PAGE_NAME).write_text(alive, encoding="utf-8")
    links = [] if alive is None else live.live_links()
    target = out / "report.html"
    target.write_text(page.render_page(paper, summary, drawings, links), encoding="utf-8")
    return target


def summarise(paper: Paper) -> dict[str, Any]:
    """What programs read: resonances, claims, and the dynamics behind them."""
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
            "claim": v.claim.statement,
            "verdict": v.verdict,
            "evidence": v.evidence_text,
            "figure": f"figures/{v.claim.picture_name}.svg",
        }
        for v in paper.verdicts
    ]
    return {
        "setting": str(REFERENCE_SETTING),
        "versions": paper.evidence.response.attrs["versions"],
        "resonances": resonances,
        "claims": claims,
        **dynamics.summarise_dynamics(paper.datasets),
    }


def _compare_solvers(reference: ClaimEvidence) -> dict[str, xr.Dataset]:
    return {
        "tolerance_sections": tolerance.sections_by_solver(reference),
        "tolerance_energy": tolerance.energy_drift_by_solver(REFERENCE_SETTING),
    }


def _misfits_by_law(report: ProgressCallback) -> dict[str, xr.Dataset]:
    """Misfits of every law; the published reading over every window."""
    windows = dict.fromkeys(FORCING_LAWS, (_LAW_COMPARISON_WINDOW,)) | {
        _PUBLISHED_LAW_NAME: reconstruction.WINDOW_LENGTHS
    }
    total, done = sum(map(len, windows.values())), 0
    valleys = {}
    for law, lengths in windows.items():

        def step() -> None:
            nonlocal done
            done += 1
            report("reconstruction of what is unstated", 0.1 + 0.5 * done / total)

        every = 1 if law == _PUBLISHED_LAW_NAME else 2
        valleys[law] = reconstruction.compute_misfits(law, lengths, step, every=every)
    return valleys


def _reference_datasets(e: ClaimEvidence) -> dict[str, xr.Dataset]:
    return {
        "constant_load": e.constant_load_motion,
        "landscape": e.landscape,
        "frequency_response": e.response,
        "periodic_load": e.periodic_load_motion,
        "sections": e.section,
        "neighbours": e.neighbour_section,
    }


def _misfit_datasets(valleys: Mapping[str, xr.Dataset]) -> dict[str, xr.Dataset]:
    laws = [valleys[law].sel(window=[_LAW_COMPARISON_WINDOW]) for law in FORCING_LAWS]
    return {
        "valley_windows": valleys[_PUBLISHED_LAW_NAME],
        "valley_laws": xr.concat(laws, "law", join="inner", combine_attrs="override"),
    }
