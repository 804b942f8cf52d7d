"""Differences between two games or variants: in numbers where there are numbers, otherwise in sentences."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

from sjdsl.compiler import ir
from sjdsl.doc.actions import declared, forbidden
from sjdsl.doc.changes import Change, Section, by_name, texts, whole_texts
from sjdsl.doc.checks import check_line, episode, metric_lines
from sjdsl.doc.defines import explained, vocabulary
from sjdsl.doc.entities import blocking, field_line, lane_ends, starts
from sjdsl.doc.numbers import limits_of, unit_of
from sjdsl.doc.observation import seen, unseen_fields, views
from sjdsl.doc.pictures import picture_lines
from sjdsl.doc.policies import policy_lines, scenario_line
from sjdsl.doc.shapes import shape_lines
from sjdsl.doc.statements import block, turn_lines
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import Line, table_value
from sjdsl.doc.written import Written

FRAMES = {True: "relative to the heading", False: "by the compass"}


def differences(old: Written, new: Written) -> tuple[Section, ...]:
    """Returns the parts of the rules in which two games differ; nothing if they are the same game in other words or places."""
    a, b = (vocabulary(w.game, values=False) for w in (old, new))
    sections = (
        ("Description", _description(old.game, new.game)),
        ("Numbers", _numbers(old, new)),
        ("Map", _map(old.game, new.game)),
        ("Agents", _agents(a, b)),
        ("Movers", _movers(a, b)),
        ("Kinds of cell", _kinds(a, b)),
        ("Shapes", _shapes(a, b)),
        ("State of the world", _lines("fields", a.game.fields, b.game.fields)),
        ("Names", texts("names", explained(a), explained(b))),
        ("Initialisation", texts("start", block(a.game.start.body, a), block(b.game.start.body, b))),
        ("Schedule", _schedule(a.game, b.game)),
        ("Phases", _phases(a, b)),
        ("Observation", _observation(a, b)),
        ("Episode", texts("episode", episode(a), episode(b))),
        ("Metrics", texts("metrics", metric_lines(a), metric_lines(b))),
        ("Checks", texts("checks", [check_line(c, a) for c in a.game.checks], [check_line(c, b) for c in b.game.checks])),
        ("Policies", _policies(a, b)),
        ("Scenarios", texts("scenarios", *(list(map(scenario_line, v.game.scenarios)) for v in (a, b)))),
        ("Pictures", texts("pictures", picture_lines(a), picture_lines(b))),
    )
    return tuple(Section(title, tuple(changes)) for title, changes in sections if changes)


def _description(old: ir.Game, new: ir.Game) -> list[Change]:
    about = [{"name": g.name, "title": g.title, **dict(g.about)} for g in (old, new)]
    cites = [{f"source {i}": text for i, text in enumerate(g.cites, 1)} for g in (old, new)]
    return [*by_name(about), *by_name(cites)]


def _numbers(old: Written, new: Written) -> list[Change]:
    """Returns numbers with another default, entry by entry; other units, limits, and whether they are fixed when compiled."""
    mine, theirs = _declared(old.game), _declared(new.game)
    found: list[Change] = []
    for name in mine | theirs:
        a, b = mine.get(name), theirs.get(name)
        if a and b:
            found += by_name([dict(_entries(name, n.value, n.type.by)) for n in (a, b)], unit_of(b))
            facts = [
                {
                    f"{name}, unit": unit_of(n),
                    f"{name}, may be": limits_of(n, w),
                    f"{name}, can be changed": "before compiling" if isinstance(n, ir.Size) else "at any time",
                }
                for n, w in ((a, old), (b, new))
            ]
            found += by_name(facts)
        elif a:
            found.append(Change(name, old=a.value, shown=(_shown(a, old), ""), unit=unit_of(a)))
        elif b:
            found.append(Change(name, new=b.value, shown=("", _shown(b, new)), unit=unit_of(b)))
    return found


def _declared(game: ir.Game) -> dict[str, ir.Size | ir.Param]:
    return {s.name: s for s in game.sizes} | {p.name: p for p in game.params}


def _shown(declared: ir.Size | ir.Param, w: Written) -> str:
    return f"{table_value(declared.value, declared.type.by)} (may be {limits_of(declared, w)})"


def _entries(name: str, value: Any, by: tuple[ir.Level, ...]) -> list[tuple[str, Any]]:
    """Returns a number by its name, the entries of a table each by its own: `spores[red][green]`."""
    if not by:
        return [(name, value)]
    return [pair for key, v in zip(by[0].keys, value, strict=True) for pair in _entries(f"{name}[{key}]", v, by[1:])]


def _map(old: ir.Game, new: ir.Game) -> list[Change]:
    sizes = [f"{len(g.rows)} rows of {len(g.rows[0])} cells" for g in (old, new)]
    cells = [_cells(g) for g in (old, new)]
    found = by_name({"size": size} for size in sizes)
    found += by_name({"edges": "joined" if g.wraps else "walls nobody passes"} for g in (old, new))
    counts = [Counter(kind for row in rows for kind in row) for rows in cells]
    found += by_name({f"cells of {what}": number for what, number in count.items()} for count in counts)
    if sizes[0] == sizes[1]:
        same = sum(a == b for rows in zip(*cells, strict=True) for a, b in zip(*rows, strict=True))
        found += by_name({"cells of the same kind and state": n} for n in (sum(map(len, cells[0])), same))
    return found


def _cells(game: ir.Game) -> list[list[str]]:
    """Returns what stands in each cell of the map: its kind, with the state at the start."""
    meaning = {g.glyph: f"{g.kind} ({starts(g, game)})" if starts(g, game) else g.kind for g in game.glyphs}
    return [[meaning[glyph] for glyph in row] for row in game.rows]


def _agents(a: Vocabulary, b: Vocabulary) -> list[Change]:
    old, new = a.game.agents, b.game.agents
    found = by_name({"number of agents": g.number} for g in (old, new))
    found += by_name(_action_numbers(g) for g in (old, new))
    if any(v.has(ir.Move) for v in (a, b)):
        found += by_name({"moves": FRAMES[g.relative]} for g in (old, new))
    found += _lines("fields", old.fields, new.fields)
    found += texts("lanes that end at agents", lane_ends(a), lane_ends(b))
    return found + texts("forbidden actions", forbidden(a), forbidden(b))


def _action_numbers(agents: ir.Agents) -> dict[str, int | str]:
    """Returns the number of each action, the first and the last of one with arguments."""
    numbers: dict[str, int | str] = {f"action {name}": i for i, name in enumerate(agents.actions)}
    for action in agents.with_arguments:
        for i in action.numbers:
            numbers.pop(f"action {agents.actions[i]}", None)
        numbers[f"action {declared(action)}"] = f"{action.first} to {action.numbers[-1]}"
    return numbers


def _schedule(old: ir.Game, new: ir.Game) -> list[Change]:
    """Returns the phases that only one game has, and as few others as have moved."""
    before, after = ([turn.label if isinstance(turn, ir.Phase) else "tick" for turn in game.schedule] for game in (old, new))
    found = [Change(f"phase {name}", old=before.index(name) + 1, shown=(_place(before, name), "")) for name in before if name not in after]
    found += [Change(f"phase {name}", new=after.index(name) + 1, shown=("", _place(after, name))) for name in after if name not in before]
    common = [name for name in after if name in before]
    stay = longest_rising([before.index(name) for name in common])
    for name in common:
        if before.index(name) not in stay:
            places = (_place(before, name), _place(after, name))
            found.append(Change(f"phase {name}", before.index(name) + 1, after.index(name) + 1, shown=places))
    return found


def longest_rising(numbers: Sequence[int]) -> list[int]:
    """Returns the longest part of different numbers that rises; of several the one that ends first."""
    best: list[list[int]] = []  # best[i]: the longest part that ends with numbers[i]
    for i, last in enumerate(numbers):
        before = max((part for part, n in zip(best, numbers[:i], strict=True) if n < last), key=len, default=[])
        best.append([*before, last])
    return max(best, key=len, default=[])


def _place(order: Sequence[str], name: str) -> str:
    """Returns `place 3, after walk`."""
    place = order.index(name)
    return f"place {place + 1}, " + (f"after {order[place - 1]}" if place else "at the beginning")


def _movers(a: Vocabulary, b: Vocabulary) -> list[Change]:
    facts = [
        {f"{sort.name}, {fact}": value for sort in v.game.movers for fact, value in (("number", sort.number), ("glyph", sort.glyph))}
        for v in (a, b)
    ]
    fields = [[f"each {sort.name}: {field_line(field)}" for sort in v.game.movers for field in sort.fields] for v in (a, b)]
    return by_name(facts) + texts("fields of movers", *fields)


def _lines(what: str, old: tuple[ir.VarField, ...], new: tuple[ir.VarField, ...]) -> list[Change]:
    return texts(what, list(map(field_line, old)), list(map(field_line, new)))


def _kinds(a: Vocabulary, b: Vocabulary) -> list[Change]:
    old, new = ({k.name: k for k in v.game.kinds} for v in (a, b))
    found: list[Change] = by_name({f"kind {name}": f"glyph {k.glyph}" for name, k in kinds.items()} for kinds in (old, new))
    for name in old | new:
        lines = [[*blocking(k[name], v), *map(field_line, k[name].fields)] if name in k else [] for k, v in ((old, a), (new, b))]
        found += texts(name, *lines)
    glyphs = [{f"glyph {g.glyph}": f"{g.kind} {starts(g, v.game)}".strip() for g in v.game.glyphs} for v in (a, b)]
    groups = [{f"group {name}": ", ".join(kinds) for name, kinds in v.game.groups} for v in (a, b)]
    return [*found, *by_name(glyphs), *by_name(groups)]


def _shapes(a: Vocabulary, b: Vocabulary) -> list[Change]:
    old, new = ({s.name: shape_lines(s) for s in v.shapes.values()} for v in (a, b))
    return [whole_texts(name, old.get(name, []), new.get(name, [])) for name in old | new if old.get(name) != new.get(name)]


def _phases(a: Vocabulary, b: Vocabulary) -> list[Change]:
    """Returns the phases whose sentences differ; one that only one of the games has differs in all of them."""
    old, new = (dict(turn_lines(v)) for v in (a, b))
    return [change for name in old | new for change in texts(name, old.get(name, ()), new.get(name, ()))]


def _policies(a: Vocabulary, b: Vocabulary) -> list[Change]:
    """Returns the policies with other titles or rules, in order; one that only one of the games has differs in all of them."""
    old, new = ({p.name: (p.title, policy_lines(p, v)) for p in v.game.policies} for v in (a, b))
    found = by_name({f"title of {name}": title for name, (title, _) in sides.items() if title} for sides in (old, new))
    return found + [change for name in old | new for change in texts(name, old.get(name, ("", []))[1], new.get(name, ("", []))[1])]


def _observation(a: Vocabulary, b: Vocabulary) -> list[Change]:
    sides = [{f"window {side}": getattr(v.game.window, side) for side in ("ahead", "behind", "left", "right")} for v in (a, b)]
    unseen = [[Line(text) for text in unseen_fields(v.game)] for v in (a, b)]
    own = [[Line(text) for text in views(v)] for v in (a, b)]
    return [*by_name(sides, unit="cells"), *texts("own window", *own), *texts("seen", seen(a), seen(b)), *texts("not seen", *unseen)]
