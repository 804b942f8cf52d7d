"""What agents do by themselves on the interpreter: at random, nothing, or what a policy of the game's file says."""

from collections.abc import Callable

from sjdsl.compiler import ir
from sjdsl.interpreter.state import World
from sjdsl.interpreter.threefry import Threefry
from sjdsl.policies.interpreted import choose
from sjdsl.trace.jax_random import keys_of, random_numbers

Chosen = Callable[
    [int, World], list[int]
]  # number of the step from 0, state -> an action for each agent
ByEpisode = Callable[
    [int, int], Chosen
]  # seed of an episode, number of steps played before it -> what the agents do in it


def random_actions(game: ir.Game, seed: int) -> Chosen:
    """Returns who draws every action with equal probability, as `sjdsl.render.random_policy` does."""
    keys, count, actions = keys_of(seed), game.agents.number, len(game.agents.actions)
    return lambda number, _world: random_numbers(keys.of_choices(number), count, actions)


def no_actions(game: ir.Game) -> Chosen:
    """Returns who does nothing."""
    stay = [game.agents.actions.index("stay")] * game.agents.number
    return lambda _number, _world: stay


def scripted_actions(game: ir.Game, name: str, seed: int) -> Chosen:
    """Returns who follows a policy of the game's file: what `sjdsl.policies.compiled.scripted_policy` does in the compiled game."""
    policy = next(policy for policy in game.policies if policy.name == name)
    keys, agents = keys_of(seed), range(game.agents.number)

    def choose_all(number: int, world: World) -> list[int]:
        draws = Threefry(*keys.of_choices(number))
        bits = [(draws.bits(0, 2 * agent), draws.bits(0, 2 * agent + 1)) for agent in agents]
        return [choose(policy, game, world, agent, bits[agent]) for agent in agents]

    return choose_all


def chooser(game: ir.Game, policy: str, seed: int) -> Chosen:
    """Returns the actions of agents that nobody controls. `policy`: `random`, `stay`, or the name of one of the game's policies."""
    if policy in ("random", "stay"):
        return random_actions(game, seed) if policy == "random" else no_actions(game)
    return scripted_actions(game, policy, seed)
