"""Prints a counterexample to a check.

It says what the agents do, tells the step that violates the check as a trace does, and gives the
values that the check reads.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import contains, is_any_or_all
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.state import Value, World
from sjdsl.properties.engines import Episode, EpisodeRunner
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.monitors import Violation
from sjdsl.properties.search import Counterexample
from sjdsl.properties.trajectory import Trajectory, draws_of, params_of
from sjdsl.render.letters import draw
from sjdsl.trace.episode import Moment, take_step
from sjdsl.trace.lines import make_teller, moment_lines
from sjdsl.trace.rules import Rules
from sjdsl.trace.wording import say_value

MOST = 3  # like changes that are told of a counterexample
SAME = 5  # steps with the same actions that have a line each
IN_FULL = "every change of this step: `sjdsl test --full`"
LARGEST = "3.4e38"  # of float32: (2 - 2^-23) * 2^127


def describe_counterexample(
    family: GameFamily, counterexample: Counterexample, full: bool = False
) -> list[str]:
    """Returns the lines of a counterexample.

    What all agents do in each step, the last step rule by rule, and what the check reads.

    Args:
      full: tells every change of the last step, not only a few of those that are alike.
    """
    trajectory = counterexample.trajectory
    scenario = counterexample.scenario
    where = counterexample.where
    game = trajectory.game
    lines = []
    if scenario.params:
        values = {param.name: param.value for param in family.own.params}
        changes = [
            f"{name} = {value_text(value)} (the file: {value_text(values[name])})"
            for name, value in scenario.params
        ]
        lines.append(f"with {', '.join(changes)}")
    last = max(0, where.at - 1)
    steps = [actions_line(game, t, trajectory.actions[t]) for t in range(last)]
    if trajectory.overflow is not None and where.at == len(trajectory.worlds):
        return lines + steps + describe_overflow(family, trajectory)
    lines += steps if full else _shortened(game, trajectory.actions[:last])
    before = trajectory.worlds[last]
    draws = draws_of(scenario, last, game, before)
    moment = take_step(game, before, trajectory.params, draws, trajectory.actions[last])
    lines += _step_lines(family, moment, before, full)
    return lines + _value_lines(family, game.checks[counterexample.number], trajectory, where)


def _value_lines(
    family: GameFamily, check: ir.Check, trajectory: Trajectory, where: Violation
) -> list[str]:
    """Returns what the parts of a check are in the state that violates it and in an earlier one."""
    since = where.since if where.since is not None and check.kind != "once" else where.at - 1
    states = [t for t in (since, where.at) if t >= 0]
    lines = []
    for e in _compared_parts(check):
        read_in = states[-1:] if contains(e, ir.Before) else states
        values = [f"{value_text(trajectory.value(e, t))} {when(t)}" for t in read_in]
        lines.append(f"{family.text_of(e)} = {', '.join(values)}")
    return list(dict.fromkeys(lines))


def describe_episode(
    family: GameFamily,
    runner: EpisodeRunner,
    episode: Episode,
    policies: Sequence[ir.Policy],
    number: int,
    where: Violation,
    full: bool = False,
) -> list[str]:
    """Returns the totals of an episode that violates an `expect`, and the step that violates it.

    Args:
      number: of the check.
      full: tells every change of that step.
    """
    lines = [episode_opening(family, episode, policies)]
    totals = []
    for (name, word), count in episode.totals.items():
        totals.append(f"{name}[{word}] {count}" if word else f"{name} {count}")
    if totals:
        lines.append(f"at its end, after {len(episode.actions)} steps: {', '.join(totals)}")
    values = episode.values[number]
    if where.at < 1 or not any(holds for (holds,) in values):
        return lines  # no single step violates it
    last = where.at - 1
    game = family.own
    before = runner.world_before(episode, last)
    draws = draws_of(runner.written_out(episode, where.at), last, game, before)
    moment = take_step(game, before, params_of(game, ()), draws, episode.actions[last])
    lines += _step_lines(family, moment, before, full)
    (e,) = game.checks[number].values
    texts = [f"{value_text(values[t][0])} {when(t)}" for t in (last, where.at)]
    return [*lines, f"{family.text_of(e)}: {', '.join(texts)}"]


def episode_opening(family: GameFamily, episode: Episode, policies: Sequence[ir.Policy]) -> str:
    """Returns which episode it is, and the policies as they are written."""
    names = dict.fromkeys(family.text_of(p) if p.origin is not None else p.name for p in policies)
    return f"episode {episode.number}, with {', '.join(names)}"


def _step_lines(family: GameFamily, moment: Moment, before: World, full: bool) -> Iterator[str]:
    """Yields the map before a step with its legend, and the step as `sjdsl trace` prints it.

    Args:
      full: tells every change, not only a few of those that are alike.
    """
    teller = make_teller(board_of(family.own), Rules(family.composition.sources))
    rows = draw(teller.looks, teller.board, before)
    rows_after = draw(teller.looks, teller.board, moment.world)
    on_map = {glyph for row in (*rows, *rows_after) for glyph in row.split("  ")[0]}
    yield "    ".join(entry for entry in teller.looks.legend() if entry[0] in on_map)
    yield from (f"    {row}" for row in rows)
    lines = list(filter(None, moment_lines(moment, teller)))
    brief = list(filter(None, moment_lines(moment, replace(teller, most=MOST))))
    yield from lines if full else brief
    if not full and lines != brief:
        yield IN_FULL


def _shortened(game: ir.Game, actions: Sequence[Sequence[int]]) -> Iterator[str]:
    """Yields what the agents do in steps 0, 1, …; many alike steps have one line."""
    first = 0
    for chosen, steps in groupby(actions):
        after = first + len(list(steps))
        if after - first > SAME:
            line = actions_line(game, first, chosen)
            yield line.replace(f"step {first}", f"steps {first} to {after - 1}", 1)
        else:
            yield from (actions_line(game, t, chosen) for t in range(first, after))
        first = after


def actions_line(game: ir.Game, number: int, actions: Sequence[int]) -> str:
    """Returns what the agents do in a step, in words, without those that stay."""
    names = game.agents.actions
    active = [
        f"{agent} {names[action]}"
        for agent, action in enumerate(actions)
        if names[action] != "stay"
    ]
    if not active:
        return f"step {number}: all stay"
    rest = ", the others stay" if len(active) < len(actions) else ""
    return f"step {number}: {', '.join(active)}{rest}"


def when(at: int) -> str:
    """Returns the time of the state `at` in words; steps are numbered as `step` is."""
    return f"after step {at - 1}" if at else "at the start"


def _compared_parts(check: ir.Check) -> list[ir.Expr]:
    """Returns the sides of comparisons in a check that depend on the state.

    An expression of the check that compares nothing so stands for itself.
    """
    parts: list[ir.Expr] = []
    for value in check.values:
        sides: list[ir.Expr] = []
        for node in _conditions_in(value):
            if isinstance(node, ir.Compare) and not is_any_or_all(node):
                sides += [node.left, node.right]
        sides = [side for side in sides if not isinstance(side, ir.Number | ir.ParamRef)]
        parts += sides or [value]
    return parts


def _conditions_in(e: ir.Node) -> Iterator[ir.Node]:
    """Yields the conditions that a condition is made of, except those inside counts."""
    yield e
    if isinstance(e, ir.Logic | ir.Not | ir.Named):
        for child in ir.children(e):
            yield from _conditions_in(child)


def value_text(value: Value) -> str:
    """Returns a value in words, a table in braces."""
    if isinstance(value, tuple):
        return f"{{ {', '.join(map(value_text, value))} }}"
    return say_value(value)


def describe_overflow(family: GameFamily, trajectory: Trajectory) -> list[str]:
    """Returns the lines of a real that leaves float32 in the last step of a trajectory.

    What the agents do in that step, the statement, and the largest reals before it.
    """
    assert trajectory.overflow is not None
    rules = Rules(family.composition.sources)
    node = trajectory.overflow.node
    statement = f"{rules.place(node)}  {rules.text(node)}"
    if not trajectory.worlds:
        return [f"in phase start: {statement}"]
    world = trajectory.worlds[-1]
    lines = []
    if len(trajectory.actions) > len(trajectory.outcomes):
        lines.append(actions_line(trajectory.game, world.step, trajectory.actions[-1]))
    lines.append(
        f"  {statement}: the result is larger than the largest float32, {LARGEST}, or no number"
    )
    return [*lines, *_largest_reals(world)]


def _largest_reals(world: World) -> Iterator[str]:
    """Yields a line for each field of reals, with its largest value."""
    fields = [(f"agent.{name}", values) for name, values in world.agents.items()]
    fields += [(f"{kind}.{name}", values) for (kind, name), values in world.cells.items()]
    fields += [(name, [value]) for name, value in world.fields.items()]
    for name, values in fields:
        reals = [entry for value in values for entry in _entries(value)]
        if reals and isinstance(reals[0], np.floating):
            yield f"  {name} before this step: up to {max(reals, key=abs):.6g}"


def _entries(value: Value) -> Iterator[Value]:
    """Yields the entries of a table of any depth; a single value is its only entry."""
    if isinstance(value, tuple):
        for entry in value:
            yield from _entries(entry)
    else:
        yield value
