"""Hours that a long training run would take, extrapolated from updates that were measured."""

from collections.abc import Iterable
from dataclasses import dataclass

from bench.speed.training_split import Algorithm, Network, Sharing, Split

SECONDS_PER_HOUR = 3600


@dataclass(frozen=True)
class Hours:
    """Hours of one seed's run, without compiling and evaluating: at the speed of the median, the fastest and the slowest round."""

    name: str
    num_agents: int
    network: Network
    algorithm: Algorithm
    sharing: Sharing
    num_envs: int
    num_steps: int
    env_steps_per_s: float
    hours: float
    shortest: float
    longest: float


def hours_to(env_steps: int, splits: Iterable[Split]) -> tuple[Hours, ...]:
    """Returns the hours that each of the updates measured would take for so many environment steps."""
    return tuple(_hours_of(env_steps, split) for split in splits)


def _hours_of(env_steps: int, split: Split) -> Hours:
    def at(rate: float) -> float:
        return env_steps / rate / SECONDS_PER_HOUR

    steps = split.num_envs * split.num_steps
    return Hours(
        split.name,
        split.num_agents,
        split.network,
        split.algorithm,
        split.sharing,
        split.num_envs,
        split.num_steps,
        split.env_steps_per_s,
        at(split.env_steps_per_s),
        at(steps / min(split.update)),
        at(steps / max(split.update)),
    )
