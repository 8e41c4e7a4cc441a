"""The application: the page, its data, and what the engine computes for it."""

from __future__ import annotations

import asyncio
import json
import traceback
from collections.abc import AsyncIterator, Coroutine, Mapping
from contextlib import asynccontextmanager
from typing import Annotated, Any, Final, TypeVar

from fastapi import FastAPI, Request, WebSocket
from fastapi import Path as PathParameter
from fastapi.exceptions import RequestValidationError
from fastapi.responses import FileResponse, JSONResponse, Response
from fastapi.staticfiles import StaticFiles
from starlette.exceptions import HTTPException

from remanent.page.files import assets_folder, plotly_script
from remanent.web import bodies
from remanent.web.errors import UNEXPECTED, RefusalError
from remanent.web.explorer import Explorer
from remanent.web.sockets import serve_jobs

Result = TypeVar("Result")
#: Seconds between two looks whether a client still waits.
_SECONDS_BETWEEN_LOOKS: Final = 0.2
#: What a browser may keep: all but what has the digest of its content in its name only until asked.
_FRESH: Final = {"cache-control": "no-cache"}
_FOR_EVER: Final = {"cache-control": "max-age=31536000, immutable"}
#: What error answers look like.
_ERRORS: Final[dict[int | str, dict[str, Any]]] = {
    status: {"model": bodies.ErrorAnswer}
    for status in (400, 403, 404, 405, 408, 413, 415, 422, 429)
}
_TYPES: Final = {"netcdf": "application/x-netcdf", "csv": "text/csv"}
_ENDINGS: Final = {"netcdf": "nc", "csv": "csv"}


def make_app(explorer: Explorer) -> FastAPI:
    """The application around what the server knows.

    Parameters
    ----------
    explorer : Explorer
        It is begun and closed with the application.
    """

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        explorer.begin()
        try:
            yield
        finally:
            explorer.close()

    app = FastAPI(
        title="remanent explore",
        lifespan=lifespan,
        docs_url=None,  # pages that load their scripts from elsewhere
        redoc_url=None,
        openapi_url=None,
        redirect_slashes=False,
        responses=_ERRORS,
    )
    _add_page(app)
    _add_data(app, explorer)
    _add_store(app, explorer)
    _add_errors(app)

    @app.websocket("/api/jobs")
    async def jobs(socket: WebSocket) -> None:
        await serve_jobs(socket, explorer)

    return app


def _add_page(app: FastAPI) -> None:
    """The page and its files."""
    assets, plotly = assets_folder(), plotly_script()

    @app.api_route("/", methods=["GET", "HEAD"], include_in_schema=False)
    async def page() -> Response:
        return FileResponse(assets / "index.html", media_type="text/html", headers=_FRESH)

    @app.api_route("/plotly.js", methods=["GET", "HEAD"], include_in_schema=False)
    async def plotting() -> Response:
        return FileResponse(plotly, media_type="text/javascript", headers=_FRESH)

    app.mount("/assets", _Assets(directory=assets, check_dir=False))


class _Assets(StaticFiles):
    """Files that a browser asks about anew each time, so that a new version is seen at once."""

    def file_response(self, *args: Any, **kwargs: Any) -> Response:
        """A file, or that it has not changed."""
        response = super().file_response(*args, **kwargs)
        response.headers.update(_FRESH)
        return response


def _add_data(app: FastAPI, explorer: Explorer) -> None:
    """What a page asks about what it looks at."""

    @app.get("/api/start", response_model=bodies.StartAnswer)
    async def start() -> Any:
        return _answer(await explorer.start())

    @app.post("/api/model", response_model=bodies.ModelAnswer)
    async def model(body: bodies.ModelBody) -> Any:
        return _answer(await explorer.model(body.model_dump()))

    @app.get("/fields/{digest}.js", response_class=Response)
    async def field(
        digest: Annotated[str, PathParameter(pattern="^[0-9A-Za-z_-]{1,128}$")],
    ) -> Response:
        source = explorer.field_source(digest)
        return Response(source, media_type="text/javascript", headers=_FOR_EVER)

    @app.post("/api/reproduce", response_model=bodies.ReproduceAnswer)
    async def reproduce(body: bodies.ReproduceBody) -> Any:
        return _answer(await explorer.reproduce(body.model_dump()))

    @app.post("/api/export", response_model=bodies.FilesAnswer)
    async def export(body: bodies.ExportBody, request: Request) -> Any:
        work = explorer.export(body.model_dump())
        return _answer(await _while_wanted(request, work))

    @app.post("/api/data", response_class=Response)
    async def data(body: bodies.DataBody, request: Request) -> Response:
        work = explorer.data(body.model_dump())
        name = f"motion.{_ENDINGS[body.format]}"
        return Response(
            await _while_wanted(request, work),
            media_type=_TYPES[body.format],
            headers={"content-disposition": f'attachment; filename="{name}"'},
        )


async def _while_wanted(request: Request, work: Coroutine[Any, Any, Result]) -> Result:
    """The result of some work, which is broken off where the client goes away."""
    task = asyncio.create_task(work)
    try:
        while not task.done():
            await asyncio.wait([task], timeout=_SECONDS_BETWEEN_LOOKS)
            if not task.done() and await request.is_disconnected():
                raise RefusalError(499, "The client is gone.")
        return task.result()
    finally:
        task.cancel()


def _add_store(app: FastAPI, explorer: Explorer) -> None:
    """What a page asks about an opened store."""

    @app.get("/api/store", response_model=bodies.StoreAnswer)
    async def store() -> Any:
        return _answer(await explorer.store())

    @app.post("/api/store/point", response_model=bodies.SpecAnswer)
    async def point(body: bodies.PointBody) -> Any:
        return _answer(await explorer.point(body.index))


class _PlainResponse(JSONResponse):
    """Plain data in letters of ASCII, as halves of others that a client sends are no UTF-8."""

    def render(self, content: Any) -> bytes:
        """The data as JSON."""
        return json.dumps(content, allow_nan=False, separators=(",", ":")).encode("ascii")


def _answer(content: Any) -> Response:
    """Plain data that is sent as it is: it was checked where it was made."""
    return _PlainResponse(content, headers={"cache-control": "no-store"})


def _add_errors(app: FastAPI) -> None:
    """Errors as the page shows them: words and places, never a traceback."""

    @app.exception_handler(RefusalError)
    async def refused(_: Request, error: RefusalError) -> Response:
        return error_response(error)

    @app.exception_handler(HTTPException)
    async def http_error(_: Request, error: HTTPException) -> Response:
        return error_response(RefusalError(error.status_code, str(error.detail)), error.headers)

    @app.exception_handler(RequestValidationError)
    async def invalid(_: Request, error: RequestValidationError) -> Response:
        return error_response(_refusal_of_body(error))

    @app.exception_handler(Exception)
    async def unexpected(_: Request, error: Exception) -> Response:
        traceback.print_exception(error)
        return error_response(RefusalError(500, UNEXPECTED))


def error_response(error: RefusalError, headers: Mapping[str, str] | None = None) -> Response:
    """What is sent of a refusal."""
    return _PlainResponse(
        {"error": error.answer},
        status_code=error.status,
        headers={"cache-control": "no-store", **(headers or {})},
    )


def _refusal_of_body(error: RequestValidationError) -> RefusalError:
    """What is wrong with a body that is not of the form that was asked for."""
    faults = []
    for one in error.errors():
        place = [str(part) for part in one["loc"][1:]]
        message = str(one["msg"])
        where = ".".join(place)
        faults.append({
            "table": "",
            "key": where[:200],
            "message": f"{where[:200]}: {message}" if where else message,
        })  # fmt: skip
    return RefusalError(422, "\n".join(fault["message"] for fault in faults), faults)
