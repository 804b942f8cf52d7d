"""What the page asks of a bench: one class for each request, checked before anything is done."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

LARGEST_TEXT = 400_000  # characters
NAME = Annotated[str, Field(max_length=200)]


class Request(BaseModel):
    """id: of the request, given back with the answer."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)
    id: int = 0


class Text(Request):
    """Opens a text, or shows an episode as its rules are after an edit. `version`: of the text, given back; `fresh`: with a new episode.

    over: texts that stand in place of files in the folder, by their paths: maps that are not saved yet.
    """

    do: Literal["text"]
    version: int
    path: NAME
    text: Annotated[str, Field(max_length=LARGEST_TEXT)]
    variants: tuple[NAME, ...] = ()
    agents: Annotated[int, Field(ge=1, le=1000)] | None = None
    params: dict[NAME, Any] = {}
    over: dict[NAME, Annotated[str, Field(max_length=LARGEST_TEXT)]] = {}
    fresh: bool = False


class Step(Request):
    """Takes steps. `actions`: of the agents that somebody drives, by the number of the agent."""

    do: Literal["step"]
    actions: dict[int, int] = {}
    many: Annotated[int, Field(ge=1, le=50)] = 1


class Go(Request):
    """Shows another moment of the episode."""

    do: Literal["go"]
    to: int


class Begin(Request):
    """Begins an episode again."""

    do: Literal["begin"]
    seed: Annotated[int, Field(ge=0, lt=2**32)]


class Others(Request):
    """Says what the agents do that nobody drives."""

    do: Literal["others"]
    policy: NAME


class Number(Request):
    """Sets a number of the game from the next step on."""

    do: Literal["number"]
    name: NAME
    value: Any


class Put(Request):
    """Puts an agent on a cell."""

    do: Literal["put"]
    agent: int
    row: int
    col: int


class Paint(Request):
    """Asks for the change of the text that puts another glyph on a cell of the map."""

    do: Literal["paint"]
    row: int
    col: int
    glyph: Annotated[str, Field(max_length=2)]


class Panel(Request):
    """Asks for what stands beside the board. `agent`, `row`, `col`: of whom, and where, if the panel is about one."""

    do: Literal["panel"]
    panel: Literal["rules", "python", "state", "seen", "trace", "checks"]
    agent: int = 0
    row: int | None = None
    col: int | None = None


class Share(Request):
    """Asks for the episode as a page of its own."""

    do: Literal["share"]


AnyRequest = Text | Step | Go | Begin | Others | Number | Put | Paint | Panel | Share
READ: TypeAdapter[AnyRequest] = TypeAdapter(Annotated[AnyRequest, Field(discriminator="do")])
