"""Prints a counterexample to a check: what the agents do, the step that violates it as a trace tells it, and the values that the check reads."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import contains, is_quantified
from sjdsl.interpreter.account import Account
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.state import Value, World
from sjdsl.interpreter.step import action_mask, step
from sjdsl.interpreter.threefry import Draws
from sjdsl.properties.engines import Episode, EpisodeRunner
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.monitors import Violation
from sjdsl.properties.search import Counterexample
from sjdsl.properties.trajectory import Trajectory, draws_of, params_of
from sjdsl.render.letters import draw
from sjdsl.trace.episode import Moment, Turn, trial_of, turn_of
from sjdsl.trace.jax_random import RecordedDraws
from sjdsl.trace.lines import make_teller, moment_lines
from sjdsl.trace.rules import Rules
from sjdsl.trace.wording import say_value

MOST = 3  # of alike changes told in a counterexample
SAME = 5  # steps with the same actions that have a line each
IN_FULL = "every change of this step: `sjdsl test --full`"
LARGEST = "3.4e38"  # of float32: (2 - 2^-23) * 2^127


def describe_counterexample(
    family: GameFamily, counterexample: Counterexample, full: bool = False
) -> list[str]:
    """Returns the text of a counterexample: what all agents do in each step, the last step rule by rule, and what the check reads.

    full: tells every change of the last step, not only a few of those that are alike.
    """
    trajectory, scenario, at = (
        counterexample.trajectory,
        counterexample.scenario,
        counterexample.where.at,
    )
    game, own = trajectory.game, {p.name: p.value for p in family.own.params}
    different = [
        f"{name} = {shown(value)} (the file: {shown(own[name])})" for name, value in scenario.params
    ]
    lines = [f"with {', '.join(different)}"] if different else []
    last, leaves = max(0, at - 1), trajectory.left is not None and at == len(trajectory.worlds)
    steps = [acting(game, t, trajectory.actions[t]) for t in range(last)]
    if leaves:
        return lines + steps + describe_overflow(family, trajectory)
    lines += steps if full else _shortened(game, trajectory.actions[:last])
    lines += _step(
        family,
        take_step(
            game,
            trajectory.worlds[last],
            trajectory.actions[last],
            trajectory.params,
            draws_of(scenario, last, game, trajectory.worlds[last]),
        ),
        trajectory.worlds[last],
        full,
    )
    where, check = counterexample.where, game.checks[counterexample.number]
    since = where.since if where.since is not None and check.sort != "once" else at - 1
    states, told = [t for t in (since, at) if t >= 0], list[str]()
    for e in _told_of(check):
        values = [
            f"{shown(trajectory.value(e, t))} {when(t)}"
            for t in (states[-1:] if contains(e, ir.Before) else states)
        ]
        told.append(f"{family.text_of(e)} = {', '.join(values)}")
    return lines + list(dict.fromkeys(told))


def describe_episode(
    family: GameFamily,
    runner: EpisodeRunner,
    episode: Episode,
    policies: Sequence[ir.Policy],
    number: int,
    where: Violation,
    full: bool = False,
) -> list[str]:
    """Returns the totals of an episode, and the step with the violation with what the check reads. full: with every change of that step."""
    totals = ", ".join(
        f"{name}{f'[{word}]' if word else ''} {count}"
        for (name, word), count in episode.totals.items()
    )
    lines = [episode_opening(family, episode, policies)]
    lines += [f"at its end, after {len(episode.actions)} steps: {totals}"] if totals else []
    values = episode.values[number]
    if where.at < 1 or not any(holds for (holds,) in values):
        return lines  # no single step violates it
    world = runner.world_before(episode, where.at - 1)
    scenario = runner.written_out(episode, where.at)
    draws = draws_of(scenario, where.at - 1, family.own, world)
    lines += _step(
        family,
        take_step(
            family.own, world, episode.actions[where.at - 1], params_of(family.own, ()), draws
        ),
        world,
        full,
    )
    (e,), (before,), (after,) = (
        family.own.checks[number].values,
        values[where.at - 1],
        values[where.at],
    )
    return [
        *lines,
        f"{family.text_of(e)}: {shown(before)} {when(where.at - 1)}, {shown(after)} {when(where.at)}",
    ]


def episode_opening(family: GameFamily, episode: Episode, policies: Sequence[ir.Policy]) -> str:
    """Returns which episode it is, and the policies as they are written."""
    names = dict.fromkeys(family.text_of(p) if p.origin is not None else p.name for p in policies)
    return f"episode {episode.number}, with {', '.join(names)}"


def _step(family: GameFamily, moment: Moment, before: World, full: bool) -> Iterator[str]:
    """Yields the map before a step with its legend, and the step as `sjdsl trace` prints it, unless `full` a few of alike changes only."""
    teller = make_teller(board_of(family.own), Rules(family.composition.sources))
    rows, after = (
        draw(teller.looks, teller.board, before),
        draw(teller.looks, teller.board, moment.world),
    )
    here = {glyph for row in (*rows, *after) for glyph in row.split("  ")[0]}
    yield "    ".join(said for said in teller.looks.legend() if said[0] in here)
    yield from (f"    {row}" for row in rows)
    lines = list(filter(None, moment_lines(moment, teller)))
    brief = list(filter(None, moment_lines(moment, replace(teller, most=MOST))))
    yield from lines if full else brief
    if not full and lines != brief:
        yield IN_FULL


def _shortened(game: ir.Game, actions: Sequence[Sequence[int]]) -> Iterator[str]:
    """Yields what the agents do in the steps from the first on, one line for many steps in which they do the same."""
    first = 0
    for chosen, alike in groupby(actions):
        after = first + len(list(alike))
        if after - first > SAME:
            yield acting(game, first, chosen).replace(
                f"step {first}", f"steps {first} to {after - 1}", 1
            )
        else:
            yield from (acting(game, t, chosen) for t in range(first, after))
        first = after


def acting(game: ir.Game, number: int, actions: Sequence[int]) -> str:
    """Returns what the agents do in a step, in words, without those that stay."""
    names = game.agents.actions
    said = [
        f"{agent} {names[action]}"
        for agent, action in enumerate(actions)
        if names[action] != "stay"
    ]
    return f"step {number}: {', '.join(said) or 'all stay'}" + (
        ", the others stay" if said and len(said) < len(actions) else ""
    )


def take_step(
    game: ir.Game, world: World, actions: Sequence[int], params: Mapping[str, Value], draws: Draws
) -> Moment:
    """Takes a step and returns everything that a trace tells of it."""
    board, recorded = board_of(game), RecordedDraws(draws)
    told: list[Turn] = []

    def tell(account: Account) -> None:
        told.append(turn_of(account, board, recorded.numbers))
        recorded.numbers.clear()

    allowed = action_mask(game, world)
    forbidden = frozenset(
        agent for agent, action in enumerate(actions) if not allowed[agent][action]
    )
    after, outcome = step(game, world, actions, params, recorded, tell)
    turns = tuple(told)
    trial = trial_of(game, world)
    return Moment(world.step, (0, 0), after, turns, tuple(actions), forbidden, outcome, trial)


def when(at: int) -> str:
    """Returns the time of the state `at` in words; steps are numbered as `step` is."""
    return f"after step {at - 1}" if at else "at the start"


def _told_of(check: ir.Check) -> list[ir.Expr]:
    """Returns the sides of comparisons in a check that depend on the state, or its whole expressions if it compares nothing."""
    found: list[ir.Expr] = []
    for value in check.values:
        compared = [n for n in _open(value) if isinstance(n, ir.Compare) and not is_quantified(n)]
        sides = [side for n in compared for side in (n.left, n.right)]
        found += [side for side in sides if not isinstance(side, ir.Number | ir.ParamRef)] or [
            value
        ]
    return found


def _open(e: ir.Node) -> Iterator[ir.Node]:
    """Yields the conditions that a condition is made of, except those inside counts."""
    yield e
    if isinstance(e, ir.Logic | ir.Not | ir.Named):
        for child in ir.children(e):
            yield from _open(child)


def shown(value: Value) -> str:
    """Returns a value in words, a table in braces."""
    return (
        "{ " + ", ".join(map(shown, value)) + " }" if isinstance(value, tuple) else say_value(value)
    )


def describe_overflow(family: GameFamily, trajectory: Trajectory) -> list[str]:
    """Returns what the agents do in the last step of a trajectory, the statement, and the largest reals before it."""
    assert trajectory.left is not None
    rules, node = Rules(family.composition.sources), trajectory.left.node
    said = f"{rules.place(node)}  {rules.text(node)}"
    if not trajectory.worlds:
        return [f"in phase start: {said}"]
    world = trajectory.worlds[-1]
    told = (
        [acting(trajectory.game, world.step, trajectory.actions[-1])]
        if len(trajectory.actions) > len(trajectory.outcomes)
        else []
    )
    return [
        *told,
        f"  {said}: the result is larger than the largest float32, {LARGEST}, or no number",
        *_reals(world),
    ]


def _reals(world: World) -> Iterator[str]:
    """Yields the largest value of each field of reals."""
    fields = [(f"agent.{name}", values) for name, values in world.agents.items()]
    fields += [(f"{kind}.{name}", values) for (kind, name), values in world.cells.items()]
    fields += [(name, [value]) for name, value in world.fields.items()]
    for name, values in fields:
        reals = [x for value in values for x in _flat(value)]
        if reals and isinstance(reals[0], np.floating):
            yield f"  {name} before this step: up to {max(reals, key=abs):.6g}"


def _flat(value: Value) -> Iterator[Value]:
    if isinstance(value, tuple):
        for entry in value:
            yield from _flat(entry)
    else:
        yield value
