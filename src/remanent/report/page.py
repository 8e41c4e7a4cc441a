"""The report as one self-contained page."""

from __future__ import annotations

import base64
import math
import re
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from remanent.report.contents import Paper
from remanent.report.settings import FORCING_LAWS, MAX_RESONANCE_MISFIT

#: Verdicts as the page shows them.
_VERDICT_WORDS = {"supported": "Supported", "contradicted": "Contradicted", "depends": "Depends"}


def render_page(
    paper: Paper,
    summary: Mapping[str, Any],
    drawings: Mapping[str, str],
    live_links: Sequence[tuple[str, str]] = (),
) -> str:
    """HTML text with every picture inside, readable without a network.

    Parameters
    ----------
    paper : Paper
        What was computed.
    summary : mapping of str to object
        What programs read, from :func:`remanent.report.paper.summarise`.
    drawings : mapping of str to str
        SVG text of every figure, by name.
    live_links : sequence of (str, str)
        Texts and addresses of motions in the live page beside it; empty where there is none.

    Returns
    -------
    str
        The page, from the template ``report.html``.
    """
    environment = Environment(
        loader=PackageLoader("remanent.report"), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    counts = {word: sum(v.verdict == word for v in paper.verdicts) for word in _VERDICT_WORDS}
    windows = paper.datasets["valley_windows"]["misfit"]
    return environment.get_template("report.html").render(
        summary=summary,
        verdicts=paper.verdicts,
        words=_VERDICT_WORDS,
        live_links=live_links,
        counts=counts,
        agreement=MAX_RESONANCE_MISFIT,
        share=float((windows <= MAX_RESONANCE_MISFIT).mean()),
        points=int(windows.size),
        misfits={
            FORCING_LAWS[law].text: value for law, value in paper.evidence.least_misfits.items()
        },
        drawings={name: _svg_data_address(svg) for name, svg in drawings.items()},
        worst=max(abs(r["difference"]) for r in summary["resonances"]),
        drift=_largest_energy_drifts(paper),
        error=float(paper.evidence.section["error"].max()),
        datasets=sorted(paper.datasets),
        multiplier=_multiplier_text,
        fold=partial(_fold_frequencies_text, summary["folds"]),
    )


def _multiplier_text(orbit: Mapping[str, Any]) -> str:
    """The largest multiplier: its angle where it lies on the unit circle."""
    real, imaginary = orbit["multipliers"][0]
    if imaginary == 0.0:
        return f"{real:.4f}"
    return f"exp(±{abs(math.atan2(imaginary, real)):.4f} i)"


def _fold_frequencies_text(folds: Sequence[Mapping[str, float]], orbit: Mapping[str, Any]) -> str:
    """The folds of the saddle's branch at this setting; nothing for other orbits."""
    if orbit["stability"] != "saddle":
        return ""
    case = [f for f in folds if all(f[n] == orbit[n] for n in ("temperature", "prestress"))]
    return ", ".join(f"{fold['omega']:.8f}" for fold in case)


def _svg_data_address(svg: str) -> str:
    """An SVG as a data address, on which no script can run and no name can clash."""
    text = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    return "data:image/svg+xml;base64," + base64.b64encode(text.encode()).decode()


def _largest_energy_drifts(paper: Paper) -> dict[str, float]:
    """Largest energy drift of each solver, relative to the depth of motion."""
    drift = abs(paper.datasets["tolerance_energy"]["energy_drift"])
    return {str(name): float(drift.sel(solver=name).max()) for name in drift["solver"].values}
