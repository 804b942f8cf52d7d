"""Measures everything that needs a GPU, most important first; the figures of each part are stored
as soon as there are any."""

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

from bench.speed.kernels import measure_kernels
from bench.speed.resuming import measure_resume
from bench.speed.stored import Figures
from bench.speed.training import Network, Training, measure_training, training_setups
from sjdsl.bench.loop import Task
from sjdsl.bench.stored import write_figures
from sjdsl.bench.timing import measure
from sjdsl.runtime.env import Environment

ENVS = (1024, 4096, 16_384, 65_536)  # a GPU needs many
TRAINED = (256, 128)  # environments and steps of a rollout
WORKERS = 8  # programs compiled at the same time


class Part(NamedTuple):
    """One measurement, and the name of its file."""

    name: str
    measure: Callable[[], Figures]


def parts_of(
    tasks: Sequence[Task], resumed: str, num_envs: Sequence[int] = ENVS, repeats: int = 5
) -> Iterator[Part]:
    """Yields speeds with tokens, kernels, resuming, updates with the small network, speeds with
    one-hot, updates with convolutions.

    Args:
      tasks: games; updates with convolutions are measured for those with the smallest, the middle
        and the largest observation only.
      resumed: the game of which a run is stopped and resumed, by name or file.
      num_envs: the numbers of environments for speeds, each a part; kernels are those of the
        largest.
      repeats: rounds.
    """
    tokens = [task for task in tasks if task.observation == "tokens"]
    others = [task for task in tasks if task.observation != "tokens"]
    envs = [task.env for task in tokens if task.env is not None]
    envs.sort(key=lambda env: math.prod(env.observation_shape))

    def speeds(observation: str, forms: Sequence[Task]) -> Iterator[Part]:
        """Yields a part for each number of environments."""
        for number in num_envs if forms else ():
            measurement = partial(measure, forms, [number], repeats, workers=WORKERS)
            yield Part(f"speed_{observation}_{number}", measurement)

    yield from speeds("tokens", tokens)
    yield Part("kernels", partial(measure_kernels, tokens, max(num_envs), repeats))
    yield Part("resuming", partial(measure_resume, resumed))
    for env in envs:
        yield Part(f"training_mlp_{env.name}", partial(measure_update, env, "mlp", repeats))
    yield from speeds("onehot", others)
    for index in sorted({0, len(envs) // 2, len(envs) - 1}) if envs else ():
        env = envs[index]
        yield Part(f"training_cnn_{env.name}", partial(measure_update, env, "cnn", repeats))


def measure_update(env: Environment, network: Network, repeats: int) -> Training:
    """Returns the parts of one update of IPPO. Raises ValueError if the game doesn't allow it."""
    num_envs, num_steps = TRAINED
    setups, refused = training_setups(
        [(env.name, env)], [network], num_envs=num_envs, num_steps=num_steps
    )
    if refused:
        raise ValueError("; ".join(refused))
    return measure_training(setups, repeats)


def measure_everything(
    parts: Sequence[Part], folder: Path, tell: Callable[[str], object] = print
) -> list[str]:
    """Measures the parts in turn, each into `folder/NUMBER_NAME.json`.

    If it is stopped, the files of the parts before that stay.

    Args:
      parts: in order of importance.
      folder: a new one.
      tell: called with a line whenever a part begins or fails.
    Returns:
      a line for each part that has failed.
    """
    folder.mkdir(parents=True)
    failed = []
    for number, part in enumerate(parts, start=1):
        tell(f"{number} of {len(parts)}: {part.name}")
        try:
            write_figures(folder / f"{number:02}_{part.name}.json", part.measure())
        except Exception as error:  # the other parts are still worth measuring
            failed.append(f"{part.name} failed: {type(error).__name__}: {error}")
            tell(failed[-1])
    return failed
