"""Prints how a trajectory on a large map violates a check: the one step with the violation; of an episode also its totals."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import contains
from sjdsl.interpreter.board import Board, board_of
from sjdsl.interpreter.bodies import where_is
from sjdsl.interpreter.state import Cell, Mover, World
from sjdsl.interpreter.step import read
from sjdsl.properties.counterexample import in_short, opening, said_of_values, shown, take_step, when
from sjdsl.properties.effects import AWAY, HEADING, MOVED, PLACE, Part, reads
from sjdsl.properties.engines import Episode, EpisodeRunner
from sjdsl.properties.float_overflow import describe_overflow
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.monitors import Violation
from sjdsl.properties.search import Counterexample
from sjdsl.properties.trajectory import draws_of, params_of
from sjdsl.render.letters import draw
from sjdsl.trace.effects import Effect
from sjdsl.trace.episode import Moment
from sjdsl.trace.lines import make_teller, turn_lines
from sjdsl.trace.rules import Rules

AROUND = 2  # rows of the map shown above and below what changed
PLACES = {"place": PLACE, "heading": HEADING, "moved": MOVED, "away": AWAY}


def describe_episode(
    family: GameFamily, runner: EpisodeRunner, episode: Episode, policies: Sequence[ir.Policy], number: int, where: Violation
) -> list[str]:
    """Returns the totals of an episode, and of the step with the violation what the check reads."""
    check = family.own.checks[number]
    names = names_of(family, policies)
    totals = ", ".join(f"{name}{f'[{word}]' if word else ''} {count}" for (name, word), count in episode.totals.items())
    lines = [f"episode {episode.number} on the game's own map, the agents in turn: {names}"]
    lines += [f"at its end, after {len(episode.actions)} steps: {totals}"] if totals else []
    if where.at < 1 or (check.sort == "expect" and not any(holds for (holds,) in episode.values[number])):
        return lines  # no single step violates it
    world = runner.world_before(episode, policies, where.at - 1)
    moment = _still(family.own, runner, episode, world, policies, check, where)
    lines += list(_step(family, family.own, world, moment, check))
    since = where.since if where.since is not None and check.sort != "once" else where.at - 1
    for e, before, after in zip(check.values, episode.values[number][since], episode.values[number][where.at], strict=True):
        lines.append(f"{family.text_of(e)}: {shown(before)} {when(since)}, {shown(after)} {when(where.at)}")
    return lines


def describe_briefly(family: GameFamily, counterexample: Counterexample) -> list[str]:
    """Returns the text of a counterexample that is too long, or whose map is too large, to be told in full: actions, and the last step."""
    trajectory, scenario, at = counterexample.trajectory, counterexample.scenario, counterexample.where.at
    game, lines = trajectory.game, [opening(family, scenario)]
    if trajectory.left is not None and at == len(trajectory.worlds):
        before = [f"step {t}: {_acting(game, trajectory.actions[t])}" for t in range(max(0, at - 1))]
        return [*lines, *before, *describe_overflow(family, trajectory)]
    last = max(0, at - 1)
    lines += [f"step {t}: {_acting(game, trajectory.actions[t])}" for t in range(last)]
    world = trajectory.worlds[last]
    moment = take_step(game, world, trajectory.actions[last], trajectory.params, draws_of(scenario, last))
    check = game.checks[counterexample.number]
    return [*lines, *_step(family, game, world, moment, check), *said_of_values(family, counterexample)]


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
        yield from map(in_short, turn_lines(turn, teller))
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
