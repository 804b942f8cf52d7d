"""The English of statements: one line for each, with the statements inside it below."""

from typing import assert_never

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import written_field
from sjdsl.doc.phrases import condition, members, nearest, operand, shape_of, side, value
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import Line, article, code, codes, counted, joined, number, variable
from sjdsl.runtime.actions import HEADINGS


def block(body: tuple[ir.Stmt, ...], v: Vocabulary) -> tuple[Line, ...]:
    """Returns the lines of a block of statements."""
    return tuple(line for statement in body for line in lines(statement, v))


def lines(s: ir.Stmt, v: Vocabulary) -> list[Line]:
    """Returns a statement; those with several branches have a line for each."""
    match s:
        case ir.Let():
            return [Line(f"let {variable(s.name)} be {value(s.value, v)}")]
        case ir.Draw():
            return [Line(f"draw {variable(s.name)} at random: {drawn(s, v)}")]
        case ir.Each():
            return [Line(f"each {members(s.domain, v)}", block(s.body, v))]
        case ir.Pick():
            head = f"{chosen(s, v)}; for {'it' if _is_one(s) else 'each one chosen'}"
            return [Line(head, _body(s.body, v)), *_otherwise("if there was none to choose from", s.otherwise, v)]
        case ir.First():
            noun, shape = nearest(s.domain, v)
            head = f"in each lane of {shape}, for the nearest {noun}"
            return [Line(head, _body(s.body, v))]
        case ir.Match():
            head = f"make random pairs, each of {paired(s, v)}, so that nothing and nobody is in two pairs; for each pair"
            return [Line(head, _body(s.body, v))]
        case ir.When() | ir.Chance():
            found = []
            for i, b in enumerate(s.branches):
                head = f"if {condition(b.test, v)}" if isinstance(s, ir.When) else f"with {probability(b.test, v)}"
                found.append(Line(f"{'otherwise, ' if i else ''}{head}", _body(b.body, v)))
            return [*found, *_otherwise("otherwise", s.otherwise, v)]
        case ir.Set():
            return [Line(_set(s, v))]
        case ir.Add():
            return [Line(_add(s, v))]
        case ir.Give():
            return [Line(f"{_receivers(s, v)} a reward of {value(s.value, v)}")]
        case ir.Tally():
            return [Line(_tally(s, v))]
        case ir.Send():
            return [Line(_send(s, v))]
        case ir.Shift():
            return [Line(_shift(s, v))]
        case ir.Remove():
            return [Line(f"{value(s.who, v)} is taken away for the rest of the episode")]
        case ir.Move():
            if s.course is not None:
                return [Line(f"all at the same time (see Movement), each {members(s.domain, v)} {_course(s.course, v)}")]
            return [Line(f"each {members(s.domain, v)} makes the move it chose, all at the same time (see Movement)")]
        case ir.Mark():
            return [Line(f"the cells of {shape_of(s.shape, s.anchor, v)} are marked for the next observation")]
        case ir.End():
            return [Line("the episode ends after the last phase of this step")]
        case _:
            assert_never(s)


def probability(e: ir.Expr, v: Vocabulary) -> str:
    """Returns `probability regrow (0.05)`; of a `case` the arms follow in brackets."""
    if isinstance(e, ir.At) and isinstance(e.key, ir.Word):
        return f"a probability of {value(e, v)}"
    return f"a probability of ({value(e, v)})" if isinstance(e, ir.Case) else f"probability {side(e, v)}"


def drawn(s: ir.Draw, v: Vocabulary) -> str:
    """Returns what a `draw` draws from."""
    if s.low is not None and s.high is not None:
        if s.type.kind == "real":
            return f"a real number between {side(s.low, v)} and {side(s.high, v)}, all equally likely"
        return f"a whole number from {side(s.low, v)} to {side(s.high, v)}, both included, all equally likely"
    if s.weights:
        values = [str(number) for number in s.numbers] or [code(word) for word in s.words]
        return joined((f"{one} with {probability(p, v)}" for one, p in zip(values, s.weights, strict=True)), "or")
    return f"{codes(s.words, 'or')}, all equally likely"


def chosen(s: ir.Pick, v: Vocabulary) -> str:
    """Returns of whom and how many a `pick` chooses."""
    crowd = f"from all {members(s.domain, v, plural=True)}, choose"
    if _is_one(s):
        return f"{crowd} one at random"
    many = side(s.number, v) if isinstance(s.number, ir.Number) else f"as many as {side(s.number, v)}"
    return f"{crowd} {many} at random (all of them, if there are fewer)"


def paired(s: ir.Match, v: Vocabulary) -> str:
    """Returns who is paired with whom by a `match`."""
    left = article(members(s.left, v))
    if not s.first:
        return f"{left} and {article(members(s.right, v))}"
    right, shape = nearest(s.right, v)
    return f"{left} and, in a lane of {shape}, the nearest {right}"


def _body(body: tuple[ir.Stmt, ...], v: Vocabulary) -> tuple[Line, ...]:
    return block(body, v) or (Line("nothing happens"),)


def _otherwise(head: str, body: tuple[ir.Stmt, ...], v: Vocabulary) -> list[Line]:
    return [Line(head, block(body, v))] if body else []


def _is_one(s: ir.Pick) -> bool:
    return isinstance(s.number, ir.Number) and s.number.value == 1


def _set(s: ir.Set, v: Vocabulary) -> str:
    is_emptied = s.target.type.kind == "agents" and isinstance(s.value, ir.Nobody) and s.lot is None
    target, new = value(s.target, v), "empty" if is_emptied else value(s.value, v)
    if s.lot is not None:
        return f"{target} becomes {new} (of all that would change it one does, each equally likely)"
    return f"{'every entry of ' if s.target.type.by and not s.value.type.by else ''}{target} becomes {new}"


def _add(s: ir.Add, v: Vocabulary) -> str:
    target = value(s.target, v)
    if s.target.type.kind == "agents":
        return f"{value(s.value, v)} joins {target}"
    field = v.field(written_field(s.target))
    limits = f" (which stays within {number(field.type.low)} to {number(field.type.high)})" if field.capped else ""
    if s.value.type.by:
        return f"each entry of {operand(s.value, v)} is added to the same entry of {target}{limits}"
    if isinstance(s.value, ir.Number) and s.value.value < 0:
        return f"{number(-s.value.value)} is taken from {target}{limits}"
    return f"{value(s.value, v)} is added to {target}{limits}"


def _receivers(s: ir.Give, v: Vocabulary) -> str:
    if s.receiver is None:
        return "every agent receives" if s.but is None else f"every agent except {v.refer(s.but)} receives"
    who = value(s.receiver, v)
    return f"each agent among {who} receives" if s.receiver.type.kind == "agents" else f"{who} receives"


def _tally(s: ir.Tally, v: Vocabulary) -> str:
    each = "each agent among " if s.receiver is not None and s.receiver.type.kind == "agents" else ""
    whom = "" if s.receiver is None else f" for {each}{value(s.receiver, v)}"
    under = "" if s.word is None else f", under {value(s.word, v)}"
    if s.amount is None or isinstance(s.amount, ir.Number):
        times = "once" if s.amount is None else f"{number(s.amount.value)} times"
        return f"the event {code(s.event)} is counted {times}{whom}{under}"
    return f"the event {code(s.event)} is counted{whom}{under}, as many times as {side(s.amount, v)}"


def _course(course: ir.Course, v: Vocabulary) -> str:
    """Returns which way movers go."""
    if isinstance(course, ir.Along):
        if isinstance(course.heading, ir.FieldRead) and course.heading.held_by.what == "mover" and course.heading.name == "heading":
            return "steps to the cell in front of it"
        return f"turns to {value(course.heading, v)} and steps that way"
    beside = "turns to one of the free cells beside it, at random with equal chances, and steps there"
    if course.avoided is not None:
        avoided = members(course.avoided, v, plural=True)
        beside = beside.replace(
            "beside it,", f"beside it ({'never' if course.avoided.var.sort.what == 'cell' else 'never those of'} {avoided}),"
        )
    if course.goal is None:
        return beside
    which = "farther from" if course.away else "nearer to"
    return f"{beside}: only those {which} the nearest of the {members(course.goal, v, plural=True)}; it stays if there is none"


def _send(s: ir.Send, v: Vocabulary) -> str:
    """Returns whom a `send` sends, where to, when, and how they look there."""
    only = one_cell(s.domain)
    goal = f"{f'a random free {members(s.domain, v)}' if only is None else value(only, v)}, {_look(s.facing)}"
    if s.after is not None:
        wait = counted(s.after.value, "tick") if isinstance(s.after, ir.Number) else f"{value(s.after, v)} ticks"
        stay = "; while there is no free cell then, it stays away" if s.stay else ""
        return f"{value(s.who, v)} is away for {wait}, then comes back to {goal}{stay}"
    return f"{value(s.who, v)} is sent to {goal}" + ("; if there is no free cell left, it stays where it is" if s.stay else "")


def one_cell(d: ir.Domain) -> ir.Expr | None:
    """Returns the cell that a destination is, if it is one that a field holds."""
    match d.where:
        case ir.Same(left=ir.Member(name=name), right=right) if name == d.var.name and right.type.kind == "cell":
            return right
        case _:
            return None


def _look(facing: str | None) -> str:
    if facing is None:
        return "looking in a random direction"
    return "looking as before" if facing == "same" else f"looking {facing}"


TURNED = ("the way it looks", "to its right", "back", "to its left")


def _shift(s: ir.Shift, v: Vocabulary) -> str:
    """Returns whom a `send … by` sends, how far and which way."""
    if s.to is not None:
        return f"{value(s.who, v)} is sent to {value(s.to, v)}, {_look(s.facing)}; if it cannot go there, it stays where it is"
    assert s.steps is not None
    match s:
        case ir.Shift(heading=ir.Attribute(name="heading", owner=owner)) if owner == s.who:
            way = TURNED[s.quarters % 4]
        case ir.Shift(heading=ir.Word(value=word)):
            way = f"to the {HEADINGS[(HEADINGS.index(word) + s.quarters) % 4]}"
        case ir.Shift(heading=None):
            assert s.other is not None
            turned = {0: "toward", 2: "away from"}.get(s.quarters, f"{s.quarters} quarter turns to the right of the way toward")
            way = f"{turned} {value(s.other, v)}, along the longer of the two distances"
        case _:
            assert s.heading is not None
            way = f"in the direction {value(s.heading, v)}" + (f", turned {s.quarters} times to the right" if s.quarters else "")
    far = counted(s.steps.value, "cell") if isinstance(s.steps, ir.Number) else f"{value(s.steps, v)} cells"
    return f"{value(s.who, v)} is sent {far} {way}, {_look(s.facing)}; if the way is not free, it stays where it is"


def turn_lines(v: Vocabulary) -> list[tuple[str, tuple[Line, ...]]]:
    """Returns each turn of the schedule with its sentences."""
    return [(t.label, block(t.body, v)) if isinstance(t, ir.Phase) else ("tick", tuple(_tick_lines(v))) for t in v.game.schedule]


def _tick_lines(v: Vocabulary) -> list[Line]:
    """Returns what happens at `tick` in this game."""
    agents = [f"{code(f.name)} of each agent" for f in v.game.agents.fields if f.timer]
    agents += [f"{code(f.name)} of each {sort.name}" for sort in v.game.movers for f in sort.fields if f.timer]
    cells = [f"{code(f.name)} of each {k.name} cell" for k in v.game.kinds for f in k.fields if f.timer]
    world = [f"{code(f.name)} of the world" for f in v.game.fields if f.timer]
    found = [Line(f"these timers fall by 1 if they are above 0: {joined([*agents, *cells, *world])}")] if agents or cells or world else []
    if v.waits:
        found.append(
            Line(f"each {v.somebody} that is away for a number of ticks is one tick nearer to its return; who has none left returns now")
        )
    return found or [Line("nothing: the game has no timers, and nobody is away for a time")]
