"""The names of policies, on the command line, in a configuration and in Python.

random                        every action with equal probability
stay                          always the action `stay`
NAME                          a policy that the game's file declares
RUN                           the last policy of a run, by its folder; of several seeds RUN/seed_2
RUN@best, RUN@120             its best, or that of an update
FILE.safetensors              a stored policy, with its .json beside it
FILE.py:NAME                  a user's function, also by a registered name
FILE.toml:NAME                a language model, in a role with NAME+ROLE
you                           a person, in line-ups of `sjdsl play` and `sjdsl studio`
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sjdsl.near_names import meant

from .extensions import absolute_name, is_own, name_of

UNTRAINED = ("random", "stay")  # they need no file: `sjdsl.runtime.policy.UNTRAINED`
YOU = "you"
LARGEST_DESCRIPTION = 2**20  # bytes of the .json beside a stored policy
KNOWN = (
    "random, stay, a policy of the game's file, the folder RUN of a run, RUN@best, RUN@UPDATE, "
    "RUN/seed_N, a .safetensors file, FILE.py:FUNCTION, or models.toml:NAME"
)


def split_name(name: str) -> tuple[Path, str | int]:
    """Returns the folder or file of a name, and which policy: `last`, `best` or an update."""
    run, at, which = name.rpartition("@")
    if not at or Path(name).exists():
        return Path(name), "last"
    if which.isdecimal():
        return Path(run), int(which)
    return Path(run), which


def absolute_policy_name(policy: Any) -> str:
    """Returns a policy's name as it works from every folder; a function gets a name."""
    if not isinstance(policy, str | Path):
        return name_of("policy", policy)
    name = str(policy)
    path, which = split_name(name)
    if not name or not path.exists():
        return absolute_name("policy", name)
    return str(path.resolve()) if path == Path(name) else f"{path.resolve()}@{which}"


def might_be_named(name: str, declared: Sequence[str] = ()) -> bool:
    """Whether a text can be the name of a policy: a known word, a path, or a user's own.

    Args:
      declared: names of the policies that the game's file declares.
    """
    path, _ = split_name(name)
    return name in (*UNTRAINED, *declared) or path.exists() or is_own("policy", name)


def unknown_policy(name: str, declared: Sequence[str] = ()) -> str:
    """Returns the message about a text that names no policy."""
    near = meant(name, (*UNTRAINED, *declared), "")
    if near:
        return f"there is no policy `{name}`{near} A policy is {KNOWN}"
    return f"there is no policy `{name}`; a policy is {KNOWN}"


def seat_of_person(seats: Sequence[str], num_agents: int, game: str) -> int | None:
    """Returns the agent that a person plays in a line-up, None if it is nobody.

    Args:
      seats: the name of who plays each agent; game: the name of the game, for messages.

    Raises:
      ValueError: they aren't as many as the agents, or a person plays several.
    """
    if len(seats) != num_agents:
        raise ValueError(
            f"{game} has {num_agents} agents, but --slots names {len(seats)}; name one for each"
        )
    yours = [agent for agent, name in enumerate(seats) if name == YOU]
    if len(yours) > 1:
        raise ValueError(f"`{YOU}` can play one agent; it is named {len(yours)} times")
    return yours[0] if yours else None
