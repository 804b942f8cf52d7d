"""Trajectories on the interpreter: a scenario (map, parameters, seed, actions) and every state and outcome it leads to."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.sorts import Level
from sjdsl.interpreter.account import Account
from sjdsl.interpreter.numbers import real
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.interpreter.state import Outcome, Value, World, default_params
from sjdsl.interpreter.step import Totals, read, reset, step
from sjdsl.interpreter.threefry import Draws, Threefry
from sjdsl.properties.biased_draws import Bias, BiasedDraws, episode_key, policy_bits, reset_key, step_key
from sjdsl.properties.monitors import add_totals
from sjdsl.properties.scripted_policies import choose
from sjdsl.properties.statements import Feature, features_of


@dataclass(frozen=True)
class Scenario:
    """Everything that determines a trajectory.

    rows: the map. params, sizes: parameters and sizes that differ from the file's. seed, episode: of the random draws; bias: of the draws of each step.
    actions: of each agent in each step; policies: for each agent a scripted policy, or None: it takes `actions`.
    """

    rows: tuple[str, ...]
    agents: int
    params: tuple[tuple[str, Value], ...]
    seed: int
    bias: tuple[Bias, ...]
    actions: tuple[tuple[int, ...], ...]
    policies: tuple[ir.Policy | None, ...]
    episode: int = 0
    sizes: tuple[tuple[str, Value], ...] = ()


@dataclass
class Trajectory:
    """The states and outcomes of a scenario. `worlds`, `totals`: of the first state and after each step; the other lists: of each step.

    features: see `coverage.py`; start_features: of the phase `start`. left: the real that left float32 in the step after the last state,
      whose actions are the last of `actions`; None if none did. known: values that checks read in the states, by the identity of the check.
    """

    game: ir.Game
    params: Mapping[str, Value]
    worlds: list[World] = field(default_factory=list)
    totals: list[Totals] = field(default_factory=list)
    actions: list[tuple[int, ...]] = field(default_factory=list)
    outcomes: list[Outcome] = field(default_factory=list)
    features: list[frozenset[Feature]] = field(default_factory=list)
    start_features: frozenset[Feature] = frozenset()
    left: LeavesFloat32 | None = None
    known: dict[int, list[tuple[Any, ...]]] = field(default_factory=dict)

    @property
    def is_over(self) -> bool:
        """Whether the episode has ended, or cannot go on."""
        last = self.outcomes[-1:] and (self.outcomes[-1].terminated or self.outcomes[-1].truncated)
        return bool(last) or self.left is not None

    def values(self, check: ir.Check) -> list[tuple[Any, ...]]:
        """Returns the values that a check of the game reads in each state."""
        known = self.known.setdefault(id(check), [])
        for at in range(len(known), len(self.worlds)):
            known.append(tuple(self.value(e, at) for e in check.values))
        return known

    def add(self, world: World, totals: Totals, checks: Sequence[ir.Check]) -> None:
        """Adds a state. Raises LeavesFloat32, and adds nothing, if a check cannot be read in it."""
        read_now = [tuple(self._read(e, world, totals, len(self.worlds)) for e in check.values) for check in checks]
        for check, values in zip(checks, read_now, strict=True):
            self.known.setdefault(id(check), []).append(values)
        self.worlds.append(world)
        self.totals.append(totals)

    def cut(self, steps: int) -> "Trajectory":
        """Returns the trajectory up to the state after so many steps."""
        known = {check: values[: steps + 1] for check, values in self.known.items()}
        actions, outcomes, features = self.actions[:steps], self.outcomes[:steps], self.features[:steps]
        worlds, totals = self.worlds[: steps + 1], self.totals[: steps + 1]
        return Trajectory(self.game, self.params, worlds, totals, actions, outcomes, features, self.start_features, None, known)

    def value(self, e: ir.Expr, at: int) -> Value:
        """Returns the value of an expression of a check in the state `at`."""
        return self._read(e, self.worlds[at], self.totals[at], at)

    def _read(self, e: ir.Expr, world: World, totals: Totals, at: int) -> Value:
        return read(self.game, world, e, totals, (self.worlds[at - 1], self.totals[at - 1]) if at else None)


Driver = Callable[[World, int], Sequence[int] | None]  # (state, number of the step) -> an action for each agent; None to stop


def params_of(game: ir.Game, given: Sequence[tuple[str, Value]]) -> dict[str, Value]:
    """Returns the parameters of a scenario as the interpreter has them. A table by agent that was made for more or fewer agents stays as the file has it."""
    types = {p.name: p.type for p in game.params}
    fitting = [(name, value) for name, value in given if _fits(value, types[name].by)]
    return default_params(game) | {name: real(value) if types[name].kind == "real" else value for name, value in fitting}


def _fits(value: Any, by: Sequence[Level]) -> bool:
    return not by or (len(value) == len(by[0]) and all(_fits(entry, by[1:]) for entry in value))


def draws_of(scenario: Scenario, at: int) -> Draws:
    """Returns the draws of a step (0, 1, …), or of the phase `start` (-1)."""
    key = episode_key(scenario.seed, scenario.episode)
    if at < 0:
        return reset_key(key)
    return BiasedDraws(step_key(key, at), scenario.bias[at]) if scenario.bias else step_key(key, at)


def up_to(scenario: Scenario, steps: int) -> Scenario:
    """Returns a scenario that ends after so many steps."""
    return replace(scenario, actions=scenario.actions[:steps], bias=scenario.bias[:steps])


def play(
    game: ir.Game,
    scenario: Scenario,
    steps: int | None = None,
    checks: Sequence[ir.Check] = (),
    since: Trajectory | None = None,
    driver: Driver | None = None,
) -> Trajectory:
    """Plays a scenario to its end, to that of the episode, or until a real leaves float32.

    Args:
      steps: at most so many, if the policies choose all actions.
      checks: those whose values are read in every state.
      since: the beginning, as it was played before.
      driver: chooses the actions, in place of the scenario.
    """
    params, key = params_of(game, scenario.params), episode_key(scenario.seed, scenario.episode)
    if since is None:
        trajectory = _begin(game, scenario, params, checks)
    else:
        trajectory = since.cut(len(since.outcomes))
    for number in range(len(trajectory.outcomes), len(scenario.actions) if steps is None else steps):
        if trajectory.is_over:
            break
        world = trajectory.worlds[-1]
        actions = _actions(game, scenario, world, number, key) if driver is None else driver(world, number)
        if actions is None:
            break
        trajectory.actions.append(tuple(actions))
        _follow(trajectory, draws_of(scenario, number), checks)
    return trajectory


def _begin(game: ir.Game, scenario: Scenario, params: Mapping[str, Value], checks: Sequence[ir.Check]) -> Trajectory:
    accounts: list[Account] = []
    trajectory = Trajectory(game, params)
    try:
        trajectory.add(reset(game, params, draws_of(scenario, -1), accounts.append), add_totals({}, _nothing(game), game), checks)
    except LeavesFloat32 as left:
        trajectory.left = left
    trajectory.start_features = features_of(accounts)
    return trajectory


def _follow(trajectory: Trajectory, draws: Draws, checks: Sequence[ir.Check]) -> None:
    """Takes the step whose actions are the last ones."""
    accounts: list[Account] = []
    try:
        world, outcome = step(trajectory.game, trajectory.worlds[-1], trajectory.actions[-1], trajectory.params, draws, accounts.append)
        trajectory.add(world, add_totals(trajectory.totals[-1], outcome.events, trajectory.game), checks)
    except LeavesFloat32 as left:
        trajectory.left = left
        return
    trajectory.features.append(features_of(accounts))
    trajectory.outcomes.append(outcome)


def _actions(game: ir.Game, scenario: Scenario, world: World, number: int, key: Threefry) -> tuple[int, ...]:
    bits = policy_bits(key, number, scenario.agents) if any(scenario.policies) else []
    return tuple(
        scenario.actions[number][agent] if policy is None else choose(policy, game, world, agent, bits[agent])
        for agent, policy in enumerate(scenario.policies)
    )


def _nothing(game: ir.Game) -> dict[str, Any]:
    agents = range(game.agents.number)
    zeros = {e.name: [0] * len(e.by) if e.by else 0 for e in game.events}
    return {e.name: [zeros[e.name] for _ in agents] if e.per_agent else zeros[e.name] for e in game.events}
