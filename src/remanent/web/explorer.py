"""What the server knows while it runs: its processes, the field modules it has given out."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

from remanent._machine import available_processor_count
from remanent.web.errors import RefusalError
from remanent.web.processes import ProgressFunction, WorkerPool

#: Seconds for derivations and files, as for what follows a slider.
_CAP: Final = 10.0
#: Seconds for what the page begins with, and for a store: they wait for a process and its packages.
_OPENING_CAP: Final = 60.0
#: Requests that may wait for the one process that derives equations.
_WAITING: Final = 16
#: Field modules that are kept.
_MOST_FIELDS: Final = 256
#: Languages whose files begin with an orbit that is searched for.
_SEARCHING_LANGUAGES: Final = frozenset({"auto07p"})
_SIMPLER: Final = "Look at something simpler."
_RELOAD: Final = "These equations are not known here any more. Load the page again."


@dataclass(frozen=True)
class Opened:
    """What the command was asked to open.

    Attributes
    ----------
    spec : dict or None
        What the page begins with; None for its first preset.
    store : Path or None
        A store whose chart it shows.
    """

    spec: dict[str, Any] | None = None
    store: Path | None = None


class Explorer:
    """One process that derives equations, some that compute, and what they gave.

    It starts the first at once, and the others when the page has what it begins with.

    Parameters
    ----------
    opened : Opened
    slots : int, optional
        How many jobs are computed at once; one processor is left to the rest by default.
    """

    def __init__(self, opened: Opened, slots: int | None = None) -> None:
        self.opened = opened
        self.slots = slots or max(1, available_processor_count() - 1)
        self._deriving = WorkerPool(1, waiting=_WAITING)
        self._computing = WorkerPool(self.slots, warm_up=True)
        self._fields: OrderedDict[str, str] = OrderedDict()
        self._start: asyncio.Task[dict[str, Any]] | None = None
        self.socket_count = 0
        self._deriving.start_processes()

    def begin(self) -> None:
        """Take requests from now on, in the loop that runs."""
        self._deriving.listen()
        self._start = asyncio.create_task(self._make_start())

    def close(self) -> None:
        """End all processes."""
        if self._start is not None:
            self._start.cancel()
        for pool in (self._deriving, self._computing):
            pool.close()

    @property
    def process_numbers(self) -> list[int]:
        """Numbers of the processes that run."""
        return [*self._deriving.process_numbers, *self._computing.process_numbers]

    async def start(self) -> dict[str, Any]:
        """What a page begins with; where that failed, it is tried again."""
        if self._start is None or (self._start.done() and self._start.exception()):
            self._start = asyncio.create_task(self._make_start())
        return await asyncio.shield(self._start)

    def field_source(self, digest: str) -> str:
        """The field module with this digest.

        Raises
        ------
        RefusalError
            It was not given out, or long ago.
        """
        if digest not in self._fields:
            raise RefusalError(404, _RELOAD)
        self._fields.move_to_end(digest)
        return self._fields[digest]

    async def model(self, asked: dict[str, Any]) -> dict[str, Any]:
        """The page model of what is looked at, and where its field module is."""
        answer = await self._derive("model", asked)
        if str(answer["model"]["id"]) not in self._fields:
            self._computing.warm_up({"spec": answer["model"]["spec"]})
        return self._keep_field(answer)

    async def reproduce(self, asked: dict[str, Any]) -> Any:
        """What makes exactly what is seen."""
        return await self._derive("reproduce", asked)

    async def export(self, asked: dict[str, Any]) -> Any:
        """The equations in another tool's language; a search for an orbit takes a job's place."""
        if asked["language"] in _SEARCHING_LANGUAGES:
            return await self.compute("export", asked, cap=_CAP, remedy=_SIMPLER)
        return await self._derive("export", asked)

    async def store(self) -> Any:
        """What the chart of the store shows."""
        return await self._derive("store", {"path": self._store_path()}, _OPENING_CAP)

    async def point(self, index: list[int]) -> Any:
        """The spec of a point of the store."""
        asked = {"path": self._store_path(), "index": index}
        return await self._derive("point", asked, _OPENING_CAP)

    async def data(self, asked: dict[str, Any]) -> bytes:
        """The file of a motion; it takes the place of a job."""
        file: bytes = await self.compute("data", asked, cap=_CAP, remedy="Ask for fewer periods.")
        return file

    async def compute(
        self,
        task: str,
        arguments: Any,
        *,
        cap: float,
        remedy: str,
        report: ProgressFunction | None = None,
    ) -> Any:
        """The result of a job, as :meth:`~remanent.web.processes.WorkerPool.run` gives it."""
        return await self._computing.run(task, arguments, cap=cap, remedy=remedy, report=report)

    async def _make_start(self) -> dict[str, Any]:
        """What a page begins with; then the processes for jobs are started."""
        try:
            answer = await self._derive("start", {"spec": self.opened.spec}, _OPENING_CAP)
        finally:
            if not self._computing.process_numbers:
                self._computing.start_processes()
                self._computing.listen()
        store = self.opened.store
        return {
            "version": version("remanent"),
            **self._keep_field(answer),
            "store": None if store is None else {"title": store.resolve().name},
            "jobs": {"slots": self.slots},
        }

    async def _derive(self, task: str, arguments: Any, cap: float = _CAP) -> Any:
        return await self._deriving.run(task, arguments, cap=cap, remedy=_SIMPLER)

    def _keep_field(self, answer: dict[str, Any]) -> dict[str, Any]:
        """An answer with the address of its field module in place of its text."""
        digest = str(answer["model"]["id"])
        self._fields[digest] = answer["source"]
        self._fields.move_to_end(digest)
        while len(self._fields) > _MOST_FIELDS:
            self._fields.popitem(last=False)
        others = {name: value for name, value in answer.items() if name != "source"}
        return {**others, "field": f"/fields/{digest}.js"}

    def _store_path(self) -> str:
        if self.opened.store is None:
            raise RefusalError(404, "No store was opened. Start with `remanent explore STORE`.")
        return str(self.opened.store.resolve())
