"""A course of play on the interpreter: a layout, numbers, words and actions, and every state on the way."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from sjdsl.compiler import ir
from sjdsl.interpreter.account import Account
from sjdsl.interpreter.draws import Draws, Threefry
from sjdsl.interpreter.numbers import real
from sjdsl.interpreter.state import Outcome, Value, World, default_params
from sjdsl.interpreter.step import read, reset, step
from sjdsl.promises.draws import Luck, Lucky, episode_key, policy_words, reset_key, step_key
from sjdsl.promises.policies import choose
from sjdsl.promises.watch import Totals, add_totals


@dataclass(frozen=True)
class Course:
    """What a course is made of.

    rows: the map. params: numbers that differ from the file's. seed, episode: where the words come from; luck: of each step.
    actions: what each agent does in each step, or would do; policies: for each agent a scripted policy, or None: as in `actions`.
    """

    rows: tuple[str, ...]
    agents: int
    params: tuple[tuple[str, Value], ...]
    seed: int
    luck: tuple[Luck, ...]
    actions: tuple[tuple[int, ...], ...]
    policies: tuple[ir.Policy | None, ...]
    episode: int = 0


@dataclass
class Played:
    """A course as it went. `worlds`, `totals`: the first state and the one after each step; the other lists: of each step.

    happened: where in the file the sentences stand that wrote something, and the branches of chances, as (start, branch or -1).
    """

    game: ir.Game
    params: Mapping[str, Value]
    worlds: list[World]
    totals: list[Totals]
    actions: list[tuple[int, ...]] = field(default_factory=list)
    outcomes: list[Outcome] = field(default_factory=list)
    happened: list[frozenset[tuple[int, int]]] = field(default_factory=list)

    def values(self, check: ir.Check) -> list[tuple[Any, ...]]:
        """Returns what a promise of the game reads of each state."""
        return [self.values_at(check, at) for at in range(len(self.worlds))]

    def values_at(self, check: ir.Check, at: int) -> tuple[Any, ...]:
        """Returns what a promise reads of one state."""
        return tuple(read(self.game, self.worlds[at], e, self.totals[at]) for e in check.values)


def params_of(game: ir.Game, given: Sequence[tuple[str, Value]]) -> dict[str, Value]:
    """Returns the numbers of a course as the interpreter has them."""
    types = {p.name: p.type for p in game.params}
    return default_params(game) | {name: real(value) if types[name].kind == "real" else value for name, value in given}


def words_of(course: Course, at: int) -> Draws:
    """Returns the words of a step (0, 1, …), or of the phase `start` (-1)."""
    key = episode_key(course.seed, course.episode)
    if at < 0:
        return reset_key(key)
    return Lucky(step_key(key, at), course.luck[at]) if course.luck else step_key(key, at)


def play(game: ir.Game, course: Course, steps: int | None = None) -> Played:
    """Plays a course, to its end or to that of the episode. `steps`: at most so many, if the policies say all that is done."""
    params, key = params_of(game, course.params), episode_key(course.seed, course.episode)
    world = reset(game, params, words_of(course, -1))
    played = Played(game, params, [world], [add_totals({}, _nothing(game), game)])
    for number in range(len(course.actions) if steps is None else steps):
        actions, told = _actions(game, course, world, number, key), []
        world, outcome = step(game, world, actions, params, words_of(course, number), told.append)
        played.happened.append(_happened(told))
        played.worlds.append(world)
        played.actions.append(actions)
        played.outcomes.append(outcome)
        played.totals.append(add_totals(played.totals[-1], outcome.events, game))
        if outcome.terminated or outcome.truncated:
            break
    return played


def _happened(told: list[Account]) -> frozenset[tuple[int, int]]:
    places = [(d.sentence.origin, -1) for account in told for d in account.done]
    places += [
        (d.sentence.origin, -2 if d.result is None else d.result)
        for account in told
        for d in account.drawn
        if isinstance(d.sentence, ir.Chance)
    ]
    return frozenset((origin.start, branch) for origin, branch in places if origin is not None)


def _actions(game: ir.Game, course: Course, world: World, number: int, key: Threefry) -> tuple[int, ...]:
    words = policy_words(key, number, course.agents) if any(course.policies) else []
    return tuple(
        course.actions[number][agent] if policy is None else choose(policy, game, world, agent, words[agent])
        for agent, policy in enumerate(course.policies)
    )


def _nothing(game: ir.Game) -> dict[str, Any]:
    agents = range(game.agents.number)
    zeros = {e.name: [0] * len(e.by) if e.by else 0 for e in game.events}
    return {e.name: [zeros[e.name] for _ in agents] if e.per_agent else zeros[e.name] for e in game.events}


def accounts(played: Played, course: Course, at: int) -> list[Account]:
    """Returns the account of a step (0, 1, …) of a course, turn by turn."""
    found: list[Account] = []
    step(played.game, played.worlds[at], played.actions[at], played.params, words_of(course, at), found.append)
    return found
