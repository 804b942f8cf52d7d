"""What reports read of `schelling.json` and `crossplay.json`; the files hold more."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

Count = Annotated[int, Field(ge=0, lt=2**31)]
Number = FiniteFloat | None  # None: not defined


class _Part(BaseModel):
    model_config = ConfigDict(strict=True)


class Game(_Part):
    """The game that was played."""

    name: str
    hash: str
    num_agents: Count
    params: dict[str, Any]
    tasks: str | dict[str, Any] | None = None  # which of its tasks were played
    split: str = ""


class Figure(_Part):
    """A mean with its interval."""

    mean: Number
    low: Number
    high: Number


class Verdict(_Part):
    """Whether the game is a dilemma."""

    outcome: str
    fear: bool
    greed: bool
    reason: str
    caution: str | None = None


class Contrasts(_Part):
    """The contrasts of a Schelling diagram."""

    A: Figure
    B: Figure
    fear: Figure
    greed: Figure


class Experiment(_Part):
    """What both files have."""

    format: Literal[1]
    game: Game
    unit: str
    notes: list[str] = []


class Diagram(Experiment):
    """A Schelling diagram."""

    cooperators: str
    defectors: str
    units: Count
    episodes: Count
    verdict: Verdict
    contrasts: Contrasts


class Mixture(_Part):
    """A mixture of policies, and what each of them earned in it."""

    mixture: str
    slots: list[str]
    policies: Annotated[dict[str, Figure], Field(min_length=1)]
    unit: str | None = None  # None: that of the whole
    episodes: Count


class CrossPlay(Experiment):
    """Mixtures of policies."""

    keys: list[list[int]]  # of each replicate
    mixtures: list[Mixture]
