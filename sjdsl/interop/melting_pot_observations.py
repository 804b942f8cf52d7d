"""What Melting Pot lets a player observe beside its picture, read from the state of our games as `games/meltingpot.toml` says."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from sjdsl.runtime.env import Environment

Rule = Mapping[str, Any]


def observe(env: Environment, state: Any, rule: Rule) -> np.ndarray:
    """Returns one observation of all players, `[N, …]` float64 (int64 for counts that Melting Pot gives as integers).

    A rule is one of these; fields are those of `agents`, and a number may be the name of a parameter or a size:

    * `{ timer, of }`: the share of a pause that is over, `1 - timer / of`; not below 0, and 0 for who is away, but with `bare = true`.
      With `action`, also 0 where that action is forbidden though the timer has run out;
    * `{ action }`: 1 where it is allowed;
    * `{ field }`: its values, in a row; `whole = true` for int64; `{ field, of }`: its share, 0 for who is away;
    * `{ fields }`: several rows of counts, -1 where there is none;
    * `{ ballots, state }`: a row a player: whom it votes for; nobody; and whether its state, a word, is not the first one, which has no vote.
    """
    here = np.asarray(state.position) > 0

    def of_agents(name: str) -> np.ndarray:
        return np.asarray(getattr(state, f"agent_{name}"))

    match rule:
        case {"timer": str(name), "of": of}:
            over = 1 - of_agents(name) / number(env, of)
            if "action" in rule:
                over = np.where((over < 1) | allowed(env, state, rule["action"]), over, 0)
            return over if rule.get("bare") else np.where(here, np.maximum(over, 0), 0)
        case {"action": str(name)}:
            return allowed(env, state, name).astype(np.float64)
        case {"field": str(name), "of": of}:
            return np.where(here, of_agents(name) / number(env, of), 0)
        case {"field": str(name)}:
            return (
                of_agents(name)
                .reshape(env.num_agents, -1)
                .astype(np.int64 if rule.get("whole") else np.float64)
            )
        case {"fields": [*names]}:
            rows = np.stack([of_agents(name) for name in names], axis=1).astype(np.float64)
            return np.where(rows.any(axis=2, keepdims=True), rows, -1)
        case {"ballots": str(ballots), "state": str(name)}:
            choice = np.where(of_agents(name) == 0, of_agents(ballots), env.num_agents + 1)
            return np.broadcast_to(
                np.eye(env.num_agents + 2)[choice],
                (env.num_agents, env.num_agents, env.num_agents + 2),
            )
        case _:
            raise ValueError(f"games/meltingpot.toml: no observation is made of {dict(rule)}")


def allowed(env: Environment, state: Any, action: str) -> np.ndarray:
    """Returns whether each agent may choose an action, `[N]` bool."""
    return np.asarray(env.allowed_actions(state))[:, env.action_names.index(action)]


def number(env: Environment, of: float | str) -> float:
    """Returns a number, or the value of the parameter or size of this name."""
    if not isinstance(of, str):
        return of
    sizes = {size.name: size.value for size in env.game.sizes}
    return float(sizes[of] if of in sizes else getattr(env.params, of))
