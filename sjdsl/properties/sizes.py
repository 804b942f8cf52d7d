"""The game in all sizes that a check may depend on and that its file allows."""

from itertools import product
from math import prod

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.ir.types import INTEGER_UNITS
from sjdsl.properties.instances import GameFamily

MOST = 64  # games that are built for one check


def in_all_sizes(family: GameFamily, check: ir.Check) -> list[ir.Game] | None:
    """Returns the game in every combination of the sizes that a check may depend on.

    Games that the compiler refuses are left out. None if there are too many combinations or no end
    to them, or if a refused game may be allowed when other sizes change, too.
    """
    names = _names_read(family.composition, check)
    has_others = False
    sizes: dict[str, range] = {}
    for name, declared in family.composition.constants.items():
        if declared.is_size and name not in names:
            has_others = True
        elif declared.is_size:
            values = _values(declared)
            if values is None:
                return None
            sizes[name] = values
    if prod(map(len, sizes.values())) > MOST:
        return None
    games = []
    for chosen in product(*sizes.values()) if sizes else ():
        game = family.in_sizes(dict(zip(sizes, chosen, strict=True)))
        if game is not None:
            games.append(game)
        elif has_others:
            return None
    return games


def _values(size: ast.Constant) -> range | None:
    """Returns the numbers that a size may be set to; None if it has no limits."""
    match size:
        case ast.Constant(
            unit=ast.Name(text=unit), low=ast.Int(value=low), high=ast.Int(value=high)
        ) if unit in INTEGER_UNITS:
            return range(low, high + 1)
        case _:
            return None


def _names_read(composition: Composition, check: ir.Check) -> set[str]:
    """Returns the names in a check and, further, in the declarations of these names."""
    declared: dict[str, list[Node]] = {}
    for table in (
        composition.constants,
        composition.defines,
        composition.fields,
        composition.kinds,
        composition.groups,
        composition.shapes,
        composition.movers,
        composition.metrics,
        composition.agent_fields,
    ):
        for name, node in table.items():
            declared.setdefault(name, []).append(node)
    if composition.number is not None:
        # Whatever reads these depends on the number of agents.
        declared["agent"] = declared["index"] = [composition.number]
    waiting: list[Node] = []
    for checks in composition.checks.values():
        waiting += [tree for tree in checks if tree.span == check.origin]
    names: set[str] = set()
    while waiting:
        nodes = list(walk(waiting.pop()))
        # That a field holds an agent says nothing about their number.
        types = {id(node.name) for node in nodes if isinstance(node, ast.NamedType)}
        read = {node.text for node in nodes if isinstance(node, ast.Name) and id(node) not in types}
        for name in read - names:
            waiting += declared.get(name, ())
        names |= read
    return names
