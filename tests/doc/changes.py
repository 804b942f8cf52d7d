"""Small changes of a game's rules, one node and one field at a time: what a sheet must show."""

from collections import Counter
from collections.abc import Iterator
from typing import Any, Literal, get_args, get_origin

from sjdsl.compiler import ir
from sjdsl.compiler.ir.operations import CALCULATIONS, PAYOFF_CLASSES

# Fields that are no part of the rules: positions, types that follow from the rest, numbers of streams, and what is said twice.
SILENT = {
    "*": {"origin", "type", "stream"},
    "Send": {"pool", "order_stream", "heading_stream"},  # a pool is the destination as written
    "Shift": {"heading_stream"},
    "Phase": {"name", "marks"},  # the label as an identifier; the shapes that its sentences mark
    "FieldRead": {"held_by"},  # follow from the owner
    "Kind": {"glyph"},  # also the first of its glyphs
    "VarField": {"held_by"},  # where it stands
    "Game": {"variants"},  # their titles are not in the rules
    "Look": {"what", "name"},  # follow from what it is of
    "Narrowed": {"value"},
    "Pick": {"most"},  # follows from the type of its number
    "Shape": {"see_through"},  # a shape without a direction is
    "ArgumentOf": {"number"},  # follows from the name
    "Set": {"lot"},  # the number of a stream
    "Agents": {"with_arguments"},  # changed by their own parts
}

# Tuples whose order numbers things for observations and draws, and means nothing else.
ORDERLESS = {
    ("Forbid", "actions"),
    *(("Game", name) for name in ("kinds", "glyphs", "about", "observables", "hidden", "policies", "shapes", "policy_shapes")),
    ("Shape", "lanes"),
}

EACH = 2  # nodes of a class of which a field is changed

Path = tuple[tuple[str, int], ...]  # (field, place in its tuple or -1), outermost first


def places(node: ir.Node, path: Path = ()) -> Iterator[tuple[Path, ir.Node]]:
    """Yields every node of a game with the way to it."""
    yield path, node
    for name in type(node).model_fields:
        value = getattr(node, name)
        if isinstance(value, ir.Node):
            yield from places(value, (*path, (name, -1)))
        elif isinstance(value, tuple):
            for i, item in enumerate(value):
                if isinstance(item, ir.Node):
                    yield from places(item, (*path, (name, i)))


def replaced(node: ir.Node, path: Path, new: ir.Node) -> Any:
    """Returns the game with another node at the end of the way."""
    if not path:
        return new
    (name, place), rest = path[0], path[1:]
    value = getattr(node, name)
    if place < 0:
        return node.model_copy(update={name: replaced(value, rest, new)})
    items = (*value[:place], replaced(value[place], rest, new), *value[place + 1 :])
    return node.model_copy(update={name: items})


def without_origins(node: ir.Node) -> Any:
    """Returns rules that know nothing of their text."""
    changed: dict[str, Any] = {"origin": None}
    for name in type(node).model_fields:
        old = getattr(node, name)
        if isinstance(old, ir.Node):
            changed[name] = without_origins(old)
        elif isinstance(old, tuple):
            changed[name] = tuple(without_origins(o) if isinstance(o, ir.Node) else o for o in old)
    return node.model_copy(update=changed)


def fields_of(path: Path, node: ir.Node, game: ir.Game) -> Iterator[str]:
    """Yields the fields of a node whose change changes the rules."""
    silent = SILENT["*"] | SILENT.get(type(node).__name__, set())
    for name in type(node).model_fields:
        if name not in silent and _matters(path, node, name, game):
            yield name
    if isinstance(node, ir.VarField):
        yield "type"


def _matters(path: Path, node: ir.Node, name: str, game: ir.Game) -> bool:
    match node, name:
        case ir.Agents(), "relative":
            return any(isinstance(n, ir.Move) for n in ir.walk(game))
        case ir.Phase(), "label":
            return path[-1][0] != "start"
        case ir.Member(), "sort":
            return path[-1][0] in ("var", "on")  # elsewhere they follow from the name
        case ir.Hidden(), "on":
            return node.what == "marks"  # what else is hidden is where an agent stands
        case ir.Agents(), "actions":
            return not node.with_arguments  # its actions follow from those with arguments, whose own parts are changed
        case ir.Forbid(), "actions":
            return not node.action  # they follow from its arguments
        case ir.Act() | ir.Aim(), "action":
            return not node.chosen  # likewise
        case ir.Case(), "arms":
            return node.subject.type.kind != "condition"  # `yes` and `no` in either order
        case ir.Wander(), "away":
            return node.goal is not None
        case ir.Logic(), "args":
            return not any(
                isinstance(part, ir.Chose | ir.ChoseWith) for part in node.args
            )  # told of the member it is about, whatever comes first
        case ir.Check(), "episodes":
            return node.sort == "expect"
        case _:
            return True


def changed_nodes(node: ir.Node, name: str, game: ir.Game) -> Iterator[ir.Node]:
    """Yields the node with other values of one field."""
    value = getattr(node, name)
    if name == "type":
        others = _other_types(value)
    elif (type(node).__name__, name) in ORDERLESS:
        others = iter([value[:-1]] if len(value) > 1 else [])
    elif isinstance(node, ir.Arithmetic):
        given = ((fn, node.args) for fn in CALCULATIONS) if name == "fn" else ((node.fn, args) for args in _other_tuples(value))
        takes = ((fn, args) for fn, args in given if CALCULATIONS[fn].least <= len(args) <= CALCULATIONS[fn].most)
        others = (fn if name == "fn" else args for fn, args in takes if (fn, args) != (node.fn, node.args))
    elif isinstance(node, ir.MatrixClass) and name == "name":
        others = (other for other in PAYOFF_CLASSES if other != value)
    else:
        others = _others(value, type(node).model_fields[name].annotation, name, game)
    for other in others:
        yield node.model_copy(update={name: other})


def swapped_nodes(node: ir.Node) -> Iterator[ir.Node]:
    """Yields the node with two of the nodes inside it in each other's place."""
    names = [n for n in type(node).model_fields if isinstance(getattr(node, n), ir.Node)]
    for i, one in enumerate(names):
        for two in names[i + 1 :]:
            if getattr(node, one) != getattr(node, two):
                yield node.model_copy(update={one: getattr(node, two), two: getattr(node, one)})


def _other_types(type_: ir.Type) -> Iterator[ir.Type]:
    match type_.kind:
        case "word":
            yield type_.model_copy(update={"words": type_.words[::-1]})
        case "int" if type_.high < 1e9:
            yield type_.model_copy(update={"low": type_.low - 1})
            yield type_.model_copy(update={"high": type_.high + 1})
        case "agent":
            yield ir.AGENTS


def _others(value: Any, annotation: Any, name: str, game: ir.Game) -> Iterator[Any]:
    words = [w for part in (annotation, *get_args(annotation)) if get_origin(part) is Literal for w in get_args(part)]
    if words:
        yield from (w for w in words if w != value)
        return
    match value:
        case bool():
            yield not value
        case int() if name == "action":
            yield (value + 1) % len(game.agents.actions)
        case int() | float():
            yield value + 1
        case str() if value:
            yield value + "x"
        case ir.Sort():
            yield from (other for other in (ir.Sort("agent"), ir.Sort("mover", ("calf",)), ir.Sort("cell", ("pond",))) if other != value)
            yield from (ir.Sort(value.what, names) for names in _other_tuples(value.names) if names)
        case ir.Level():
            yield from (ir.Level(value.sort, names) for names in _other_tuples(value.names) if names)
        case ir.Entry():
            yield ir.Entry(ir.Level(value.level.sort, (*value.level.names, f"{value.name}x")), len(value.level))
        case ir.Node():
            if type(None) in get_args(annotation):
                yield None
        case tuple() if value:
            yield from _other_tuples(value)


def _other_tuples(value: tuple) -> Iterator[tuple]:
    yield value[:-1]
    if len(value) > 1 and value[0] != value[-1]:
        yield (value[-1], *value[1:-1], value[0])


def small_changes(game: ir.Game, tried: Counter[tuple[str, str]]) -> Iterator[tuple[str, str, list[ir.Game]]]:
    """Yields the game with one part of its rules changed in every way: (class, field, games); for a few nodes of each class."""
    for path, node in places(game):
        sort = type(node).__name__
        wanted = [field for field in (*fields_of(path, node, game), "two nodes") if tried[sort, field] < EACH]
        for field in wanted:
            new = swapped_nodes(node) if field == "two nodes" else changed_nodes(node, field, game)
            found = [replaced(game, path, other) for other in new]
            if found:
                tried[sort, field] += 1
                yield sort, field, found
