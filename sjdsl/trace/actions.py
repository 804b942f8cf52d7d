"""The actions of a trace: drawn at random, listed step by step, or those of a policy."""

from sjdsl.compiler import ir
from sjdsl.library.action_names import split_actions
from sjdsl.near_names import meant
from sjdsl.trace.choices import ByEpisode, random_actions, scripted_actions

RANDOM = "random"


def read_actions(text: str, game: ir.Game, steps: int | None) -> tuple[ByEpisode, int | None]:
    """Returns what the agents do, and the number of steps if the text lists several.

    Args:
      text: `random`, or steps separated by `;`, each with an action for each agent or one for all;
        a single step is repeated.
      steps: how many are wanted, None for as many as there are.

    Raises:
      ValueError: an action is unknown, the number of actions is wrong, or there are too few steps.
    """
    if text == RANDOM:
        return lambda seed, _before: random_actions(game, seed), None
    lines = []
    for line in text.split(";"):
        names = list(filter(None, split_actions(line, r"[,\s]+")))
        if names:
            lines.append(names)
    if not lines:
        raise ValueError(
            f"`{text}` names no actions; the game has {', '.join(game.agents.actions)}"
        )
    actions = [_actions_of_step(names, number, game) for number, names in enumerate(lines, 1)]
    if len(actions) == 1:
        return lambda _seed, _before: lambda _number, _world: actions[0], None
    if steps is not None and steps > len(actions):
        raise ValueError(
            f"actions are written for {len(actions)} steps, not for {steps}; name fewer --steps "
            "or more actions"
        )
    return lambda _seed, before: lambda number, _world: actions[before + number], len(actions)


def policy_actions(name: str, game: ir.Game) -> ByEpisode:
    """Returns what agents do that all follow a policy of the game's file.

    Raises:
      ValueError: the file has no such policy.
    """
    declared = [policy.name for policy in game.policies]
    if name not in declared:
        have = meant(name, declared, "it has") if declared else ""
        trained = "of a trained one `sjdsl record` stores episodes, which `sjdsl replay` shows"
        raise ValueError(f"the file of the game has no policy `{name}` ({trained}){have}")
    return lambda seed, _before: scripted_actions(game, name, seed)


def _actions_of_step(names: list[str], step: int, game: ir.Game) -> list[int]:
    """Returns the number of each agent's action in a step. Raises ValueError."""
    num_agents = game.agents.number
    known = game.agents.actions
    for name in names:
        if name not in known:
            raise ValueError(
                f"there is no action `{name}` (step {step}){meant(name, known, 'the game has')}"
            )
    if len(names) not in (1, num_agents):
        raise ValueError(
            f"step {step} has {len(names)} actions; write one for each of the {num_agents} "
            "agents, or one for all"
        )
    actions = [known.index(name) for name in names]
    return actions * num_agents if len(actions) == 1 else actions
