"""Policies on the interpreter: random actions, no actions, or a policy of the game's file."""

from collections.abc import Callable

from sjdsl.compiler import ir
from sjdsl.interpreter.state import World
from sjdsl.interpreter.threefry import Threefry
from sjdsl.policies.interpreted import choose
from sjdsl.trace.jax_random import keys_of, random_numbers

# Number of the step from 0, state -> an action for each agent.
Chosen = Callable[[int, World], list[int]]
# Seed of an episode, number of steps played before it -> what the agents do in it.
ByEpisode = Callable[[int, int], Chosen]


def random_actions(game: ir.Game, seed: int) -> Chosen:
    """Returns actions drawn with equal probability, as those of `sjdsl.render.random_policy`."""
    keys = keys_of(seed)
    num_actions = len(game.agents.actions)
    return lambda number, _world: random_numbers(
        keys.of_choices(number), game.agents.number, num_actions
    )


def no_actions(game: ir.Game) -> Chosen:
    """Returns `stay` for each agent."""
    stay = [game.agents.actions.index("stay")] * game.agents.number
    return lambda _number, _world: stay


def scripted_actions(game: ir.Game, name: str, seed: int) -> Chosen:
    """Returns the actions of a policy of the game's file.

    They are those of `sjdsl.policies.compiled.scripted_policy` in the compiled game.
    """
    policy = next(policy for policy in game.policies if policy.name == name)
    keys = keys_of(seed)
    agents = range(game.agents.number)

    def choose_all(number: int, world: World) -> list[int]:
        draws = Threefry(*keys.of_choices(number))
        bits = [(draws.bits(0, 2 * agent), draws.bits(0, 2 * agent + 1)) for agent in agents]
        return [choose(policy, game, world, agent, bits[agent]) for agent in agents]

    return choose_all


def chooser(game: ir.Game, policy: str, seed: int) -> Chosen:
    """Returns the actions of a policy: `random`, `stay`, or one of the game's file."""
    match policy:
        case "random":
            return random_actions(game, seed)
        case "stay":
            return no_actions(game)
        case _:
            return scripted_actions(game, policy, seed)
