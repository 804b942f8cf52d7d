"""The file of a recorded episode: its game, its seed, the actions of all agents."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from sjdsl.compiler import ir
from sjdsl.files import LARGEST_JSON, read_bytes, write_whole
from sjdsl.library.tasks import ARGUMENTS, replaced_tasks, with_tasks


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
Word = Annotated[int, Field(ge=0, lt=2**32)]


class Recording(BaseModel):
    """One episode; JSON with these names.

    environment: the arguments of `sjdsl.make`, among them the tasks played if the game has a task.
    hash: of the rules, which a replay has to have.
    actions: for each step, the number of each agent's action; returns: of each agent, to check a
    replay. players: who played each agent, by the names of policies, `you` for a person.
    keys: two words for the start and for each step; without them those of the seed are used.
    why: for each step, what each agent gave as its reason.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    format: Literal["sjdsl-episode-1"] = "sjdsl-episode-1"
    environment: dict[str, Any]
    hash: str
    seed: Seed
    actions: list[list[int]]
    returns: list[float]
    players: list[str] | None = None
    keys: list[tuple[Word, Word]] | None = None
    why: list[list[str]] | None = None


OPTIONAL = ("players", "keys", "why")  # left out of a file if they aren't known


def save_recording(recording: Recording, path: Path) -> None:
    """Writes the file of an episode, whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, recording_text(recording))


def recording_text(recording: Recording) -> str:
    """Returns what the file of an episode says."""
    unknown = {name for name in OPTIONAL if getattr(recording, name) is None}
    return json.dumps(recording.model_dump(exclude=unknown)) + "\n"


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


def with_tasks_played(environment: Mapping[str, Any], task: ir.Task | None) -> dict[str, Any]:
    """Returns arguments of `sjdsl.make` that name the tasks played, however those were chosen.

    Args:
      environment: the arguments without them, or with another way to say them.
      task: as it is played; None in a game without one.
    """
    if task is None:
        return dict(environment)
    choice: dict[str, Any] = {"tasks": task.played}
    if task.split:
        choice["split"] = task.split
    return replaced_tasks(environment, choice)


def check_tasks(recording: Recording, game: ir.Game | None, name: str) -> None:
    """Raises RecordingError if a game plays other tasks than were recorded.

    The hash is the same for all of them. A recording that names no tasks is one of all.

    Args:
      game: as it plays; None without a compiler, where all tasks are played.
    """
    stored = {key: recording.environment.get(key) for key in ARGUMENTS}
    recorded: dict[str, Any] = {key: value for key, value in stored.items() if value is not None}
    played: dict[str, Any] = {"tasks": "all"}
    if game is not None and game.task is not None:
        played = with_tasks_played({}, game.task)
        try:
            task = with_tasks(game, **(recorded or {"tasks": "all"})).task
        except (ValueError, TypeError) as error:
            raise RecordingError(f"the recording names tasks that {name} lacks: {error}") from None
        if task is not None:
            recorded = with_tasks_played({}, task)
    if (recorded or {"tasks": "all"}) != played:
        raise RecordingError(
            f"the episode was recorded with other tasks of {name}: {_said(recorded)} there, "
            f"{_said(played)} here"
        )


def _said(choice: Mapping[str, Any]) -> str:
    return ", ".join(f"{name}={value!r}" for name, value in choice.items())


def check_rules(recording: Recording, game_hash: str, name: str) -> None:
    """Raises RecordingError if the hash of a game's rules differs from that of the recording."""
    if game_hash != recording.hash:
        raise RecordingError(
            f"the rules of {name} have changed since the episode was recorded: the hash was "
            f"{recording.hash}, and is now {game_hash}"
        )


def check_actions(recording: Recording, num_agents: int, num_actions: int) -> None:
    """Raises RecordingError if a step lacks one valid action for each agent, a reason or a key."""
    steps = len(recording.actions)
    are_whole = recording.why is None or list(map(len, recording.why)) == [num_agents] * steps
    if not are_whole or (recording.keys is not None and len(recording.keys) != steps + 1):
        raise RecordingError(
            f"the reasons or the keys of the episode aren't those of {steps} steps"
        )
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
