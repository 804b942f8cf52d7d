"""How a promise breaks, in pictures and words: the map, what the agents do, what each rule changes and by which draw."""

import re
from collections.abc import Iterator, Mapping, Sequence

from sjdsl.compiler import ir
from sjdsl.interpreter.account import Account
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.state import Value, World
from sjdsl.interpreter.step import action_mask, read, step
from sjdsl.interpreter.threefry import Draws
from sjdsl.properties.float_overflow import tell_overflow
from sjdsl.properties.instances import Ground
from sjdsl.properties.monitors import Totals
from sjdsl.properties.search import Broken
from sjdsl.properties.trajectory import words_of
from sjdsl.trace.episode import Moment, Told, tell_of
from sjdsl.trace.lines import make_teller, moment_lines
from sjdsl.trace.picture import draw
from sjdsl.trace.random_words import Heard
from sjdsl.trace.rules import Rules
from sjdsl.trace.wording import say_value

_WORD = re.compile(r"  \(random word [0-9a-f]{8}: number \d+ of stream [0-9a-f]{8}\)")


def tell_course(ground: Ground, broken: Broken) -> list[str]:
    """Returns the whole course that breaks a promise."""
    played, course = broken.played, broken.course
    numbers = "".join(f", {name} = {shown(value)} (the file: {shown(_own(ground.own, name))})" for name, value in course.params)
    lines = [f"{course.agents} agent{'s' * (course.agents != 1)} on a small map{numbers}", *legend(ground, played.game, played.worlds[0])]
    leaves = played.left is not None and broken.where.at == len(played.worlds)
    for t in range(broken.where.at - 1 if leaves else max(1, broken.where.at)):
        lines += tell_step(ground, played.game, played.worlds[t], played.actions[t], played.params, words_of(course, t))
    if leaves:
        return lines + tell_overflow(ground, played)
    return lines + said_of_values(ground, broken)


def legend(ground: Ground, game: ir.Game, world: World) -> Iterator[str]:
    """Yields what the characters of a map stand for, and the map."""
    teller = make_teller(board_of(game), Rules(ground.composition.sources))
    here = {glyph for row in draw(teller.looks, teller.board, world) for glyph in row.split("  ")[0]}
    yield "    ".join(said for said in teller.looks.legend() if said[0] in here or said[0] in "".join(game.rows))
    yield from (f"    {row}" for row in draw(teller.looks, teller.board, world))


def tell_step(ground: Ground, game: ir.Game, world: World, actions: Sequence[int], params: Mapping[str, Value], words: Draws) -> list[str]:
    """Returns one step, rule by rule, and the map after it."""
    moment = take_step(game, world, actions, params, words)
    return [in_short(line) for line in moment_lines(moment, make_teller(board_of(game), Rules(ground.composition.sources))) if line]


def in_short(line: str) -> str:
    """Returns a line of a trace without where its random word comes from."""
    return _WORD.sub("", line)


def take_step(game: ir.Game, world: World, actions: Sequence[int], params: Mapping[str, Value], words: Draws) -> Moment:
    """Returns what there is to tell of a step."""
    board, heard = board_of(game), Heard(words)
    told: list[Told] = []

    def tell(account: Account) -> None:
        told.append(tell_of(account, board, heard.words))
        heard.words.clear()

    allowed = action_mask(game, world)
    forbidden = frozenset(agent for agent, action in enumerate(actions) if not allowed[agent][action])
    after, outcome = step(game, world, actions, params, heard, tell)
    return Moment(world.step, (0, 0), after, tuple(told), tuple(actions), forbidden, outcome)


def said_of_values(ground: Ground, broken: Broken) -> list[str]:
    """Returns the numbers that the promise speaks of, before the break and after it."""
    played, where, check = broken.played, broken.where, broken.played.game.checks[broken.promise]
    if check.sort == "symmetric":
        return []
    since = where.since if where.since is not None and check.sort != "once" else where.at - 1
    return values_lines(ground, check, [(when(t), played.game, played.worlds[t], played.totals[t]) for t in (since, where.at) if t >= 0])


def values_lines(ground: Ground, check: ir.Check, states: Sequence[tuple[str, ir.Game, World, Totals]]) -> list[str]:
    """Returns `apples = 0 at the start, 1 after step 2` for each number that a promise speaks of."""
    lines = []
    for e in _told_of(check):
        values = ", ".join(f"{shown(read(game, world, e, totals))} {name}" for name, game, world, totals in states)
        lines.append(f"{ground.text_of(e)} = {values}")
    return list(dict.fromkeys(lines))


def when(at: int) -> str:
    """Returns when the state `at` is; steps are numbered as `step` is."""
    return f"after step {at - 1}" if at else "at the start"


def tell_symmetry(differing: tuple[str, list[str]] | None) -> list[str]:
    """Returns what would have come of the last step under the turned rules."""
    assert differing is not None
    said, found = differing
    return [f"{said}, this step would give something else:", *(f"  {line} instead" for line in found)]


def _told_of(check: ir.Check) -> list[ir.Expr]:
    """Returns the sides of comparisons in a promise that depend on the state, or what it speaks of if it compares nothing."""
    found: list[ir.Expr] = []
    for value in check.values:
        sides = [side for n in _open(value) if isinstance(n, ir.Compare) for side in (n.left, n.right)]
        found += [side for side in sides if not isinstance(side, ir.Number | ir.ParamRef)] or [value]
    return found


def _open(e: ir.Node) -> Iterator[ir.Node]:
    """Yields the conditions that a condition is made of, those inside counts aside."""
    yield e
    if isinstance(e, ir.Logic | ir.Not | ir.Named):
        for child in ir.children(e):
            yield from _open(child)


def _own(game: ir.Game, name: str) -> Value:
    return next(p.value for p in game.params if p.name == name)


def shown(value: Value) -> str:
    """Returns a value in words, a table in braces."""
    if isinstance(value, tuple):
        return "{ " + ", ".join(map(shown, value)) + " }"
    return say_value(value)
