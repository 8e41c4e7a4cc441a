"""What the bodies of requests hold; the tables of a spec are read by the reader of study files."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

_Periods = Annotated[int, Field(ge=1, le=5000)]
_Duration = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class Body(BaseModel):
    """A body with these keys and no others."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class SpecBody(Body):
    """What is looked at."""

    spec: dict[str, Any] = Field(
        description="The tables `actuator` or `system`, `drive`, and perhaps `initial`."
    )


class ModelBody(Body):
    """What is looked at: a spec, or the text of a study file."""

    spec: dict[str, Any] | None = None
    toml: str | None = None

    @model_validator(mode="after")
    def _is_one_of_both(self) -> Self:
        if (self.spec is None) == (self.toml is None):
            raise ValueError("either spec or toml has to be given")
        return self


class ReproduceBody(SpecBody):
    """What is looked at, and for how long."""

    periods: _Periods | None = None
    duration: _Duration | None = None


class ExportBody(SpecBody):
    """What is looked at, and the language of its equations."""

    language: Annotated[str, Field(max_length=40)]


class DataBody(SpecBody):
    """What is looked at, and how long a run of it is written to a file."""

    periods: _Periods | None = None
    duration: _Duration | None = None
    format: Literal["netcdf", "csv"] = "netcdf"


class PointBody(Body):
    """A point of the grid of a store."""

    index: Annotated[
        list[Annotated[int, Field(ge=0, lt=2**31)]], Field(min_length=1, max_length=16)
    ]


class JobMessage(SpecBody):
    """A job that is asked for through the socket."""

    id: Annotated[str, Field(min_length=1, max_length=64)]
    job: Annotated[str, Field(max_length=64)]
    options: dict[str, Any] = Field(default_factory=dict)
    type: Literal["job"] = "job"


class CancelMessage(Body):
    """A job that is not wanted any more."""

    id: Annotated[str, Field(min_length=1, max_length=64)]
    type: Literal["cancel"]


class Answer(BaseModel):
    """An answer with these keys."""

    model_config = ConfigDict(extra="forbid")


class FaultText(Answer):
    """What is wrong at one place of a request."""

    table: str
    key: str
    message: str


class ErrorText(Answer):
    """What is wrong with a request."""

    status: int
    message: str
    faults: list[FaultText]


class ErrorAnswer(Answer):
    """The answer where something is wrong."""

    error: ErrorText


class ModelAnswer(Answer):
    """A page model, and where its equations are."""

    model: dict[str, Any]
    field: str


class StartAnswer(ModelAnswer):
    """What a page begins with."""

    version: str
    kinds: dict[str, Any] | list[Any]
    presets: list[dict[str, Any]]
    store: dict[str, Any] | None
    jobs: dict[str, int]


class ReproduceAnswer(Answer):
    """What makes exactly what is seen."""

    python: str
    study: str


class FilesAnswer(Answer):
    """Texts of files by their names."""

    files: dict[str, str]


class StoreAnswer(Answer):
    """What the chart of a store shows."""

    title: str
    verb: str
    dims: list[dict[str, Any]]
    coords: dict[str, dict[str, Any]]
    variables: dict[str, dict[str, Any]]
    status: dict[str, Any]
    point: dict[str, Any]


class SpecAnswer(Answer):
    """What is looked at."""

    spec: dict[str, Any]
