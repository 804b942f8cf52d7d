"""Prints a counterexample to a check: the map, the actions, what each rule changes, and with which random draw."""

import re
from collections.abc import Iterator, Mapping, Sequence

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import contains
from sjdsl.interpreter.account import Account
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.state import Value, World
from sjdsl.interpreter.step import action_mask, step
from sjdsl.interpreter.threefry import Draws
from sjdsl.properties.float_overflow import describe_overflow
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.search import Counterexample
from sjdsl.properties.trajectory import Scenario, Trajectory, draws_of
from sjdsl.render.letters import draw
from sjdsl.trace.episode import Moment, Told, tell_of
from sjdsl.trace.jax_random import RecordedDraws
from sjdsl.trace.lines import make_teller, moment_lines
from sjdsl.trace.rules import Rules
from sjdsl.trace.wording import say_value

_BITS = re.compile(r"  \(random bits [0-9a-f]{8}: number \d+ of stream [0-9a-f]{8}\)")


def describe_counterexample(family: GameFamily, counterexample: Counterexample) -> list[str]:
    """Returns the text of a whole counterexample."""
    trajectory, scenario = counterexample.trajectory, counterexample.scenario
    lines = [opening(family, scenario), *legend(family, trajectory.game, trajectory.worlds[0])]
    leaves = trajectory.left is not None and counterexample.where.at == len(trajectory.worlds)
    for t in range(counterexample.where.at - 1 if leaves else max(1, counterexample.where.at)):
        lines += describe_step(
            family, trajectory.game, trajectory.worlds[t], trajectory.actions[t], trajectory.params, draws_of(scenario, t)
        )
    if leaves:
        return lines + describe_overflow(family, trajectory)
    return lines + said_of_values(family, counterexample)


def opening(family: GameFamily, scenario: Scenario) -> str:
    """Returns in words where a counterexample is played: how many agents on which map, and the parameters that differ."""
    numbers = "".join(
        f", {name} = {shown(value)} (the file: {shown(_own(family.own, name))})" for name, value in (*scenario.params, *scenario.sizes)
    )
    where = "the game's own map" if family.is_own(scenario.rows) else "a small map"
    return f"{scenario.agents} agent{'s' * (scenario.agents != 1)} on {where}{numbers}"


def legend(family: GameFamily, game: ir.Game, world: World) -> Iterator[str]:
    """Yields the legend of a map, and the map."""
    teller = make_teller(board_of(game), Rules(family.composition.sources))
    here = {glyph for row in draw(teller.looks, teller.board, world) for glyph in row.split("  ")[0]}
    yield "    ".join(said for said in teller.looks.legend() if said[0] in here or said[0] in "".join(game.rows))
    yield from (f"    {row}" for row in draw(teller.looks, teller.board, world))


def describe_step(
    family: GameFamily, game: ir.Game, world: World, actions: Sequence[int], params: Mapping[str, Value], draws: Draws
) -> list[str]:
    """Returns the text of one step, rule by rule, and the map after it."""
    moment = take_step(game, world, actions, params, draws)
    return [in_short(line) for line in moment_lines(moment, make_teller(board_of(game), Rules(family.composition.sources))) if line]


def in_short(line: str) -> str:
    """Returns a line of a trace without the source of its random number."""
    return _BITS.sub("", line)


def take_step(game: ir.Game, world: World, actions: Sequence[int], params: Mapping[str, Value], draws: Draws) -> Moment:
    """Takes a step and returns everything that a trace tells of it."""
    board, recorded = board_of(game), RecordedDraws(draws)
    told: list[Told] = []

    def tell(account: Account) -> None:
        told.append(tell_of(account, board, recorded.numbers))
        recorded.numbers.clear()

    allowed = action_mask(game, world)
    forbidden = frozenset(agent for agent, action in enumerate(actions) if not allowed[agent][action])
    after, outcome = step(game, world, actions, params, recorded, tell)
    return Moment(world.step, (0, 0), after, tuple(told), tuple(actions), forbidden, outcome)


def said_of_values(family: GameFamily, counterexample: Counterexample) -> list[str]:
    """Returns the values that the check reads, before the violation and after it."""
    trajectory, where, check = counterexample.trajectory, counterexample.where, counterexample.trajectory.game.checks[counterexample.number]
    if check.sort == "symmetric":
        return []
    since = where.since if where.since is not None and check.sort != "once" else where.at - 1
    return values_lines(family, check, trajectory, [t for t in (since, where.at) if t >= 0])


def values_lines(family: GameFamily, check: ir.Check, trajectory: Trajectory, states: Sequence[int]) -> list[str]:
    """Returns `apples = 0 at the start, 1 after step 2` for each value that a check reads, and one state for `before(apples)`."""
    lines = []
    for e in _told_of(check):
        told = states[-1:] if contains(e, ir.Before) else states
        values = ", ".join(f"{shown(trajectory.value(e, t))} {when(t)}" for t in told)
        lines.append(f"{family.text_of(e)} = {values}")
    return list(dict.fromkeys(lines))


def when(at: int) -> str:
    """Returns the time of the state `at` in words; steps are numbered as `step` is."""
    return f"after step {at - 1}" if at else "at the start"


def describe_asymmetry(differing: tuple[str, list[str]] | None) -> list[str]:
    """Returns how the last step differs under the renumbered or mirrored rules."""
    assert differing is not None
    said, found = differing
    return [f"{said}, this step would give something else:", *(f"  {line} instead" for line in found)]


def _told_of(check: ir.Check) -> list[ir.Expr]:
    """Returns the sides of comparisons in a check that depend on the state, or its whole expressions if it compares nothing."""
    found: list[ir.Expr] = []
    for value in check.values:
        compared = [n for n in _open(value) if isinstance(n, ir.Compare) and n.left.origin != n.origin]  # not `any(D)`, which counts
        sides = [side for n in compared for side in (n.left, n.right)]
        found += [side for side in sides if not isinstance(side, ir.Number | ir.ParamRef)] or [value]
    return found


def _open(e: ir.Node) -> Iterator[ir.Node]:
    """Yields the conditions that a condition is made of, except those inside counts."""
    yield e
    if isinstance(e, ir.Logic | ir.Not | ir.Named):
        for child in ir.children(e):
            yield from _open(child)


def _own(game: ir.Game, name: str) -> Value:
    values = {param.name: param.value for param in game.params} | {size.name: size.value for size in game.sizes}
    return values[name]


def shown(value: Value) -> str:
    """Returns a value in words, a table in braces."""
    if isinstance(value, tuple):
        return "{ " + ", ".join(map(shown, value)) + " }"
    return say_value(value)
