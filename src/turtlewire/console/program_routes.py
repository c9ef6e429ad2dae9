"""The console's routes for programs: kept, checked, previewed, run, paused, stepped through and stopped."""

from __future__ import annotations

import asyncio
from functools import cache
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Header, Query, Response
from pydantic import BaseModel, Field

from turtlewire.console import programs
from turtlewire.console.models import Done, Model
from turtlewire.console.previewing import preview_there
from turtlewire.console.programs import LARGEST
from turtlewire.console.refusals import Refused
from turtlewire.console.routes import ConsoleOf, DriverOf, StationOf  # noqa: TC001 (FastAPI looks at them)
from turtlewire.console.runs import Program, Run
from turtlewire.errors import DataError

router = APIRouter(prefix="/api", tags=["programs"])

Source = Annotated[str, Field(max_length=LARGEST, description="a Logo program")]
Name = Annotated[str, Field(max_length=100, description="its file name, for messages")]
Line = Annotated[int, Field(ge=1, le=10_000_000)]


class Listed(BaseModel):
    """A program of the folder: its length in bytes, and when it was saved, seconds since 1970."""

    name: str
    size: int
    saved: float


class Kept(BaseModel):
    """A program; ``etag`` says which version of it."""

    name: str
    source: str
    etag: str


class Saved(BaseModel):
    """Which version of a program is kept now."""

    name: str
    etag: str


class Text(Model):
    """A program's text."""

    source: Source


class Named(Model):
    """A program."""

    source: Source
    name: Name = "program.logo"


class Begun(Named):
    """A program that is to be run; with ``paused`` it stands before its first line."""

    paused: bool = False
    breakpoints: Annotated[list[Line], Field(max_length=1000, default_factory=list)]


class Finding(BaseModel):
    """Something wrong with a program: see ``turtlewire logo --check``. Line and column count from 1."""

    line: int
    column: int
    kind: str
    message: str
    hint: str


class Word(BaseModel):
    """A primitive: its usual, fewest and most inputs (-1: any number), and what it does."""

    name: str
    inputs: int
    fewest: int
    most: int
    help: str


class Written(BaseModel):
    """What a program has written, from a character on."""

    number: int = Field(description="of the run")
    start: int = Field(serialization_alias="from")
    text: str


class Step(Model):
    """How a program that stands before a line goes on, until it stands again."""

    how: Literal["into", "over", "out"] = "into"


class Typed(Model):
    """A line that somebody types; null: nobody types any more."""

    text: Annotated[str, Field(max_length=10_000)] | None


class Instructions(Model):
    """What is to be done where a program stands."""

    source: Annotated[str, Field(max_length=10_000)]


class Breakpoints(Model):
    """Lines before which a program stops."""

    lines: Annotated[list[Line], Field(max_length=1000)]


# ---------------------------------------------------------------------- examples and the folder


@cache
def _examples() -> dict[str, programs.Kept]:
    return {kept.name: kept for kept in programs.examples()}


@router.get("/examples")
def examples() -> list[str]:
    """The names of the examples that come along."""
    return list(_examples())


@router.get("/examples/{name}")
def example(name: str) -> Kept:
    """An example."""
    if name not in _examples():
        raise Refused(404, "no_program", f"there is no example {name}")
    return Kept(**_examples()[name]._asdict())


@router.get("/programs")
def listed(console: ConsoleOf) -> list[Listed]:
    """The programs in the folder on the server."""
    return [Listed(**entry._asdict()) for entry in console.programs.all()]


@router.get("/programs/{name}")
def read(console: ConsoleOf, name: str, response: Response) -> Kept:
    """A program."""
    kept = console.programs.read(name)
    response.headers["ETag"] = kept.etag
    return Kept(**kept._asdict())


@router.put("/programs/{name}")
def write(
    console: ConsoleOf,
    name: str,
    text: Text,
    response: Response,
    if_match: Annotated[str | None, Header(description="the version that was changed")] = None,
) -> Saved:
    """Save a program; without ``If-Match``, a new one. What somebody else has saved meanwhile is not lost (412)."""
    kept = console.programs.write(name, text.source, instead_of=if_match)
    response.headers["ETag"] = kept.etag
    return Saved(name=kept.name, etag=kept.etag)


@router.delete("/programs/{name}")
def delete(
    console: ConsoleOf,
    name: str,
    if_match: Annotated[str, Header(description="the version that is meant")],
) -> Done:
    """Delete a program."""
    console.programs.delete(name, instead_of=if_match)
    return Done()


# ---------------------------------------------------------------------- looked at


@router.post("/check")
def check(program: Named) -> list[Finding]:
    """What is wrong with a program, found without running it."""
    from turtlewire.logo.checking import check

    return [
        Finding(
            line=each.position.line,
            column=each.position.column,
            kind=each.kind,
            message=each.message,
            hint=each.hint,
        )
        for each in check(program.source, program.name)
    ]


@router.get("/logo/words")
def words() -> list[Word]:
    """All words of Logo that are there from the beginning."""
    return _words()


@cache
def _words() -> list[Word]:
    from turtlewire.console.words import HELP
    from turtlewire.logo.primitives import PRIMITIVES

    return [
        Word(
            name=name,
            inputs=primitive.default_inputs,
            fewest=primitive.minimum_inputs,
            most=primitive.maximum_inputs,
            help=HELP.get(name, ""),
        )
        for name, primitive in sorted(PRIMITIVES.items())
    ]


@router.post("/robots/{robot}/preview")
def preview(console: ConsoleOf, station: StationOf, program: Named) -> dict[str, Any]:
    """What a program would do on a robot like this one that stands where it stands; nothing moves."""
    try:
        return preview_there(
            station.target, program.source, program.name, station.view.pose, console.programs.folder
        )
    except (DataError, OSError) as error:
        raise Refused(422, "no_preview", str(error)) from error


# ---------------------------------------------------------------------- run


@router.get("/robots/{robot}/program")
async def program(station: StationOf) -> dict[str, Any] | None:
    """The program that runs, or was the last to run: as in the stream, and its source."""
    run = station.program.run
    return None if run is None else {**run.state, "source": run.program.source}


@router.get("/robots/{robot}/program/output")
async def output(station: StationOf, since: Annotated[int, Query(ge=0, le=2**53)] = 0) -> Written:
    """What it has written, from a character on; of a very long output, the end of it."""
    run = _last(station)
    start, text = run.output(since)
    return Written(number=run.state["number"], start=start, text=text)


@router.post("/robots/{robot}/program", status_code=201)
async def begin(station: StationOf, driver: DriverOf, program: Begun) -> dict[str, Any]:
    """Run a program. Needs the wheel; set-points are refused while it runs."""
    del driver
    if station.program.is_running:
        raise Refused(409, "program_runs", "a program runs already: stop it first")
    wanted = Program(program.source, program.name, program.paused, tuple(program.breakpoints))
    run = await asyncio.to_thread(station.program.start, wanted)
    return run.state


@router.post("/robots/{robot}/program/pause")
async def pause(station: StationOf, driver: DriverOf) -> dict[str, Any]:
    """Have it stand before its next line, when the motion that has begun is done."""
    del driver
    run = _running(station)
    run.pause()
    return run.state


@router.post("/robots/{robot}/program/continue")
async def go_on(station: StationOf, driver: DriverOf) -> dict[str, Any]:
    """Let it go on."""
    del driver
    run = _standing(station)
    run.go("on")
    return run.state


@router.post("/robots/{robot}/program/step")
async def step(station: StationOf, driver: DriverOf, step: Step | None = None) -> dict[str, Any]:
    """Let it run one line: ``into`` procedures and lists, ``over`` them, or ``out`` of the procedure that runs."""
    del driver
    run = _standing(station)
    run.go(step.how if step is not None else "into")
    return run.state


@router.post("/robots/{robot}/program/do")
async def do(station: StationOf, driver: DriverOf, instructions: Instructions) -> Done:
    """Run instructions where the program stands."""
    del driver
    _standing(station).do(instructions.source)
    return Done()


@router.post("/robots/{robot}/program/input")
async def type_line(station: StationOf, driver: DriverOf, typed: Typed) -> Done:
    """Type a line that the program reads."""
    del driver
    _running(station).type(typed.text)
    return Done()


@router.put("/robots/{robot}/program/breakpoints")
async def set_breakpoints(station: StationOf, driver: DriverOf, breakpoints: Breakpoints) -> Done:
    """Have it stand before these lines, and no others."""
    del driver
    _running(station).set_breakpoints(tuple(breakpoints.lines))
    return Done()


@router.post("/robots/{robot}/program/stop")
async def stop(station: StationOf, driver: DriverOf) -> Done:
    """Stop the robot and end the program; who drives goes on driving. Anybody may use ``/stop``."""
    del driver
    station.halt()
    station.program.stop()
    return Done()


def _last(station: StationOf) -> Run:
    run = station.program.run
    if run is None:
        raise Refused(404, "no_run", "no program has been run on this robot")
    return run


def _running(station: StationOf) -> Run:
    run = _last(station)
    if run.is_over:
        raise Refused(409, "not_running", "no program runs on this robot")
    return run


def _standing(station: StationOf) -> Run:
    run = _running(station)
    if run.state["paused"] is None:
        raise Refused(409, "not_paused", "the program does not stand before a line: pause it first")
    return run
