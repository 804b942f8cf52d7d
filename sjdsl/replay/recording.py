"""The file of a recorded episode: its game, its seed, the actions of all agents."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError

from sjdsl.files import write_whole


class RecordingError(Exception):
    """A file that holds no episode, or one of another game than it says."""


class Recording(BaseModel):
    """One episode; JSON with these names.

    environment: the arguments of `sjdsl.make`; hash: of the rules, so that an episode of other rules is not shown as one of these.
    seed: of the episode; actions: one list a step, one number for each agent; returns: of each agent, what the actions must come to.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    format: Literal["sjdsl-episode-1"] = "sjdsl-episode-1"
    environment: dict[str, Any]
    hash: str
    seed: int
    actions: list[list[int]]
    returns: list[float]


def save_recording(recording: Recording, path: Path) -> None:
    """Writes a file whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, json.dumps(recording.model_dump()) + "\n")


def read_recording(path: Path) -> Recording:
    """Returns the episode of a file of one.

    Raises:
      RecordingError: there is no such file, or it holds something else.
    """
    try:
        return Recording.model_validate_json(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise RecordingError(f"{path} cannot be read: {error.strerror}") from None
    except (ValidationError, UnicodeDecodeError):
        raise RecordingError(
            f"{path} does not hold a recorded episode; `sjdsl play GAME --record FILE` writes one, `sjdsl record GAME -o FILE.npz` many"
        ) from None


def check_rules(recording: Recording, game_hash: str, name: str) -> None:
    """Raises RecordingError where the rules of a game, by their hash, are not those of the recording."""
    if game_hash != recording.hash:
        raise RecordingError(
            f"the rules of {name} have changed since the episode was recorded: its hash was {recording.hash}, it is {game_hash}"
        )


def check_returns(recording: Recording, returns: Sequence[float]) -> None:
    """Raises RecordingError where the actions have come to other returns than were recorded."""
    if not np.allclose(returns, recording.returns, rtol=1e-5, atol=1e-5):
        raise RecordingError(f"the episode came to returns {list(map(float, returns))}, but {recording.returns} were recorded")
