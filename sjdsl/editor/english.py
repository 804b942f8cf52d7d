"""The English of one declared thing, as `sjdsl doc` says it: a phase, a define, a number, a field, an action."""

from collections.abc import Iterable, Iterator

from sjdsl.compiler import ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.doc.actions import action_rows
from sjdsl.doc.checks import metric_lines
from sjdsl.doc.defines import explained, vocabulary
from sjdsl.doc.entities import blocking, field_line
from sjdsl.doc.numbers import unit_of
from sjdsl.doc.statements import block
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import Line, bullets, code, table_value


def english(symbol: Symbol, game: ir.Game) -> list[str]:
    """Returns lines of Markdown about something of a game; none where its declaration says all."""
    v = vocabulary(game)
    match symbol.space:
        case "phase":
            return _phase(symbol.name, v)
        case "field":
            owners = {"agent": game.agents.fields} | {kind.name: kind.fields for kind in game.kinds}
            owners |= {sort.name: sort.fields for sort in game.movers}
            return _bullets(field_line(field) for field in owners.get(symbol.owner, ()) if field.name == symbol.name)
        case "action":
            return [meaning for _, name, meaning in action_rows(v) if name.strip("`").partition("(")[0] == symbol.name and meaning]
        case "metric":
            return _bullets(line for line in metric_lines(v) if line.text.startswith(f"{code(symbol.name)}:"))
        case "name":
            return _bullets(_named(symbol.name, v))
        case _:
            return []


def _bullets(lines: Iterable[Line]) -> list[str]:
    return list(bullets(list(lines)))


def _phase(name: str, v: Vocabulary) -> list[str]:
    if name == "start":
        return _bullets(block(v.game.start.body, v))
    turns = [t for t in v.game.schedule if isinstance(t, ir.Phase) and t.name == name]
    found: list[str] = []
    for turn in turns:
        found += [*([f"{code(turn.label)}:", ""] if len(turns) > 1 else []), *_bullets(block(turn.body, v)), ""]
    return found or ["No turn of the schedule runs it."]


def _named(name: str, v: Vocabulary) -> Iterator[Line]:
    """Yields what there is to say of a number, a define, a field of the world, a kind or a group."""
    game = v.game
    numbers: tuple[ir.Size | ir.Param, ...] = (*game.sizes, *game.params)
    for number in numbers:
        if number.name == name:
            yield Line(f"{code(name)} is {table_value(number.value, number.type.by)} ({unit_of(number)})")
    yield from (line for line in explained(v) if line.text.startswith(code(name)))
    yield from (field_line(field) for field in game.fields if field.name == name)
    for kind in game.kinds:
        if kind.name == name:
            cells = sum(row.count(g.glyph) for row in game.rows for g in game.glyphs if g.kind == name)
            yield Line(f"{cells} {'cell' if cells == 1 else 'cells'} of the map")
            yield from blocking(kind, v)
            yield from map(field_line, kind.fields)
    for group, kinds in game.groups:
        if group == name:
            yield Line(f"{code(name)} means {' or '.join(kinds)} cells")
