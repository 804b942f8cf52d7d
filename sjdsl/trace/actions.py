"""The actions of a trace: drawn at random, given step by step, or those of a policy."""

from sjdsl.compiler import ir
from sjdsl.library.action_names import split_actions
from sjdsl.near_names import meant
from sjdsl.trace.choices import ByEpisode, random_actions, scripted_actions

RANDOM = "random"


def read_actions(text: str, game: ir.Game, steps: int | None) -> tuple[ByEpisode, int | None]:
    """Returns what the agents do, and for how many steps if that is written down.

    Args:
      text: `random`, or the steps: a part up to `;` for each, with an action for each agent or one for all; a single step is repeated.
    Raises ValueError: an unknown action, not one for each agent, fewer steps than asked for.
    """
    if text == RANDOM:
        return lambda seed, _before: random_actions(game, seed), None
    lines = [
        words
        for words in (
            list(filter(None, split_actions(line, r"[,\s]+"))) for line in text.split(";")
        )
        if words
    ]
    if not lines:
        raise ValueError(
            f"`{text}` names no actions; the game has {', '.join(game.agents.actions)}"
        )
    taken = [_step(words, number, game) for number, words in enumerate(lines, 1)]
    if len(taken) == 1:
        return lambda _seed, _before: lambda _number, _world: taken[0], None
    if steps is not None and steps > len(taken):
        raise ValueError(
            f"actions are written for {len(taken)} steps, not for {steps}; name fewer --steps or more actions"
        )
    return lambda _seed, before: lambda number, _world: taken[before + number], len(taken)


def policy_actions(name: str, game: ir.Game) -> ByEpisode:
    """Returns what agents do that all follow a policy of the game's file. Raises ValueError for one that it does not have."""
    declared = [policy.name for policy in game.policies]
    if name not in declared:
        have = meant(name, declared, "it has") if declared else ""
        trained = "of a trained one `sjdsl record` stores episodes, which `sjdsl replay` shows"
        raise ValueError(f"the file of the game has no policy `{name}` ({trained}){have}")
    return lambda seed, _before: scripted_actions(game, name, seed)


def _step(words: list[str], number: int, game: ir.Game) -> list[int]:
    names, agents = game.agents.actions, game.agents.number
    for word in words:
        if word not in names:
            raise ValueError(
                f"there is no action `{word}` (step {number}){meant(word, names, 'the game has')}"
            )
    if len(words) not in (1, agents):
        raise ValueError(
            f"step {number} has {len(words)} actions; write one for each of the {agents} agents, or one for all"
        )
    return [names.index(word) for word in words] * (agents if len(words) == 1 else 1)
