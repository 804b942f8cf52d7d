"""Random whole games: well-typed `.sj` texts that use every part of the language, small enough to be played in a moment.

Units, intervals, who is whose and what is known of agents are tracked while a text is made, so that most texts are accepted. Now and
then a statement is bolder than what surely passes: the border of what the compiler accepts is looked at, too.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from random import Random

from hypothesis import strategies as st

from sjdsl.compiler import ir
from sjdsl.compiler.ir.entity_types import IndexSet
from sjdsl.runtime.actions import HEADINGS
from tests.fuzz.acting import forbidden
from tests.fuzz.checked import checks, metrics, observe
from tests.fuzz.conditions import condition
from tests.fuzz.declared import Define, Lines, Number, World
from tests.fuzz.declaring import a_field, declare, param
from tests.fuzz.members import domain
from tests.fuzz.policies import policies, scenarios
from tests.fuzz.quantities import integer, real
from tests.fuzz.reading import Scope, Variable
from tests.fuzz.sides import splits
from tests.fuzz.statements import Phase, block, braces, destination, indented
from tests.fuzz.writing import Written

SHARE_WITH_TRIALS = 0.2  # of programs
STARTING = ("claim", "set_up", "deal_out")
NAMES = ("grow", "share_out", "settle", "walk_on", "trade", "decay", "look_round")


@dataclass(frozen=True)
class Program:
    """A game's text, the files it needs beside it, and the names of its variants."""

    text: str
    files: dict[str, str] = field(default_factory=dict)
    variants: tuple[str, ...] = ()


def program(random: Random, checks: Callable[[World], list[Lines]] = checks) -> Program:
    """Returns a random game. `checks`: makes its checks, and what they need."""
    w = declare(random)
    requires(w)
    for _ in range(random.choice((0, 1, 1, 2, 3))):
        define(w)
    sections: list[Lines] = [[n.text] for n in (*w.sizes, *w.params)]
    files: dict[str, str] = {}
    loose = (
        [['cite "nobody\'s source"'], ['about summary "one line" "and one more"']]
        if w.is_now(0.1)
        else []
    )
    loose += [
        _episode(w),
        *_task(w),
        *_kinds(w),
        *([g] for g in _groups(w)),
        *([f.text] for f in w.fields),
        _map(w, files),
        agents(w),
        *movers(w),
    ]
    loose += [[t] for t in w.shape_texts] + [[d.text] for d in w.defines]
    begin = starting(w)
    turns, phases = schedule(w, begin)
    loose += [
        start(w),
        *begin,
        [f"schedule {' -> '.join(turns)}"],
        *phases,
        metrics(w),
        *policies(w),
        *scenarios(w),
        *checks(w),
        *observe(w),
    ]
    loose += [[line] for line in looks(w)]
    if w.is_now(0.3):
        random.shuffle(loose)
    names = ("alpha", "beta", "gamma")[: random.choice((0, 0, 1, 1, 2, 3))]
    variants = [
        braces(f"variant {n}{title(w)}", [] if w.is_now(0.05) else changes(w, turns)) for n in names
    ]
    text = game(f"base{title(w)}", sections + loose + variants)
    if w.is_now(0.15):
        files["base.sj"] = text
        text = game(
            f'above{title(w)} extends "base.sj"', [] if w.is_now(0.2) else [changes(w, turns)]
        )
    return Program(text, files, tuple(names))


# One number makes a whole program: parts of its text are left out to make it small (reduce.py), not of what Hypothesis drew.
programs: st.SearchStrategy[Program] = st.integers(0, 2**32 - 1).map(
    lambda seed: program(Random(seed))
)


def title(w: World) -> str:
    return ' "A game of chance"' if w.is_now(0.5) else ""


def game(head: str, sections: list[Lines]) -> str:
    return "\n".join(
        ["sj 1", f"game {head} {{", *(line for s in sections for line in indented(s)), "}", ""]
    )


def requires(w: World) -> None:
    """Pairs of params of which one is surely not larger, and sometimes a table that makes a dilemma."""
    for sign in ("<=", "<"):
        if w.is_now(0.3):
            unit = w.random.choice(("count", "steps"))
            low, high = f"lower_{len(w.requires)}", f"upper_{len(w.requires)}"
            type_ = ir.Type(kind="int", unit=unit, low=0, high=9)
            w.params += [
                Number(low, type_, f"param {low} : {unit} = 2 in 0 .. 9"),
                Number(high, type_, f"param {high} : {unit} = 5 in 0 .. 9"),
            ]
            w.requires.append(f"{low} {sign} {high}")
    two = [s for s in w.word_sets if len(s) == 2]
    if two and w.is_now(0.3):
        a, b = two[0]
        name, (r, s, t, p) = w.random.choice(
            (
                ("prisoners_dilemma", (3, 0, 5, 1)),
                ("stag_hunt", (4, 0, 3, 1)),
                ("chicken", (3, 1, 5, 0)),
            )
        )
        text = f"param dilemma : reward = {{ {a}: {{ {a}: {r}, {b}: {s} }}, {b}: {{ {a}: {t}, {b}: {p} }} }}"
        w.params.append(
            Number(
                "dilemma",
                ir.Type(kind="real", unit="reward", indexed_by=(IndexSet("word", two[0]),) * 2),
                text,
            )
        )
        w.dilemmas.append(name)


def define(w: World) -> None:
    """Adds a define: a number or a condition, with or without parameters."""
    r = w.random
    name = f"so_{chr(97 + len(w.defines))}"
    scope, parameters, names = Scope(w, "define"), [], []
    for _ in range(r.choice((0, 0, 1, 1, 2))):
        one = w.variable()
        names.append(one)
        match r.choice(("agent", "cell", "word", "number")):
            case "agent":
                scope = scope.having(Variable(one))
                parameters.append("agent")
            case "cell":
                kind = r.choice(list(w.kinds))
                scope = scope.having(Variable(one, (kind,)))
                parameters.append((kind,))
            case "word":
                type_ = ir.Type(kind="word", words=r.choice(w.word_sets))
                scope = replace(scope, parameters=(*scope.parameters, (one, type_)))
                parameters.append(type_)
            case _:
                type_ = ir.Type(kind="int", unit="count", low=0, high=9)
                scope = replace(scope, parameters=(*scope.parameters, (one, type_)))
                parameters.append(type_)
    match r.choice(("condition", "int", "real")):
        case "condition":
            text, type_ = condition(scope, 2), ir.CONDITION
        case "int":
            text, type_ = integer(scope, r.choice(("count", "steps", "cells")), 2)
        case _:
            text, type_ = real(scope, r.choice(("reward", "probability", "fraction")), 2)
    given = f"({', '.join(names)})" if names else ""
    w.defines.append(Define(name, tuple(parameters), type_, f"define {name}{given} = {text}"))


def _episode(w: World) -> Lines:
    lengths = [p.name for p in w.params if p.type.unit == "steps" and not p.type.indexed_by]
    length = w.random.choice(("200", "25", *lengths))
    fields = [f.name for f in w.fields] + [f"agent.{f.name}" for f in w.agent_fields]
    fields += [
        f"{owner}.{f.name}"
        for owner, kind in (*w.kinds.items(), *w.movers.items())
        for f in kind.fields
    ]
    # Drawn from the names, so that all else of the program is as without trials.
    random = Random(" ".join(fields))
    if random.random() > SHARE_WITH_TRIALS:
        return [f"episode {length}"]
    kept = random.sample(fields, random.randint(0, min(3, len(fields))))
    keep = f" {{ keep {', '.join(kept)} }}" if kept else ""
    return [f"episode {random.randint(1, 4)} trials of {random.choice((4, 9, length))}{keep}"]


def _task(w: World) -> list[Lines]:
    """Declares a task in some programs, drawn from the names as trials are."""
    random = Random("task of " + " ".join(f.name for f in w.fields))
    if random.random() > SHARE_WITH_TRIALS:
        return []
    words = "{ clover, thistle, nettle }"
    fields = [
        f"field sown : {words}",
        f"field harvest by {words} : different {random.randint(-2, 0)} .. {random.randint(2, 5)}",
        f"field weeds by {random.randint(-1, 0)} .. 2 : {words}",
        f"field crop by {words} : 0 .. {random.randint(1, 300)}",
    ]
    declared = random.sample(fields, random.randint(1, 4))
    names = [field.split()[1] for field in declared]
    return [[f"task rules {{ {' '.join(declared)} }}"], *([text] for text in splits(names, random))]


def _kinds(w: World) -> list[Lines]:
    """Declares the kinds, with what they block."""
    made = []
    for kind in w.kinds.values():
        lines = [f.text for f in kind.fields] + kind.extra
        blockable = [s.text for s in w.shapes if s.blockable]
        if kind is not next(iter(w.kinds.values())) and w.is_now(0.35):
            what = w.random.choice(["agents", "agents", *w.movers, *blockable])
            more = [b for b in blockable if b != what]
            what += (
                f", {w.random.choice(more)}"
                if more and what not in w.movers and w.is_now(0.3)
                else ""
            )
            test = ""
            if w.is_now(0.5):
                scope = replace(
                    Scope(w, "block").having(Variable(kind.name, (kind.name,))),
                    bound=frozenset({kind.name, "agent"}),
                )
                if what in w.movers:
                    scope = replace(scope, bound=scope.bound | {what}).having(
                        Variable(what, sort=what)
                    )
                if what == "agents":
                    scope = scope.having(Variable("agent"))
                test = f" when {condition(scope, 1)}"
            lines.append(f"blocks {what}{test}")
        w.random.shuffle(lines)
        made.append(
            braces(f'kind {kind.name} "{kind.glyph}"', lines)
            if lines or w.is_now(0.1)
            else [f'kind {kind.name} "{kind.glyph}"']
        )
    return made


def movers(w: World) -> list[Lines]:
    """Declares the sorts of movers."""
    made = []
    for sort in w.movers.values():
        number = w.random.choice(
            [str(sort.cells), *(s.name for s in w.sizes if s.value == sort.cells)]
        )
        head = f'movers {sort.name} {number} "{sort.glyph}"'
        made.append(
            braces(head, [f.text for f in sort.fields]) if sort.fields or w.is_now(0.2) else [head]
        )
    return made


def _groups(w: World) -> Lines:
    return [f"group {n} = {', '.join(kinds)}" for n, kinds in w.groups.items()]


def _map(w: World, files: dict[str, str]) -> Lines:
    wraps = " wraps" if w.is_now(0.3) else ""
    if w.is_now(0.1):
        files["map.txt"] = "\n".join(w.rows) + "\n"
        return [f'map{wraps} "map.txt"']
    return [f"map{wraps} {{", *(f'  "{row}"' for row in w.rows), "}"]


def agents(w: World) -> Lines:
    """Declares the agents: actions, frame, fields, what is forbidden."""
    acts = [*w.actions, *(action.text for action in w.with_arguments)]
    w.random.shuffle(acts)
    lines = [f"acts {', '.join(acts)}"] + [f.text for f in w.agent_fields]
    if w.is_now(0.7):
        lines.append(f"moves {w.random.choice(('relative', 'compass'))}")
    open_ = [a for a in w.actions if a != "stay"]
    for _ in range(w.random.choice((0, 0, 1, 2)) if open_ else 0):
        some = (
            "all"
            if w.is_now(0.3)
            else ", ".join(sorted(w.random.sample(open_, w.random.randint(1, min(2, len(open_))))))
        )
        test = condition(Scope(w, "forbid").having(Variable("agent")), 2)
        if not any(line.startswith(f"forbid {some} when") for line in lines):
            lines.append(f"forbid {some} when {test}")
    ends = [s.text for s in w.shapes if s.blockable]
    if ends and w.is_now(0.3):
        test = condition(Scope(w, "forbid").having(Variable("agent")), 1)
        lines.append(f"blocks {w.random.choice(ends)}" + (f" when {test}" if w.is_now(0.5) else ""))
    lines += forbidden(w)
    number = str(w.agents)
    sizes = [s.name for s in w.sizes if s.value == w.agents]
    return braces(f"agents {w.random.choice([*sizes, number])}", lines)


def looks(w: World) -> Lines:
    """Says how some kinds, groups and the agents are drawn."""
    found = []
    for name in w.random.sample(["agent", *w.kinds, *w.groups], w.random.randint(0, 2)):
        fields = w.agent_fields if name == "agent" else w.cell_fields(w.kinds_of(name))
        words = [f for f in fields if f.type.kind == "word" and not f.type.indexed_by]
        test = ""
        if words and w.is_now(0.7):
            field = w.random.choice(words)
            test = f" where {name}.{field.name} {w.random.choice(('is', 'is not'))} {w.random.choice(field.type.words)}"
        paints = [
            w.random.choice(("apple", "red", "red apple", 'apple "#102030"', '"#AABBCC"'))
            for _ in range(2)
        ]
        form = w.random.choice(("as {}", "with {}", "as {} with {}"))
        found.append(f"look {name}{test} {form.format(*paints)}")
    return found


def more_agents(w: World) -> Lines:
    """Says nothing, or one more field, of the agents there are."""
    number = f" {w.random.randint(1, w.agents)}" if w.is_now(0.3) else ""
    return braces(
        f"agents{number}", [] if w.is_now(0.2) else [a_field(w, "extra_field", sets=False).text]
    )


def start(w: World) -> Lines:
    """Writes the phase that places everybody, on the first kind."""
    first = next(iter(w.kinds))
    scope = Scope(w, "start")
    facing = f" facing {w.random.choice(('north', 'same', 'east'))}" if w.is_now(0.4) else ""
    name = "agent" if w.is_now(0.7) else w.variable()
    body = [f"send {name} to {first}{facing}"]
    phase = Phase(Written(), marks=False)
    if w.is_now(0.4):
        from tests.fuzz.reading import Frame

        inner = replace(scope.having(Variable(name, (), 0, listed=True)), frames=(Frame(False),))
        body += block(inner, phase, 3)
    lines = braces("each agent" if name == "agent" else f"each agent as {name}", body)
    for sort in w.movers:
        lines += [
            f"each {sort} {{ send {sort} to {first}{w.random.choice(('', ' facing south', ' facing same'))} }}"
        ]
    if w.is_now(0.3):
        lines += block(scope, phase, 1)
    return braces("phase start", lines)


def starting(w: World) -> list[Lines]:
    """Returns phases that follow `start` when an episode begins."""
    phases = []
    for name in w.random.sample(STARTING, w.random.choice((0, 0, 0, 1, 2))):
        if w.movers and w.is_now(0.2):
            body = [_go(w, w.random.choice(list(w.movers)))]
        else:
            body = block(Scope(w, "beginning"), Phase(Written()), 0, least=w.random.choice((1, 2)))
        phases.append(braces(f"phase {name} at start", body))
    return phases


def schedule(w: World, begin: list[Lines]) -> tuple[list[str], list[Lines]]:
    """Returns the turns of a step and the phases they use. begin: those before the first step."""
    r = w.random
    turns, phases = [], []
    for name in r.sample(NAMES, r.randint(1, 4)):
        if name == "walk_on":
            turns.append(name)
            phases.append(braces(f"phase {name}", [_move(w)]))
            continue
        uses = parameters(w) if w.is_now(0.2) else [("", (), ())]
        names = [n for n, _ in uses[0][1]] if uses[0][1] else []
        scope = Scope(w, "phase", parameters=tuple(uses[0][1]))
        body = block(scope, Phase(Written()), 0, least=r.choice((1, 2)))
        phases.append(braces(f"phase {name}" + (f"({', '.join(names)})" if names else ""), body))
        turns += [f"{name}{arguments}" for arguments, *_ in uses]
    for sort in w.movers:
        if w.is_now(0.8):
            turns.insert(r.randint(0, len(turns)), f"let_{sort}_go")
            phases.append(braces(f"phase let_{sort}_go", [_go(w, sort)]))
    if _needs_tick(w, [*begin, *phases]):
        turns.insert(r.randint(0, len(turns)), "tick")
    elif w.is_now(0.1):
        turns.append("tick")
    return turns, phases


def parameters(w: World) -> list[tuple[str, tuple, tuple]]:
    """Returns the uses of a phase with parameters: the arguments of each, and what the parameters are."""
    words, name, number = w.random.choice(w.word_sets), w.variable(), w.variable()
    types = (
        (name, ir.Type(kind="word", words=words)),
        (number, ir.Type(kind="int", unit="number", low=0, high=3)),
    )
    uses = w.random.sample(words, w.random.randint(1, 2))
    if w.is_now(0.3):
        return [(f"({word})", types[:1], ()) for word in uses]
    params = [p for p in w.params if p.type.kind in ("int", "real", "word")]
    if params and w.is_now(0.6):  # a param, perhaps a whole table, in each use; all of one type
        type_ = w.random.choice(params).type
        low, high = type_.low, type_.high
        alike = [
            p.name
            for p in params
            if p.type.model_copy(update={"low": low, "high": high}) == type_
            and low <= p.type.low <= p.type.high <= high
        ]
        return [
            (f"({word}, {w.random.choice(alike)})", (types[0], (number, type_)), ())
            for word in uses
        ]
    return [(f"({word}, {w.random.randint(0, 3)})", types, ()) for word in uses]


def _move(w: World) -> str:
    text, *_ = domain(Scope(w, "phase"), 1, kind="agent")
    return f"move each {text}" if w.is_now(0.4) else "move each agent"


def _go(w: World, sort: str) -> str:
    """Returns how movers go in a phase of their own."""
    text, inner, _ = domain(Scope(w, "phase"), 1, kind=sort)
    avoiding = f" avoiding {domain(inner, 1)[0]}" if w.is_now(0.3) else ""
    match w.random.choice(("ahead", "along", "random", "toward", "toward", "away", "away")):
        case "ahead":
            return f"move each {text} ahead"
        case "along":
            agent = w.random.choice(HEADINGS)
            return f"move each {text} along {agent}"
        case "random":
            return f"move each {text} at random{avoiding}"
        case "toward":
            return f"move each {text} toward {domain(inner, 1)[0]}{avoiding}"
        case _:
            return f"move each {text} away from {domain(inner, 1)[0]}{avoiding}"


def _needs_tick(w: World, phases: list[Lines]) -> bool:
    fields = [
        *w.agent_fields,
        *w.fields,
        *(f for k in (*w.kinds.values(), *w.movers.values()) for f in k.fields),
    ]
    return any(f.timer for f in fields) or any(" after " in line for p in phases for line in p)


def changes(w: World, turns: list[str]) -> Lines:
    """Returns what a variant, or a game upon this one, says differently."""
    makers: list[Callable[[World], Lines]] = [
        _set,
        _set,
        _other_param,
        more_agents,
        _new_map,
        _dropped,
        _other_phase,
        _seen,
        looks,
        _other_policy,
    ]
    lines: Lines = []
    for make in w.random.sample(makers, w.random.randint(1, 3)):
        lines += make(w)
    if w.is_now(0.3) and len(turns) > 1 and "schedule" not in "".join(lines):
        lines.append(f"schedule {' -> '.join(w.random.sample(turns, len(turns)))}")
    return lines or ["episode 30"]


def _set(w: World) -> Lines:
    plain = [p for p in w.params if p.type.kind != "word" and not p.type.indexed_by]
    rows = [p for p in w.params if p.type.kind != "word" and len(p.type.indexed_by) == 1]
    value = {"reward": "1.25", "probability": "0.25", "fraction": "0.25"}
    if rows and w.is_now(0.5):
        row = w.random.choice(rows)
        return [
            f"set {row.name}[{w.random.choice(row.type.indexed_by[0].keys)}] = {value.get(row.type.unit, '2')}"
        ]
    if not plain:
        return []
    chosen = w.random.choice(plain)
    return [f"set {chosen.name} = {value.get(chosen.type.unit, '2')}"]


def _other_param(w: World) -> Lines:
    plain = [p for p in w.params if p.type.indexed_by and p.type.unit == "reward"]
    return [plain[0].text.split(" in ")[0]] if plain else [param(w, "extra").text]


def _new_map(w: World) -> Lines:
    rows = list(w.rows)
    w.random.shuffle(rows)
    return ["map wraps {" if w.is_now(0.3) else "map {", *(f'  "{row}"' for row in rows), "}"]


def _dropped(w: World) -> Lines:
    return [f"drop {w.defines[-1].name}"] if w.defines and w.is_now(0.3) else []


def _other_phase(w: World) -> Lines:
    first = next(iter(w.kinds))
    movers = [f"each {sort} {{ send {sort} to {first} }}" for sort in w.movers]
    return braces(
        "phase start",
        [
            *movers,
            f"each agent {{ send agent to {destination(Scope(w), first) if w.is_now(0.05) else first} facing west }}",
        ],
    )


def _other_policy(w: World) -> Lines:
    if w.policies and w.is_now(0.2):
        return [f"drop {w.policies[0]}"]
    return [line for lines in policies(w) for line in lines]


def _seen(w: World) -> Lines:
    return [
        w.random.choice(
            (
                "observe { window ahead 1, behind 2, left 1, right 0 }",
                "observe { }",
                "metrics { }",
                "checks { }",
            )
        )
    ]


__all__ = ["Program", "program", "programs"]
