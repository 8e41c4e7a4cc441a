"""A setting of what the article leaves unstated votes once."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from remanent.report import audit
from remanent.report.claims import Claim, Finding
from remanent.report.settings import Setting


def evidence(setting: Setting, numbers: str) -> Any:
    """Evidence of which the claim below reads the setting and these numbers."""
    return SimpleNamespace(setting=setting, numbers=numbers)


def found(evidence: Any) -> dict[str, Finding]:
    """A claim holds, by these numbers."""
    return {"": Finding(True, evidence.numbers)}


REFERENCE = evidence(Setting(), "0.25")
COARSER = evidence(Setting(), "0.26")
FURTHER = evidence(Setting(b=0.38), "0.31")


@pytest.mark.parametrize("alternatives", [[], [FURTHER], [COARSER], [FURTHER, COARSER]])
def test_the_setting_of_the_reference_is_not_counted_again(
    alternatives: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Law: evidence for the same setting changes neither the numbers nor the count."""
    monkeypatch.setattr(audit, "CLAIMS", (Claim("1", "x", found, "picture"),))
    (verdict,) = audit.audit(REFERENCE, alternatives)
    text = " The same at 1 further setting of what the article leaves unstated."
    assert verdict.verdict == "supported"
    assert verdict.evidence_text == "0.25" + text * (FURTHER in alternatives)
