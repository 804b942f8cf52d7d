"""Plays scenarios (parameters, seed, actions) on the interpreter, and keeps all states."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import counts_of
from sjdsl.interpreter.account import Account
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.numbers import real
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.interpreter.state import Outcome, Value, World, default_params
from sjdsl.interpreter.step import Totals, reset, step
from sjdsl.interpreter.step import read as read_check
from sjdsl.interpreter.threefry import Draws
from sjdsl.policies import interpreted
from sjdsl.properties.biased_draws import (
    Bias,
    BiasedDraws,
    episode_key,
    policy_bits,
    reset_key,
    step_key,
)
from sjdsl.properties.monitors import Total, add_totals
from sjdsl.properties.statements import StatementId, statements_run


@dataclass(frozen=True)
class Scenario:
    """Everything that determines a trajectory of a game.

    seed, episode: of the random draws; bias: of the draws of each step, all fair if empty.
    params: those that differ from the file's.
    actions: of each agent in each step; policies: one for each agent, in place of actions.
    """

    seed: int
    episode: int = 0
    params: tuple[tuple[str, Value], ...] = ()
    bias: tuple[Bias, ...] = ()
    actions: tuple[tuple[int, ...], ...] = ()
    policies: tuple[ir.Policy, ...] = ()


@dataclass
class Trajectory:
    """The states and outcomes of a scenario.

    worlds, totals: of the first state and after each step; actions, outcomes: of each step.
    ran: the statements that ran in it.
    overflow: the real that left float32 in the step after the last state, None if none did. The
    actions of that step are the last ones.
    known: identity of a check -> the values that it reads in each state, as far as they are known.
    """

    game: ir.Game
    params: Mapping[str, Value]
    worlds: list[World] = field(default_factory=list)
    totals: list[Totals] = field(default_factory=list)
    actions: list[tuple[int, ...]] = field(default_factory=list)
    outcomes: list[Outcome] = field(default_factory=list)
    ran: set[StatementId] = field(default_factory=set)
    overflow: LeavesFloat32 | None = None
    known: dict[int, list[tuple[Any, ...]]] = field(default_factory=dict)
    # By its number, each state that a trial ended in; in `worlds` stands the first of the next one.
    ends_of_trials: dict[int, World] = field(default_factory=dict)

    @property
    def is_over(self) -> bool:
        """Whether the episode has ended, or cannot go on."""
        if self.overflow is not None:
            return True
        return bool(self.outcomes) and (self.outcomes[-1].terminated or self.outcomes[-1].truncated)

    def values(self, check: ir.Check) -> list[tuple[Any, ...]]:
        """Returns the values that a check of the game reads in each state."""
        known = self.known.setdefault(id(check), [])
        for at in range(len(known), len(self.worlds)):
            known.append(tuple(self.value(e, at) for e in check.values))
        return known

    def add(
        self,
        world: World,
        totals: Totals,
        checks: Sequence[ir.Check],
        last_of_trial: World | None = None,
    ) -> None:
        """Adds a state, and the last one of the trial before if it begins another trial.

        Raises LeavesFloat32, and adds nothing, if a check cannot be read in it.
        """
        at = len(self.worlds)
        checked = last_of_trial or world
        read = [tuple(self._read(e, checked, totals, at) for e in check.values) for check in checks]
        if last_of_trial is not None:
            self.ends_of_trials[at] = last_of_trial
        for check, values in zip(checks, read, strict=True):
            self.known.setdefault(id(check), []).append(values)
        self.worlds.append(world)
        self.totals.append(totals)

    def copy_steps(self, begun: "Trajectory", steps: int, checks: Sequence[ir.Check]) -> None:
        """Adds the first state of another trajectory and so many of its steps."""
        self.worlds += begun.worlds[: steps + 1]
        self.totals += begun.totals[: steps + 1]
        self.actions += begun.actions[:steps]
        self.outcomes += begun.outcomes[:steps]
        for at, world in begun.ends_of_trials.items():
            if at <= steps:
                self.ends_of_trials[at] = world
        for check in checks:
            self.known[id(check)] = begun.values(check)[: steps + 1]

    def value(self, e: ir.Expr, at: int) -> Value:
        """Returns the value of an expression of a check in the state `at`.

        After the last step of a trial it is read before the next trial begins.
        """
        checked = self.ends_of_trials.get(at, self.worlds[at])
        return self._read(e, checked, self.totals[at], at)

    def _read(self, e: ir.Expr, world: World, totals: Totals, at: int) -> Value:
        """Returns the value of an expression of a check in a state that may not be added yet."""
        before = (self.worlds[at - 1], self.totals[at - 1]) if at else None
        return read_check(self.game, world, e, totals, before)


def params_of(game: ir.Game, changed: Sequence[tuple[str, Value]]) -> dict[str, Value]:
    """Returns all parameters as the interpreter has them. changed: those unlike the file's."""
    types = {p.name: p.type for p in game.params}
    params = default_params(game)
    for name, value in changed:
        params[name] = real(value) if types[name].kind == "real" else value
    return params


def draws_of_start(scenario: Scenario) -> Draws:
    """Returns the draws of the phase `start`."""
    return reset_key(episode_key(scenario.seed, scenario.episode))


def draws_of(scenario: Scenario, at: int, game: ir.Game, world: World) -> Draws:
    """Returns the draws of a step of an episode (0, 1, …), which begins in a state.

    Their key has the number of the step; after a trial that `end` ended early, as if that had had
    its full length.
    """
    number = world.step
    if game.trials is not None:
        length = evaluate(game.episode, Instance(board_of(game), world))
        number += world.fields["trial"] * length
    draws = step_key(episode_key(scenario.seed, scenario.episode), number)
    return BiasedDraws(draws, scenario.bias[at]) if scenario.bias else draws


def up_to(scenario: Scenario, steps: int) -> Scenario:
    """Returns a scenario that ends after so many steps."""
    return replace(scenario, actions=scenario.actions[:steps], bias=scenario.bias[:steps])


def play(
    game: ir.Game,
    scenario: Scenario,
    steps: int | None = None,
    checks: Sequence[ir.Check] = (),
    is_enough: Callable[[set[StatementId]], bool] = lambda _: False,
    begun: Trajectory | None = None,
    since: int = 0,
) -> Trajectory:
    """Plays a scenario to its end, to that of the episode, or until a real leaves float32.

    Args:
      steps: at most so many; None: as many as the scenario has actions.
      checks: those whose values are read in every state.
      is_enough: whether to stop before the next step, as these statements have run.
      begun: a trajectory with the same parameters and draws, whose first `since` steps are copied;
        `ran` leaves them out.
    """
    params = params_of(game, scenario.params)
    trajectory = Trajectory(game, params)
    accounts: list[Account] = []
    try:
        if begun is None:
            world = reset(game, params, draws_of_start(scenario), accounts.append)
            trajectory.add(world, _no_totals(game), checks)
        else:
            trajectory.copy_steps(begun, since, checks)
        end = len(scenario.actions) if steps is None else steps
        for number in range(len(trajectory.outcomes), end):
            if trajectory.is_over or is_enough(trajectory.ran):
                break
            before = trajectory.worlds[-1]
            actions = _actions(game, scenario, before, number)
            trajectory.actions.append(actions)
            draws = draws_of(scenario, number, game, before)
            world, outcome = step(game, before, actions, params, draws, accounts.append)
            totals = add_totals(trajectory.totals[-1], outcome.events, game)
            trajectory.add(world, totals, checks, outcome.last_of_trial)
            trajectory.outcomes.append(outcome)
            trajectory.ran |= statements_run(accounts)
            accounts.clear()
    except LeavesFloat32 as overflow:
        trajectory.overflow = overflow
    trajectory.ran |= statements_run(accounts)
    return trajectory


def allowed_by(policy: ir.Policy, game: ir.Game) -> tuple[int, ...]:
    """Returns the actions among which `random` and `never` choose, all equally likely.

    `stay` if none is left.
    """
    names = game.agents.actions
    allowed = tuple(action for action in range(len(names)) if action not in policy.actions)
    return allowed or (names.index("stay"),)


def script_of(policy: ir.Policy, game: ir.Game) -> ir.ScriptedPolicy | None:
    """Returns the rules that an agent with this policy follows; None if it acts at random.

    They are written in the file, or `seek D` stands for one.
    """
    if policy.domain is not None:
        return ir.ScriptedPolicy(name="seek", rules=(ir.Go(domain=policy.domain),))
    return next((script for script in game.policies if script.name == policy.scripted), None)


def choose(
    policy: ir.Policy, game: ir.Game, world: World, agent: int, bits: tuple[int, int]
) -> int:
    """Returns the number of the action that an agent with this policy takes in a state.

    Args:
      bits: two random numbers of 32 bits. Of A allowed actions, `random` and `never` take number
        floor(bits[0] * A / 2^32).
    """
    script = script_of(policy, game)
    if script is not None:
        return interpreted.choose(script, game, world, agent, bits)
    actions = allowed_by(policy, game)
    place = (bits[0] * len(actions)) >> 32
    return actions[place]


def _actions(game: ir.Game, scenario: Scenario, world: World, number: int) -> tuple[int, ...]:
    """Returns the actions of a step: those of the scenario, or of its policies."""
    if not scenario.policies:
        return scenario.actions[number]
    bits = policy_bits(episode_key(scenario.seed, scenario.episode), number, game.agents.number)
    return tuple(
        choose(policy, game, world, agent, bits[agent])
        for agent, policy in enumerate(scenario.policies)
    )


def _no_totals(game: ir.Game) -> dict[Total, int]:
    """Returns the totals at the start of an episode: all 0."""
    return {(event.name, word): 0 for event in game.events for word, _ in counts_of(event)}
