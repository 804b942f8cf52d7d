"""The requests of the page to a bench, each a class that checks its fields."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

from sjdsl.properties.biased_draws import Bias
from sjdsl.studio.episode import LONGEST

LARGEST_TEXT = 400_000  # characters
NAME = Annotated[str, Field(max_length=200)]


class Request(BaseModel):
    """A request. id: repeated in the answer."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)
    id: int = 0


class Text(Request):
    """Opens a text, or goes on with the episode after an edit.

    version: of the text, repeated in the answer; fresh: begins a new episode.
    over: texts of maps that aren't saved yet, by their paths in the folder.
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
    """Takes a step. actions: of the agents that the user controls, by number."""

    do: Literal["step"]
    actions: dict[int, int] = {}


class Go(Request):
    """Shows another moment of the episode."""

    do: Literal["go"]
    to: int


class Begin(Request):
    """Begins an episode again."""

    do: Literal["begin"]
    seed: Annotated[int, Field(ge=0, lt=2**32)]


class Others(Request):
    """Chooses the policy of the agents that the user doesn't control.

    policy: `random`, `stay`, or one of the file.
    """

    do: Literal["others"]
    policy: NAME


class Number(Request):
    """Sets a param from the next step on.

    value: for an indexed param a mapping, such as `{"soft": {"hard": 3}}`; entries that it leaves
    out stay as they are.
    """

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


class Write(Request):
    """Asks for the change of the text that sets a param. entry: the keys of an indexed one."""

    do: Literal["write"]
    name: NAME
    entry: tuple[NAME, ...] = ()
    value: Annotated[str, Field(max_length=200, pattern=r"^(-?[0-9.]+|[a-z][a-z0-9_]*)$")]


class Replay(Request):
    """Shows the counterexample to a check, with the fields of its verdict.

    rows: the map; params: those that differ from the file's; actions: of each step.
    """

    do: Literal["replay"]
    rows: Annotated[
        tuple[Annotated[str, Field(min_length=1, max_length=500)], ...],
        Field(min_length=1, max_length=500),
    ]
    params: Annotated[tuple[tuple[NAME, Any], ...], Field(max_length=1000)] = ()
    seed: Annotated[int, Field(ge=0, lt=2**32)]
    episode: Annotated[int, Field(ge=0, lt=2**32)] = 0
    bias: Annotated[tuple[Bias, ...], Field(max_length=LONGEST)] = ()
    actions: Annotated[
        tuple[Annotated[tuple[int, ...], Field(max_length=1000)], ...], Field(max_length=LONGEST)
    ]


class Panel(Request):
    """Asks for a panel. agent, row, col: of a panel about one agent or one cell."""

    do: Literal["panel"]
    panel: Literal["rules", "python", "state", "seen", "trace", "checks", "diff", "curves"]
    agent: int = 0
    row: int | None = None
    col: int | None = None


class Share(Request):
    """Asks for the episode as a page."""

    do: Literal["share"]


class Record(Request):
    """Asks for the episode as a file for `sjdsl replay`."""

    do: Literal["record"]


AnyRequest = (
    Text
    | Step
    | Go
    | Begin
    | Others
    | Number
    | Put
    | Paint
    | Write
    | Replay
    | Panel
    | Share
    | Record
)
READ: TypeAdapter[AnyRequest] = TypeAdapter(Annotated[AnyRequest, Field(discriminator="do")])
