"""Names of a field become identifiers that a language tells apart."""

from __future__ import annotations

import pytest

from remanent.codegen.languages.identifiers import identifiers_of
from remanent.codegen.languages.table import LANGUAGES


@pytest.mark.parametrize("language", LANGUAGES)
def test_names_that_differ_in_case_alone_stay_different(language: str) -> None:
    """Fortran knows no case, so that one of mu and Mu gets a number; elsewhere both are kept."""
    found = identifiers_of(["mu", "Mu", "MU_1"], LANGUAGES[language])
    if language == "auto07p":
        assert len({one.lower() for one in found.values()}) == 3
    else:
        assert found == {name: name for name in found}
