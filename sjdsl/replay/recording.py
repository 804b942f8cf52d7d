"""The file of a recorded episode: its game, its seed, the actions of all agents."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from sjdsl.files import LARGEST_JSON, read_bytes, write_whole


class RecordingError(Exception):
    """A file holds no episode, or its episode doesn't match its game."""


class Arguments(BaseModel):
    """The arguments of `sjdsl.make` that a file of episodes may hold, with their types."""

    model_config = ConfigDict(extra="forbid")

    game: str
    variant: str | None = None
    num_agents: int | None = None
    params: dict[str, Any] | None = None
    map: str | list[str] | None = None
    observation: Literal["tokens", "onehot"] = "tokens"
    tasks: str | dict[str, Any] | None = None
    split: str | None = None
    problem: int | None = None


Seed = Annotated[int, Field(ge=0, lt=2**63)]


class Recording(BaseModel):
    """One episode; JSON with these names.

    environment: the arguments of `sjdsl.make`; hash: of the rules, which a replay has to have.
    actions: for each step, the number of each agent's action; returns: of each agent, to check a
    replay.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    format: Literal["sjdsl-episode-1"] = "sjdsl-episode-1"
    environment: dict[str, Any]
    hash: str
    seed: Seed
    actions: list[list[int]]
    returns: list[float]


def save_recording(recording: Recording, path: Path) -> None:
    """Writes the file of an episode, whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, json.dumps(recording.model_dump()) + "\n")


def read_recording(path: Path) -> Recording:
    """Returns the episode in a file.

    Raises:
      RecordingError: there is no such file, or it holds something else.
    """
    try:
        return Recording.model_validate_json(read_bytes(path, LARGEST_JSON))
    except OSError as error:
        raise RecordingError(f"{path} cannot be read: {error.strerror}") from None
    except ValidationError:
        raise RecordingError(
            f"{path} does not hold a recorded episode; `sjdsl play GAME --record FILE` writes one, "
            "`sjdsl record GAME -o FILE.npz` many"
        ) from None


def check_rules(recording: Recording, game_hash: str, name: str) -> None:
    """Raises RecordingError if the hash of a game's rules differs from that of the recording."""
    if game_hash != recording.hash:
        raise RecordingError(
            f"the rules of {name} have changed since the episode was recorded: the hash was "
            f"{recording.hash}, and is now {game_hash}"
        )


def check_actions(recording: Recording, num_agents: int, num_actions: int) -> None:
    """Raises RecordingError if a step lacks one valid action for each agent."""
    for number, actions in enumerate(recording.actions, 1):
        if len(actions) != num_agents or not all(0 <= action < num_actions for action in actions):
            raise RecordingError(
                f"step {number} of the episode is damaged: its actions must be {num_agents} "
                f"numbers from 0 to {num_actions - 1}, not {actions}"
            )


def check_returns(recording: Recording, returns: Sequence[float]) -> None:
    """Raises RecordingError if a replay gives other returns than were recorded."""
    if len(returns) != len(recording.returns) or not np.allclose(
        returns, recording.returns, rtol=1e-5, atol=1e-5
    ):
        raise RecordingError(
            f"the replay gave returns {list(map(float, returns))}, but {recording.returns} were "
            "recorded"
        )
