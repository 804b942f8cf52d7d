"""Trajectories on the interpreter: a scenario (parameters, seed, actions) and every state and outcome it leads to."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from sjdsl.compiler import ir
from sjdsl.interpreter.account import Account
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.numbers import real
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.interpreter.state import Outcome, Value, World, default_params
from sjdsl.interpreter.step import Totals, read, reset, step
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
from sjdsl.properties.monitors import add_totals
from sjdsl.properties.statements import StatementId, statements_run


@dataclass(frozen=True)
class Scenario:
    """Everything that determines a trajectory of a game.

    seed, episode: of the random draws; bias: of the draws of each step, empty: all are fair. params: those that differ from the file's.
    actions: of each agent in each step; policies: one for each agent, who then takes no `actions`.
    """

    seed: int
    episode: int = 0
    params: tuple[tuple[str, Value], ...] = ()
    bias: tuple[Bias, ...] = ()
    actions: tuple[tuple[int, ...], ...] = ()
    policies: tuple[ir.Policy, ...] = ()


@dataclass
class Trajectory:
    """The states and outcomes of a scenario. `worlds`, `totals`: of the first state and after each step; actions, outcomes: of each step.

    ran: the statements that ran in it. left: the real that left float32 in the step after the last state, whose actions are the last of
    `actions`; None if none did. known: values that checks read in the states, by the identity of the check.
    """

    game: ir.Game
    params: Mapping[str, Value]
    worlds: list[World] = field(default_factory=list)
    totals: list[Totals] = field(default_factory=list)
    actions: list[tuple[int, ...]] = field(default_factory=list)
    outcomes: list[Outcome] = field(default_factory=list)
    ran: set[StatementId] = field(default_factory=set)
    left: LeavesFloat32 | None = None
    known: dict[int, list[tuple[Any, ...]]] = field(default_factory=dict)
    # By its number, each state that a trial ended in; in `worlds` stands the first of the next one.
    ends_of_trials: dict[int, World] = field(default_factory=dict)

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
        checked = last_of_trial or world
        read_now = [
            tuple(self._read(e, checked, totals, len(self.worlds)) for e in check.values)
            for check in checks
        ]
        if last_of_trial is not None:
            self.ends_of_trials[len(self.worlds)] = last_of_trial
        for check, values in zip(checks, read_now, strict=True):
            self.known.setdefault(id(check), []).append(values)
        self.worlds.append(world)
        self.totals.append(totals)

    def take_over(self, begun: "Trajectory", steps: int, checks: Sequence[ir.Check]) -> None:
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
        return read(
            self.game, world, e, totals, (self.worlds[at - 1], self.totals[at - 1]) if at else None
        )


def params_of(game: ir.Game, given: Sequence[tuple[str, Value]]) -> dict[str, Value]:
    """Returns the parameters of a scenario as the interpreter has them."""
    types = {p.name: p.type for p in game.params}
    return default_params(game) | {
        name: real(value) if types[name].kind == "real" else value for name, value in given
    }


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
    key = step_key(episode_key(scenario.seed, scenario.episode), number)
    return BiasedDraws(key, scenario.bias[at]) if scenario.bias else key


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
      begun: a trajectory with the same parameters and draws, whose first `since` steps are taken over; `ran` leaves them out.
    """
    trajectory, accounts = Trajectory(game, params_of(game, scenario.params)), list[Account]()
    try:
        if begun is None:
            zeros = add_totals({}, _nothing(game), game)
            trajectory.add(
                reset(game, trajectory.params, draws_of_start(scenario), accounts.append),
                zeros,
                checks,
            )
        else:
            trajectory.take_over(begun, since, checks)
        for number in range(
            len(trajectory.outcomes), len(scenario.actions) if steps is None else steps
        ):
            if trajectory.is_over or is_enough(trajectory.ran):
                break
            world = trajectory.worlds[-1]
            trajectory.actions.append(_actions(game, scenario, world, number))
            after, outcome = step(
                game,
                world,
                trajectory.actions[-1],
                trajectory.params,
                draws_of(scenario, number, game, world),
                accounts.append,
            )
            totals = add_totals(trajectory.totals[-1], outcome.events, game)
            trajectory.add(after, totals, checks, outcome.last_of_trial)
            trajectory.outcomes.append(outcome)
            trajectory.ran |= statements_run(accounts)
            accounts.clear()
    except LeavesFloat32 as left:
        trajectory.left = left
    trajectory.ran |= statements_run(accounts)
    return trajectory


def allowed_by(policy: ir.Policy, game: ir.Game) -> tuple[int, ...]:
    """Returns the actions among which `random` and `never` choose, all equally likely; `stay` if none is left."""
    left = tuple(a for a in range(len(game.agents.actions)) if a not in policy.actions)
    return left or (game.agents.actions.index("stay"),)


def script_of(policy: ir.Policy, game: ir.Game) -> ir.ScriptedPolicy | None:
    """Returns the rules that an agent with this policy follows: those in the file, or the one of `seek D`; None if it acts at random."""
    if policy.domain is not None:
        return ir.ScriptedPolicy(name="seek", rules=(ir.Go(domain=policy.domain),))
    return next((script for script in game.policies if script.name == policy.scripted), None)


def choose(
    policy: ir.Policy, game: ir.Game, world: World, agent: int, bits: tuple[int, int]
) -> int:
    """Returns what an agent with this policy does in a state."""
    script = script_of(policy, game)
    if script is not None:
        return interpreted.choose(script, game, world, agent, bits)
    actions = allowed_by(policy, game)
    return actions[bits[0] * len(actions) >> 32]


def _actions(game: ir.Game, scenario: Scenario, world: World, number: int) -> tuple[int, ...]:
    if not scenario.policies:
        return scenario.actions[number]
    bits = policy_bits(episode_key(scenario.seed, scenario.episode), number, game.agents.number)
    return tuple(
        choose(policy, game, world, agent, bits[agent])
        for agent, policy in enumerate(scenario.policies)
    )


def _nothing(game: ir.Game) -> dict[str, Any]:
    agents = range(game.agents.number)
    zeros = {e.name: [0] * len(e.by) if e.by else 0 for e in game.events}
    return {
        e.name: [zeros[e.name] for _ in agents] if e.per_agent else zeros[e.name]
        for e in game.events
    }
