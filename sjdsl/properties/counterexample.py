"""Prints a counterexample to a check: the map, the actions, what each rule changes and by which draw; of a long one the step that violates it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import contains
from sjdsl.interpreter.account import Account
from sjdsl.interpreter.board import Board, board_of
from sjdsl.interpreter.bodies import where_is
from sjdsl.interpreter.state import Cell, Mover, Value, World
from sjdsl.interpreter.step import action_mask, read, step
from sjdsl.interpreter.threefry import Draws
from sjdsl.properties.effects import AWAY, HEADING, MOVED, PLACE, Part, reads
from sjdsl.properties.engines import Episode, EpisodeRunner
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.monitors import Violation
from sjdsl.properties.search import Counterexample
from sjdsl.properties.trajectory import Scenario, Trajectory, draws_of, params_of
from sjdsl.render.letters import draw
from sjdsl.trace.effects import Effect
from sjdsl.trace.episode import Moment, Told, tell_of
from sjdsl.trace.jax_random import RecordedDraws
from sjdsl.trace.lines import make_teller, moment_lines, turn_lines
from sjdsl.trace.rules import Rules
from sjdsl.trace.wording import say_value

AROUND = 2  # rows of the map shown above and below what changed
PLACES = {"place": PLACE, "heading": HEADING, "moved": MOVED, "away": AWAY}
LARGEST = "3.4e38"  # of float32: (2 - 2^-23) * 2^127


def describe_counterexample(family: GameFamily, counterexample: Counterexample, brief: bool = False) -> list[str]:
    """Returns the text of a counterexample: the map with its legend, and each step, rule by rule, with the map after it.

    brief: of one that is too long, or whose map is too large, the actions, and the last step.
    """
    trajectory, scenario, at = counterexample.trajectory, counterexample.scenario, counterexample.where.at
    game, lines, last = trajectory.game, [opening(family, scenario)], max(0, at - 1)
    leaves = trajectory.left is not None and at == len(trajectory.worlds)

    def moment(t: int) -> Moment:
        return take_step(game, trajectory.worlds[t], trajectory.actions[t], trajectory.params, draws_of(scenario, t))

    if brief:
        lines += [f"step {t}: {_acting(game, trajectory.actions[t])}" for t in range(last)]
        lines += [] if leaves else _step(family, game, trajectory.worlds[last], moment(last), game.checks[counterexample.number])
    else:
        teller = make_teller(board_of(game), Rules(family.composition.sources))
        rows = draw(teller.looks, teller.board, trajectory.worlds[0])
        here = "".join((*game.rows, *(row.split("  ")[0] for row in rows)))
        lines += ["    ".join(said for said in teller.looks.legend() if said[0] in here), *(f"    {row}" for row in rows)]
        lines += [line for t in range(last if leaves else last + 1) for line in moment_lines(moment(t), teller) if line]
    return lines + (describe_overflow(family, trajectory) if leaves else said_of_values(family, counterexample))


def opening(family: GameFamily, scenario: Scenario) -> str:
    """Returns in words where a counterexample is played: how many agents on which map, and the parameters that differ."""
    own = {p.name: p.value for p in family.own.params} | {s.name: s.value for s in family.own.sizes}
    numbers = "".join(f", {name} = {shown(value)} (the file: {shown(own[name])})" for name, value in (*scenario.params, *scenario.sizes))
    where = "the game's own map" if family.is_own(scenario.rows) else "a small map"
    return f"{scenario.agents} agent{'s' * (scenario.agents != 1)} on {where}{numbers}"


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
    """Returns `apples = 0 at the start, 1 after step 2` for each value that the check reads, and one state for `before(apples)`."""
    trajectory, where, check = counterexample.trajectory, counterexample.where, counterexample.trajectory.game.checks[counterexample.number]
    if check.sort == "symmetric":
        return []
    since = where.since if where.since is not None and check.sort != "once" else where.at - 1
    states, lines = [t for t in (since, where.at) if t >= 0], []
    for e in _told_of(check):
        told = states[-1:] if contains(e, ir.Before) else states
        lines.append(f"{family.text_of(e)} = {', '.join(f'{shown(trajectory.value(e, t))} {when(t)}' for t in told)}")
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


def shown(value: Value) -> str:
    """Returns a value in words, a table in braces."""
    if isinstance(value, tuple):
        return "{ " + ", ".join(map(shown, value)) + " }"
    return say_value(value)


def describe_episode(
    family: GameFamily, runner: EpisodeRunner, episode: Episode, policies: Sequence[ir.Policy], number: int, where: Violation
) -> list[str]:
    """Returns the totals of an episode, and of the step with the violation what the check reads."""
    check = family.own.checks[number]
    names = names_of(family, policies)
    totals = ", ".join(f"{name}{f'[{word}]' if word else ''} {count}" for (name, word), count in episode.totals.items())
    lines = [f"episode {episode.number} on the game's own map, the agents in turn: {names}"]
    lines += [f"at its end, after {len(episode.actions)} steps: {totals}"] if totals else []
    if where.at < 1 or not any(holds for (holds,) in episode.values[number]):
        return lines  # no single step violates it
    world = runner.world_before(episode, policies, where.at - 1)
    moment = _still(family.own, runner, episode, world, policies, check, where)
    lines += list(_step(family, family.own, world, moment, check))
    values = episode.values[number]
    for e, before, after in zip(check.values, values[where.at - 1], values[where.at], strict=True):
        lines.append(f"{family.text_of(e)}: {shown(before)} {when(where.at - 1)}, {shown(after)} {when(where.at)}")
    return lines


def names_of(family: GameFamily, policies: Sequence[ir.Policy]) -> str:
    """Returns the policies as they are written."""
    return ", ".join(dict.fromkeys(family.text_of(p) if p.origin is not None else p.name for p in policies))


def _still(
    game: ir.Game, runner: EpisodeRunner, episode: Episode, world: World, policies: Sequence[ir.Policy], check: ir.Check, where: Violation
) -> Moment:
    """Returns the step with the violation, in which every agent stays whose action is not needed for it."""
    scenario, params, stay = runner.scenario(policies, episode.number), params_of(game, ()), game.agents.actions.index("stay")
    draws = draws_of(scenario, where.at - 1)
    moment = take_step(game, world, episode.actions[where.at - 1], params, draws)
    if contains(check, ir.EventTotal):
        return moment  # totals are those of the episode as it went
    wrong = [read(game, moment.world, e, before=(world, {})) for e in check.values]
    for agent in range(game.agents.number):
        actions = (*moment.actions[:agent], stay, *moment.actions[agent + 1 :])
        quieter = take_step(game, world, actions, params, draws)
        if [read(game, quieter.world, e, before=(world, {})) for e in check.values] == wrong:
            moment = quieter
    return moment


def _step(family: GameFamily, game: ir.Game, world: World, moment: Moment, check: ir.Check) -> Iterator[str]:
    """Yields the rules of a step that changed what a check reads, between the affected rows of the map before and after."""
    about = {part for e in check.values for part in reads(e)}
    board = board_of(game)
    teller = make_teller(board, Rules(family.composition.sources))
    turns = [replace(turn, effects=tuple(e for e in turn.effects if _part(e, board) in about)) for turn in moment.turns]
    turns = [turn for turn in turns if turn.effects] or list(moment.turns)
    rows = _rows([e for turn in turns for e in turn.effects], moment.world, len(game.rows))
    before, after = draw(teller.looks, board, world), draw(teller.looks, board, moment.world)
    here = {glyph for row in rows for glyph in (before[row] + after[row])}
    yield "    ".join(said for said in teller.looks.legend() if said[0] in here)
    yield from (f"    {before[row]}" for row in rows)
    yield f"step {moment.number}: {_acting(game, moment.actions)}"
    for turn in turns:
        yield from turn_lines(turn, teller)
    yield from (f"    {after[row]}" for row in rows)


def _acting(game: ir.Game, actions: Sequence[int]) -> str:
    """Returns what the agents do in a step, in words."""
    acting = [f"{agent} {game.agents.actions[action]}" for agent, action in enumerate(actions) if game.agents.actions[action] != "stay"]
    return (", ".join(acting) or "all stay") + (", the others stay" if acting and len(acting) < len(actions) else "")


def _part(effect: Effect, board: Board) -> Part:
    """Returns which part of the state an effect changes, as in `effects.py`."""
    name = effect.name.partition("[")[0]
    match effect.sort:
        case "field" if isinstance(effect.owner, Cell):
            return ("cell", board.kind_of[effect.owner], name)
        case "field" | "heading" | "moved" | "away" if isinstance(effect.owner, Mover):
            return ("mover", effect.owner.sort, name if effect.sort == "field" else effect.sort)
        case "field":
            return ("world" if effect.owner is None else "agent", name)
        case "event":
            return ("event", name)
        case _:
            return PLACES.get(effect.sort, ("",))


def _rows(effects: Sequence[Effect], world: World, height: int) -> range:
    """Returns the rows of the map around what changed; all if nothing has a cell."""
    cells = [e.owner if isinstance(e.owner, Cell) else where_is(e.owner, world) for e in effects if e.owner is not None]
    rows = [cell.row for cell in cells if cell is not None]
    return range(max(0, min(rows) - AROUND), min(height, max(rows) + AROUND + 1)) if rows else range(height)


def describe_overflow(family: GameFamily, trajectory: Trajectory) -> list[str]:
    """Returns what the agents do in the last step of a trajectory, the statement, and the largest reals before it."""
    assert trajectory.left is not None
    rules, node = Rules(family.composition.sources), trajectory.left.node
    said = f"{rules.place(node)}  {rules.text(node)}"
    if not trajectory.worlds:
        return [f"in phase start: {said}"]
    world, names = trajectory.worlds[-1], trajectory.game.agents.actions
    acting = ", ".join(f"{agent} {names[action]}" for agent, action in enumerate(trajectory.actions[-1]))
    told = [f"step {world.step}: {acting}"] if len(trajectory.actions) > len(trajectory.outcomes) else []
    return [*told, f"  {said}: the result is larger than the largest float32, {LARGEST}, or no number", *_reals(world)]


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
