"""Episodes in which models played, as recordings beside their calls."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sjdsl.replay.recording import Recording, save_recording, with_tasks_played
from sjdsl.told.parameters import parameters_of
from sjdsl.trainers.policies.evaluation import Evaluation, Tape


def save_tape(
    tape: Tape,
    env: Any,
    seed: int,
    played: Evaluation,
    players: Sequence[Sequence[str]],
    folder: Path,
) -> None:
    """Writes the episodes of a part, `episode_00000.json`, … into the folder of its calls.

    players: `[E][N]`, the name of the policy in each slot of each episode.
    """
    arguments = with_tasks_played(_arguments(env), env.game.task)
    for episode, names in enumerate(players):
        length = int(played.lengths[episode])
        recording = Recording(
            environment=arguments,
            hash=env.hash,
            seed=seed,
            actions=[actions[episode].tolist() for actions in tape.actions[:length]],
            returns=played.returns[episode].tolist(),
            players=list(names),
            keys=[tuple(keys[episode].tolist()) for keys in tape.keys[: length + 1]],
        )
        save_recording(recording, folder / f"episode_{episode:05d}.json")


def _arguments(env: Any) -> dict[str, Any]:
    """Returns arguments of `sjdsl.make` for the same environment; a game of a file has its name."""
    game = env.game
    # The number of agents is one of the sizes, if it can be another.
    sizes = {size.name: size.value for size in game.sizes if not isinstance(size.value, tuple)}
    return {
        "game": game.name,
        "variant": "+".join(game.chosen) or None,
        "params": {**sizes, **parameters_of(env)},
        "map": list(game.rows),
    }
