"""Random statements, each with what it may stand in."""

from dataclasses import dataclass, replace

from sjdsl.compiler import ir
from sjdsl.runtime.actions import HEADINGS
from tests.fuzz.acting import by_choice
from tests.fuzz.conditions import condition, probability, somebody, word
from tests.fuzz.declared import Lines
from tests.fuzz.members import domain, shape_for, where
from tests.fuzz.quantities import integer, key_for, real
from tests.fuzz.reading import Frame, Scope, Typed, Variable
from tests.fuzz.typed_numbers import fitted
from tests.fuzz.writing import BOLD, Written, is_own, of_target_alone, write

BEGINNING = ("start", "beginning")  # phases with which an episode begins
NESTED = 3  # quantifiers and branches inside one another


@dataclass
class Phase:
    """The phase in the making."""

    written: Written
    marks: bool = True


def indented(lines: Lines) -> Lines:
    return ["  " + line for line in lines]


def braces(head: str, body: Lines) -> Lines:
    if not body:
        return [f"{head} {{ }}"]
    return (
        [f"{head} {{ {body[0]} }}"]
        if len(body) == 1 and len(head + body[0]) < 100
        else [f"{head} {{", *indented(body), "}"]
    )


def block(scope: Scope, phase: Phase, depth: int, least: int = 1) -> Lines:
    """Returns the statements of a block; what `let` and `draw` bind holds to its end."""
    r = scope.world.random
    lines: Lines = []
    if r.random() < 0.01:
        return lines
    for _ in range(r.choice((1, 1, 2, 2, 3)) + least - 1):
        if r.random() < 0.15:
            made, scope = let(scope)
        elif r.random() < 0.12 and scope.sort in ("phase", *BEGINNING):
            made, scope = draw(scope)
        else:
            made = statement(scope, phase, depth)
        lines += made
    if lines or scope.sort in BEGINNING:
        return lines
    return effect(scope, phase) or ["give 1 to all"]


def statement(scope: Scope, phase: Phase, depth: int) -> Lines:
    """Returns one statement, of one line or more."""
    r = scope.world.random
    if depth >= NESTED or r.random() < 0.3:
        return effect(scope, phase)
    choices = ["each"] * 5 + ["pick"] * 2 + ["when"] * 3 + ["chance"] * 2
    if [v for v in scope.variables if scope.sort != "start" or not v.turns]:
        choices += ["first"] * 2
    if not scope.frames or scope.world.is_now(0.03):
        choices += ["match"] * 2
    match r.choice(choices):
        case "each":
            text, inner, _ = domain(scope, 2)
            return braces(f"each {text}", block(inner, phase, depth + 1))
        case "pick":
            return pick(scope, phase, depth)
        case "first":
            text, inner, _ = domain(scope, 1, shape=True, single=False)
            inner = _first_frames(scope, inner, text)
            return braces(f"first {text}", block(inner, phase, depth + 1))
        case "match":
            return match_(scope, phase, depth)
        case "when":
            return when(scope, phase, depth)
        case _:
            return chance(scope, phase, depth)


def _first_frames(scope: Scope, inner: Scope, text: str) -> Scope:
    """A shape of several lanes gives one instance a lane, but a partner is met through one lane at most."""
    last = replace(inner.frames[-1], single="fan" not in text)
    return replace(inner, frames=(*scope.frames, last))


def _otherwise(scope: Scope, phase: Phase, depth: int, chained: bool = False) -> Lines:
    """Returns `otherwise …`, or nothing."""
    w = scope.world
    if w.is_now(0.55):
        return []
    if chained and w.is_now(0.4):
        made = (when if w.is_now(0.5) else chance)(scope, phase, depth)
        return [f"otherwise {made[0]}", *made[1:]]
    return braces("otherwise", block(scope, phase, depth + 1))


def pick(scope: Scope, phase: Phase, depth: int) -> Lines:
    w = scope.world
    one = w.is_now(0.6)
    number = "1" if one else fitted(integer(scope, "count", 1), 0, 99)
    text, inner, _ = domain(scope, 2, single=one)
    lines = braces(f"pick {number} {text}", block(inner, phase, depth + 1))
    return lines + _otherwise(scope, phase, depth)


def match_(scope: Scope, phase: Phase, depth: int) -> Lines:
    """Returns a `match`, mostly of agents with agents."""
    w = scope.world
    left, inner, _ = domain(scope, 1, kind="agent" if w.is_now(0.7) else "")
    nearest = w.is_now(0.35) and scope.sort != "start" and any(v.turns for v in inner.variables)
    right, within, _ = domain(inner, 1, kind="agent" if w.is_now(0.7) else "", shape=nearest)
    if " in " in left.split(" where ")[0] and not w.is_now(BOLD):
        return effect(scope, phase)
    frame = len(scope.frames)
    sides = [
        replace(v, frame=frame, listed=v.name in left.split())
        for v in within.variables[len(scope.variables) :]
    ]
    within = replace(
        within,
        variables=(*scope.variables, *sides),
        frames=(*scope.frames, Frame(False, match=True)),
    )
    body = block(within, phase, depth + 1)
    both = [v for v in sides if v.is_agent]
    if len(both) > 1 and w.is_now(0.3):
        one = w.variable()
        among = within.having(Variable(one, (), frame + 1))
        among = replace(among, frames=(*within.frames, Frame(False, placed=True)))
        body += braces(
            f"each agent as {one} in {{ {both[0].name}, {both[1].name} }}",
            effect(among, phase) or ([] if scope.sort in BEGINNING else [f"give 1 to {one}"]),
        )
    return braces(f"match {left} with {'first ' if nearest else ''}{right}", body)


def when(scope: Scope, phase: Phase, depth: int) -> Lines:
    guard, inner = where(scope, 2)
    return braces(f"when {guard}", block(inner, phase, depth + 1)) + _otherwise(
        scope, phase, depth, chained=True
    )


def chance(scope: Scope, phase: Phase, depth: int) -> Lines:
    lines = braces(f"chance {probability(scope, 2)}", block(scope, phase, depth + 1))
    return lines + _otherwise(scope, phase, depth, chained=True)


def let(scope: Scope) -> tuple[Lines, Scope]:
    w = scope.world
    name = w.variable()
    match w.random.choice(("int", "int", "real", "word", "condition", "row", "agent")):
        case "real":
            unit = w.random.choice(("reward", "probability", "fraction"))
            text, type_ = real(scope, unit, 2)
        case "word":
            words = w.random.choice(w.words())
            found = word(scope, words, 2)
            text, type_ = (
                (found[0], ir.Type(kind="word", words=found[1]))
                if found
                else ("1", ir.Type(kind="int", low=1, high=1))
            )
        case "condition":
            text, type_ = condition(scope, 2), ir.CONDITION
        case "row" if scope.rows("int"):
            text, type_ = w.random.choice(scope.rows("int"))
        case "agent" if scope.nobodies():
            text, type_ = w.random.choice(scope.nobodies()), ir.AGENT
        case _:
            text, type_ = integer(scope, w.random.choice(("count", "steps", "cells")), 2)
    return [f"let {name} = {text}"], replace(scope, locals=(*scope.locals, (name, type_)))


def draw(scope: Scope) -> tuple[Lines, Scope]:
    w, r = scope.world, scope.world.random
    name = w.variable()
    words = r.choice(w.word_sets)
    match r.choice(("range", "range", "words", "weights", "numbers", "real")):
        case "real":
            low, more = r.choice((-1.5, 0.0, 0.25)), r.choice((0.0, 0.5, 2.0))
            text, made = (
                f"{low} .. {low + more}",
                ir.Type(kind="real", unit="number", low=low, high=low + more),
            )
        case "range":
            ends = _ends(scope)
            text, made = f"{ends[0]} .. {ends[1]}", ends[2]
        case "words":
            some = r.sample(words, r.randint(1, len(words)))
            text, made = f"{{ {', '.join(some)} }}", ir.Type(kind="word", words=tuple(some))
        case "numbers":
            some = [str(n) for n in r.sample(range(9), r.choice((1, 2, 3)))]
            low, high = min(map(int, some)), max(map(int, some))
            text, made = (
                f"{{ {_weights(scope, some)} }}",
                ir.Type(kind="int", unit="number", low=low, high=high),
            )
        case _:
            some = r.sample(words, r.choice((1, min(len(words), 3), min(len(words), 3))))
            text, made = f"{{ {_weights(scope, some)} }}", ir.Type(kind="word", words=tuple(some))
    return [f"draw {name} from {text}"], replace(scope, locals=(*scope.locals, (name, made)))


def _ends(scope: Scope) -> tuple[str, str, ir.Type]:
    r = scope.world.random
    pairs = [c for c in scope.world.requires if " <= " in c]
    if pairs and r.random() < 0.5:
        low, high = r.choice(pairs).split(" <= ")
        types = {p.name: p.type for p in scope.world.params}
        return (
            low,
            high,
            ir.Type(kind="int", unit=types[low].unit, low=types[low].low, high=types[high].high),
        )
    low, more = r.randint(-2, 2), r.randint(0, 4)
    if r.random() < 0.3:
        value, type_ = integer(scope, "count", 1)
        return (
            str(low),
            fitted((value, type_), low, low + 6),
            ir.Type(kind="int", unit="count", low=low, high=low + 6),
        )
    return str(low), str(low + more), ir.Type(kind="int", unit="number", low=low, high=low + more)


def _weights(scope: Scope, words: list[str]) -> str:
    r = scope.world.random
    if len(words) == 1:
        return f"{words[0]}: 1"
    chances = [
        p.name
        for p in scope.world.params
        if p.type.unit == "probability" and not p.type.indexed_by and p.type.high <= 0.5
    ]
    if chances and r.random() < 0.6:
        given = [
            r.choice(chances) if i < 1 or len(words) == 2 else "0.25" for i in range(len(words) - 1)
        ]
        return ", ".join(
            f"{w}: {p}" for w, p in zip(words, [*given, "1 - " + " - ".join(given)], strict=True)
        )
    parts = {2: ("0.3", "0.7"), 3: ("0.25", "0.5", "0.25")}[len(words)]
    return ", ".join(f"{w}: {p}" for w, p in zip(words, parts, strict=True))


def effect(scope: Scope, phase: Phase) -> Lines:
    """Returns a statement without others inside."""
    r = scope.world.random
    if scope.world.with_arguments and r.random() < 0.15:
        made = by_choice(
            scope,
            lambda inner: (
                give(inner, phase)
                if r.random() < 0.5
                else tally(inner, phase) or give(inner, phase)
            ),
        )
        if made:
            return made
    makers = [write] * 6 + [send] * 2 + [shift] * 2 + [remove]
    if scope.sort not in BEGINNING:
        makers += [give] * 3 + [tally] * 3 + [mark] * 2 + [end]
    for make in (r.choice(makers), r.choice(makers)):
        made = make(scope, phase.written, 2) if make is write else make(scope, phase)  # type: ignore[operator]
        if made:
            return made
    return [] if scope.sort in BEGINNING else give(scope, phase)


def give(scope: Scope, _phase: Phase) -> Lines:
    r = scope.world.random
    value = real(scope, "reward", 2)[0]
    sets = [text for text, _ in scope.single_values("agents")]
    options = ["all", *somebody(scope) * 2, *sets]
    agents = [v.name for v in scope.agents()]
    options += [f"all but {a}" for a in agents]
    return [f"give {value} to {r.choice(options)}"]


def tally(scope: Scope, _phase: Phase) -> Lines:
    w, r = scope.world, scope.world.random
    event = r.choice(w.events)
    text = event.name
    if event.by:
        key = key_for(scope, event.by, 2) or (event.by.names[0] if event.by.kind == "word" else "")
        if not key:
            return []
        text += f"[{key}]"
    if r.random() < 0.4:
        text += f" by {fitted(integer(scope, 'count', 1), 0, 1000)}"
    if event.per_agent:
        sets = [s for s, _ in scope.single_values("agents")]
        receivers = [*somebody(scope) * 2, *sets]
        if not receivers:
            return []
        text += f" for {r.choice(receivers)}"
    return [f"tally {text}"]


def send(scope: Scope, phase: Phase) -> Lines:
    """Returns a `send` of somebody."""
    w, r = scope.world, scope.world.random
    who = _to_be_sent(scope, phase)
    if who is None:
        return []
    kind = r.choice(
        [n for n in (*w.kinds, *w.groups) if w.num_cells(w.kinds_of(n)) or w.is_now(0.1)]
    )
    later = w.is_now(0.4)
    named = scope if is_own(who, scope) and not later else of_target_alone(scope, who)
    held = [text for text, _ in named.single_values("cell")]
    if held and w.is_now(0.4):
        text, kind = r.choice(held), ""
    else:
        text = destination(replace(named, sort="start") if later else named, kind)
    certain = kind and " where " not in text and w.num_cells(w.kinds_of(kind)) >= w.bodies
    phase.written.places += 1
    delay = f" after {r.choice(('1', '2', '3', _delay(scope)))}" if later else ""
    facing = (
        f" facing {r.choice(('north', 'east', 'south', 'west', 'same'))}" if w.is_now(0.5) else ""
    )
    if w.is_now(0.2):
        facing = _way(scope if is_own(who, scope) else of_target_alone(scope, who)) or facing
    stay = " otherwise stay" if not certain or w.is_now(0.3) else ""
    return [f"send {who.name} to {text}{delay}{facing}{stay}"]


def _to_be_sent(scope: Scope, phase: Phase) -> Variable | None:
    """Returns an agent or a mover that may be sent somewhere, if there is one; few phases send several."""
    w = scope.world
    if scope.sort == "start" or (phase.written.places and not w.is_now(2 * BOLD)):
        return None
    turned = ("agent", "", "heading") in phase.written.fields  # agents, who can't be sent as well
    agents = () if turned and not w.is_now(BOLD) else scope.agents()
    able = [v for v in (*agents, *scope.movers()) if is_own(v, scope) or w.is_now(0.5)]
    return w.random.choice(able) if able else None


def shift(scope: Scope, phase: Phase) -> Lines:
    """Returns a `send … by` of somebody."""
    w, r = scope.world, scope.world.random
    who = _to_be_sent(scope, phase)
    if who is None:
        return []
    named = scope if is_own(who, scope) else of_target_alone(scope, who)
    phase.written.places += 1
    far = r.choice(("0", "1", "1", "1", "2", "3", fitted(integer(named, "cells", 1), 0, 4)))
    headings = word(named, HEADINGS, 1)
    ways = [
        "ahead",
        "back",
        "left",
        "right",
        *HEADINGS[:2],
        *([headings[0]] if headings and " " not in headings[0] else []),
    ]
    ways += [
        f"{how} {v.name}"
        for v in named.variables
        for how in ("away from", "toward")
        if v.name != who.name
    ]
    facing = f" facing {r.choice((*HEADINGS, 'same'))}" if w.is_now(0.4) else ""
    if w.is_now(0.2):
        facing = _way(named) or facing
    return [f"send {who.name} by {far} {r.choice(ways)}{facing} otherwise stay"]


def _way(scope: Scope) -> str:
    """Returns a computed heading to face, nothing if there is none."""
    found = word(scope, HEADINGS, 1)
    return f" facing {found[0]}" if found and " " not in found[0] else ""


def _delay(scope: Scope) -> str:
    alone = replace(scope, variables=(), locals=(), sure=frozenset(), filled=frozenset())
    return fitted(integer(alone, "steps", 1), 0, 5)


def destination(scope: Scope, kind: str) -> str:
    """Returns kind and condition of a destination, which may name what is known in the scope."""
    w = scope.world
    name = kind if not w.is_now(0.4) and not scope.uses(kind) else w.variable()
    text = kind if name == kind else f"{kind} as {name}"
    if w.is_now(0.45):
        around = replace(scope, variables=tuple(v for v in scope.variables if v.name != name))
        text += f" where {condition(around.having(Variable(name, w.kinds_of(kind))), 2)}"
    return text


def mark(scope: Scope, _phase: Phase) -> Lines:
    w = scope.world
    agents = [v for v in scope.agents() if v.listed]
    agents = agents if agents or not w.is_now(BOLD / 4) else scope.agents()
    if not agents:
        return []
    shape, _ = shape_for(scope, agent=True)
    return [f"mark {shape} of {w.random.choice(agents).name}"]


def remove(scope: Scope, phase: Phase) -> Lines:
    w = scope.world
    if scope.sort == "start" or phase.written.places or not w.is_now(0.4):
        return []
    agents = [v.name for v in (*scope.agents(), *scope.movers())]
    if not agents:
        return []
    phase.written.places += 1
    return [f"remove {w.random.choice(agents)}"]


def end(scope: Scope, _phase: Phase) -> Lines:
    return ["end"] if scope.sort == "phase" and scope.world.is_now(0.3) else []


__all__ = ["Typed", "block", "braces"]
