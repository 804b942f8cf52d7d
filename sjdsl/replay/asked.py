"""Recorded episodes of models: with their reasons, and with the messages that they got."""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sjdsl.models.asking import Question
from sjdsl.models.errors import ModelError
from sjdsl.models.files import find_model, is_model_name
from sjdsl.models.policy import Reply
from sjdsl.models.recorded import FOLDER, check_request, file_of, read_talks, reasons
from sjdsl.models.seats import Seats
from sjdsl.replay.recording import Recording, RecordingError, read_recording

if TYPE_CHECKING:
    from sjdsl.replay.episode_player import EpisodePlayer


def asked_recording(folder: Path, episode: int) -> Recording:
    """Returns a finished episode of an experiment's folder, with the reasons of its models.

    Args:
      episode: its number among all that are finished, part by part.

    Raises:
      RecordingError: there is none. ModelError: a file of calls is damaged.
    """
    file = _file_of_episode(folder, episode)
    recording = read_recording(file)
    size = (len(recording.actions), len(recording.returns))
    return recording.model_copy(update={"why": reasons(file.parent, _number(file), *size)})


def calls_of(path: Path, episode: int, seed: int) -> tuple[Path, int]:
    """Returns where the calls of a recorded episode are: a part's folder, and a number in it.

    Args:
      path: a file of `sjdsl record`, or the folder of an experiment.
      episode: its number among all that are finished in a folder; a file has one alone.
      seed: of the episode.
    """
    if path.is_dir():
        file = _file_of_episode(path, episode)
        return file.parent, _number(file)
    return path.with_name(f"{path.stem}_models") / FOLDER / f"seed_{seed}", 0


def told_messages(
    recording: Recording, player: "EpisodePlayer", calls: tuple[Path, int], agents: Sequence[int]
) -> Iterator[str]:
    """Yields what agents were asked in an episode, made again, and what they replied.

    Args:
      player: at the start of the episode.
      calls: of `calls_of`.
      agents: those whose messages are wanted; what they are told of the game comes first.

    Raises:
      RecordingError: a player is no model of a file, or no model played these agents.
      ModelError: messages differ from the recorded.
    """
    folder, episode = calls
    env: Any = player.env
    paths = {agent: file_of(folder, episode, agent) for agent in range(env.num_agents)}
    talks = {agent: read_talks(path) for agent, path in paths.items() if path.exists()}
    if talks.keys().isdisjoint(agents):
        raise RecordingError(
            f"no model played agent {', '.join(map(str, agents))}; "
            f"models played {', '.join(map(str, talks)) or 'none'}"
        )
    hosts = {agent: _model(recording, agent) for agent in talks}
    told: list[str] = []  # since the last step
    introduced: set[int] = set()  # whose text about the game was told

    def ask(question: Question) -> Reply:
        agent = question.agent
        talk = talks[agent].get((question.step, question.kind))
        if talk is None:
            raise ModelError(f"{paths[agent]} has no call of step {question.step}")
        check_request(talk, question, paths[agent])
        if agent in agents:
            told.extend(_in_words(question, talk.reply, is_first=agent not in introduced))
            introduced.add(agent)
        return talk.reply

    def of_episode(value: Any) -> np.ndarray:
        """Returns an array with an axis of episodes before it; only the last one is played."""
        array = np.asarray(value)
        return np.broadcast_to(array, (episode + 1, *array.shape))

    with Seats(env, [{}] * episode + [hosts], ask, parallel=1) as seats:
        for actions in recording.actions:
            allowed = env.allowed_actions(player.state)
            seats.choose(of_episode(player.observation), of_episode(allowed), of_episode(False))
            moment = player.step(actions)
            trial_ended = player.info.get("trial_ended", False)
            seats.learn(of_episode(moment.reward), of_episode(trial_ended), of_episode(moment.done))
            yield from told
            told.clear()


def _in_words(question: Question, reply: Reply, is_first: bool) -> Iterator[str]:
    """Yields a message and its reply; before the first one what the agent is told of the game."""
    agent = question.agent
    if is_first:
        yield f"---- what agent {agent} is told of the game\n\n{question.message.system}"
    yield f"---- to agent {agent} before step {question.step}\n\n{question.message.text}"
    yield "---- its reply\n"
    yield f"{reply.action if reply.answer is None else reply.answer.text}\n"


def _model(recording: Recording, agent: int) -> Any:
    name = recording.players[agent] if recording.players else ""
    if not is_model_name(name):
        raise RecordingError(f"agent {agent} was {name or 'unknown'}, not a model of a file")
    return find_model(name)


def _file_of_episode(folder: Path, episode: int) -> Path:
    files = sorted(folder.glob(f"{FOLDER}/*/episode_*.json"))
    if not -len(files) <= episode < len(files):
        raise RecordingError(
            f"{folder} has no episode {episode}: it has {len(files)} finished ones in which models "
            "played, counted from 0"
        )
    return files[episode]


def _number(file: Path) -> int:
    digits = re.search(r"\d+", file.stem)
    assert digits is not None, file
    return int(digits[0])
