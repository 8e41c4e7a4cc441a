"""What the command is asked to open: a study file, a store, or nothing."""

from __future__ import annotations

from pathlib import Path

from remanent.web.explorer import Opened


def open_source(source: Path | None) -> Opened:
    """What a page begins with.

    Parameters
    ----------
    source : Path or None
        A study file, the folder of a store, or None for the first preset.

    Raises
    ------
    RemanentError
        The file has faults, or the folder is no store.
    """
    if source is None:
        return Opened()
    from remanent.studies.sweep.store import open_store
    from remanent.studies.sweep.study_file import read_study
    from remanent.web.stores import study_spec

    if source.is_dir():
        return Opened(study_spec(open_store(source).study), source)
    return Opened(study_spec(read_study(source).study))
