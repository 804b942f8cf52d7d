"""A course of play on the interpreter: a layout, numbers, words and actions, and every state on the way."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from sjdsl.compiler import ir
from sjdsl.interpreter.account import Account
from sjdsl.interpreter.numbers import real
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.interpreter.state import Outcome, Value, World, default_params
from sjdsl.interpreter.step import read, reset, step
from sjdsl.interpreter.threefry import Draws, Threefry
from sjdsl.properties.biased_words import Luck, Lucky, episode_key, policy_words, reset_key, step_key
from sjdsl.properties.coverage import Feature, happened_in
from sjdsl.properties.monitors import Totals, add_totals
from sjdsl.properties.scripted_policies import choose


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

    happened: see `coverage.py`; began: the same of the phase `start`. left: the real that left float32 in the step after the last state,
      whose actions are the last of `actions`; None if none did. known: what promises read of the states, by the identity of the promise.
    """

    game: ir.Game
    params: Mapping[str, Value]
    worlds: list[World] = field(default_factory=list)
    totals: list[Totals] = field(default_factory=list)
    actions: list[tuple[int, ...]] = field(default_factory=list)
    outcomes: list[Outcome] = field(default_factory=list)
    happened: list[frozenset[Feature]] = field(default_factory=list)
    began: frozenset[Feature] = frozenset()
    left: LeavesFloat32 | None = None
    known: dict[int, list[tuple[Any, ...]]] = field(default_factory=dict)

    @property
    def is_over(self) -> bool:
        """Whether the episode has ended, or cannot go on."""
        last = self.outcomes[-1:] and (self.outcomes[-1].terminated or self.outcomes[-1].truncated)
        return bool(last) or self.left is not None

    def values(self, check: ir.Check) -> list[tuple[Any, ...]]:
        """Returns what a promise of the game reads of each state."""
        known = self.known.setdefault(id(check), [])
        known += [self._read(check, self.worlds[at], self.totals[at]) for at in range(len(known), len(self.worlds))]
        return known

    def add(self, world: World, totals: Totals, checks: Sequence[ir.Check]) -> None:
        """Adds a state. Raises LeavesFloat32, and adds nothing, if a promise cannot be read of it."""
        read_now = [self._read(check, world, totals) for check in checks]
        for check, values in zip(checks, read_now, strict=True):
            self.known.setdefault(id(check), []).append(values)
        self.worlds.append(world)
        self.totals.append(totals)

    def cut(self, steps: int) -> "Played":
        """Returns the course up to the state after so many steps."""
        known = {check: values[: steps + 1] for check, values in self.known.items()}
        lists = (self.actions, self.outcomes, self.happened)
        return Played(
            self.game, self.params, self.worlds[: steps + 1], self.totals[: steps + 1], *(x[:steps] for x in lists), self.began, None, known
        )

    def _read(self, check: ir.Check, world: World, totals: Totals) -> tuple[Any, ...]:
        return tuple(read(self.game, world, e, totals) for e in check.values)


Driver = Callable[[World, int], Sequence[int] | None]  # state, number of the step -> an action for each agent; None: enough


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


def play(
    game: ir.Game,
    course: Course,
    steps: int | None = None,
    checks: Sequence[ir.Check] = (),
    since: Played | None = None,
    driver: Driver | None = None,
) -> Played:
    """Plays a course to its end, to that of the episode, or until a real leaves float32.

    Args:
      steps: at most so many, if the policies say all that is done.
      checks: promises that are read of every state.
      since: how the course begins, as it was played before.
      driver: says what the agents do, in place of the course.
    """
    params, key = params_of(game, course.params), episode_key(course.seed, course.episode)
    if since is None:
        played = _begin(game, course, params, checks)
    else:
        played = since.cut(len(since.outcomes))
    for number in range(len(played.outcomes), len(course.actions) if steps is None else steps):
        if played.is_over:
            break
        world = played.worlds[-1]
        actions = _actions(game, course, world, number, key) if driver is None else driver(world, number)
        if actions is None:
            break
        played.actions.append(tuple(actions))
        _follow(played, words_of(course, number), checks)
    return played


def _begin(game: ir.Game, course: Course, params: Mapping[str, Value], checks: Sequence[ir.Check]) -> Played:
    told: list[Account] = []
    played = Played(game, params)
    try:
        played.add(reset(game, params, words_of(course, -1), told.append), add_totals({}, _nothing(game), game), checks)
    except LeavesFloat32 as left:
        played.left = left
    played.began = happened_in(told)
    return played


def _follow(played: Played, words: Draws, checks: Sequence[ir.Check]) -> None:
    """Takes the step whose actions are the last ones."""
    told: list[Account] = []
    try:
        world, outcome = step(played.game, played.worlds[-1], played.actions[-1], played.params, words, told.append)
        played.add(world, add_totals(played.totals[-1], outcome.events, played.game), checks)
    except LeavesFloat32 as left:
        played.left = left
        return
    played.happened.append(happened_in(told))
    played.outcomes.append(outcome)


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
