"""The observations of a player in Melting Pot beside its picture.

They are computed from the state of our games by the rules in `games/meltingpot.toml`.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from sjdsl.runtime.env import Environment

Rule = Mapping[str, Any]


def observe(env: Environment, state: Any, rule: Rule) -> np.ndarray:
    """Returns one observation of all players, `[N, …]` float64.

    It is int64 for counts that Melting Pot gives as integers.

    A rule is one of these; fields are those of `agents`, and a number may be the name of a
    parameter or a size:

    * `{ timer, of }`: the share of a pause that is over, `1 - timer / of`. Unless there is
      `bare = true`, it is at least 0, and 0 for an agent that is off the map. With `action`, it is
      also 0 where that action is forbidden although the timer has run out;
    * `{ action }`: 1 where it is allowed;
    * `{ field }`: its values, flattened; `whole = true` for int64; `{ field, of }`: the share
      `field / of`, 0 for an agent that is off the map;
    * `{ fields }`: several rows of counts, -1 in rows without any;
    * `{ ballots, state }`: a one-hot row for each player: the player it votes for; nobody; or that
      it has no vote, because its state isn't the first enum value.
    """
    is_on_map = np.asarray(state.position) > 0

    def field(name: str) -> np.ndarray:
        return np.asarray(getattr(state, f"agent_{name}"))

    match rule:
        case {"timer": str(name), "of": duration}:
            share = 1 - field(name) / number(env, duration)
            if "action" in rule:
                is_allowed = allowed(env, state, rule["action"])
                share = np.where((share < 1) | is_allowed, share, 0)
            return share if rule.get("bare") else np.where(is_on_map, np.maximum(share, 0), 0)
        case {"action": str(name)}:
            return allowed(env, state, name).astype(np.float64)
        case {"field": str(name), "of": maximum}:
            return np.where(is_on_map, field(name) / number(env, maximum), 0)
        case {"field": str(name)}:
            dtype = np.int64 if rule.get("whole") else np.float64
            return field(name).reshape(env.num_agents, -1).astype(dtype)
        case {"fields": [*names]}:
            counts = np.stack([field(name) for name in names], axis=1).astype(np.float64)
            return np.where(counts.any(axis=2, keepdims=True), counts, -1)
        case {"ballots": str(ballots), "state": str(name)}:
            no_vote = env.num_agents + 1
            one_hot = np.eye(no_vote + 1)[np.where(field(name) == 0, field(ballots), no_vote)]
            return np.broadcast_to(one_hot, (env.num_agents, env.num_agents, no_vote + 1))
        case _:
            raise ValueError(f"games/meltingpot.toml: no observation is made of {dict(rule)}")


def allowed(env: Environment, state: Any, action: str) -> np.ndarray:
    """Returns whether each agent may choose an action, `[N]` bool."""
    return np.asarray(env.allowed_actions(state))[:, env.action_names.index(action)]


def number(env: Environment, value: float | str) -> float:
    """Returns a number, or the value of the parameter or size of this name."""
    if not isinstance(value, str):
        return value
    sizes = {size.name: size.value for size in env.game.sizes}
    return float(sizes[value] if value in sizes else getattr(env.params, value))
