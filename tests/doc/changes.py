"""Small changes of what a sheet's tables say of a game, one node and one field at a time: each must show."""

from collections.abc import Iterator
from typing import Any

from sjdsl.compiler import ir

# What stands in tables, by class of node; all else is quoted from the file.
TABLED = {
    "Game": ("name", "title", "about", "cites", "rows", "edges"),
    "Agents": ("number", "actions", "relative"),
    "ActionWithArguments": ("name", "arguments"),
    "ActionArgument": ("name", "type"),
    "GlyphMeaning": ("glyph", "kind", "starts"),
    "Size": ("value",),
    "Param": ("value",),
    "Event": ("per_agent",),
    "Scenario": ("name", "title", "slots"),
    "Slots": ("number", "policy"),
    "Label": ("name",),
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


def others(value: Any, field: str, game: ir.Game) -> Iterator[Any]:
    """Yields other values that a field could have."""
    match value:
        case bool():
            yield not value
        case int() | float():
            yield value + 1
        case str() if field == "kind":
            yield from (kind.name for kind in game.kinds if kind.name != value)
        case str() if field == "edges":
            yield from {"", "joined"} - {value}
        case str():
            yield value + "x"
        case ir.Type(kind="word"):
            yield value.model_copy(update={"words": value.words[::-1]})
        case ir.Type(kind="int"):
            yield value.model_copy(update={"high": value.high + 1})
        case tuple() if value:
            yield value[:-1]
            if len(value) > 1 and value[0] != value[-1]:
                yield (value[-1], *value[1:-1], value[0])


def is_shown(node: ir.Node, field: str, game: ir.Game) -> bool:
    match node, field:
        case ir.Agents(), "relative":  # says where the moves lead
            return (
                any(isinstance(n, ir.Move) and n.course is None for n in ir.walk(game))
                and "forward" in node.actions
            )
        case (
            ir.Agents(),
            "actions",
        ):  # else they follow from those with arguments, whose own parts are changed
            return not node.with_arguments
        case _:
            return True


def small_changes(
    game: ir.Game, tried: dict[tuple[str, str], int]
) -> Iterator[tuple[str, str, list[ir.Game]]]:
    """Yields the game with one part of its tables changed in every way: (class, field, games); for a few nodes of each class."""
    for path, node in places(game):
        sort = type(node).__name__
        for field in TABLED.get(sort, ()):
            found = [
                node.model_copy(update={field: other})
                for other in others(getattr(node, field), field, game)
            ]
            if found and tried.get((sort, field), 0) < EACH and is_shown(node, field, game):
                tried[sort, field] = tried.get((sort, field), 0) + 1
                yield sort, field, [replaced(game, path, new) for new in found]
