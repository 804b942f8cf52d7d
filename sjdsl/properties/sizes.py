"""The sizes of a game that a check may depend on, and the game in each of these sizes that its file allows."""

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
    """Returns the game in every combination of the sizes that a check may depend on; None if there are too many, or no end to them.

    What the compiler refuses, as a `require` does, is left out; but not if it might take that in yet other sizes.
    """
    names = _read(family.composition, check)
    sizes = {
        name: _values(declared)
        for name, declared in family.composition.constants.items()
        if declared.is_size and name in names
    }
    known = [found for found in sizes.values() if found is not None]
    if len(known) < len(sizes) or prod(map(len, known)) > MOST:
        return None
    built = [
        family.in_sizes(dict(zip(sizes, chosen, strict=True)))
        for chosen in (product(*known) if sizes else ())
    ]
    others = any(
        declared.is_size and name not in names
        for name, declared in family.composition.constants.items()
    )
    return None if None in built and others else [game for game in built if game is not None]


def _values(size: ast.Constant) -> range | None:
    """Returns the numbers that a size may be set to."""
    match size:
        case ast.Constant(
            unit=ast.Name(text=unit), low=ast.Int(value=low), high=ast.Int(value=high)
        ) if unit in INTEGER_UNITS:
            return range(low, high + 1)
        case _:
            return None


def _read(composition: Composition, check: ir.Check) -> set[str]:
    """Returns the names in a check and, further, in the declarations of these names."""
    declared: dict[str, list[Node]] = {}
    tables = (
        composition.constants,
        composition.defines,
        composition.fields,
        composition.kinds,
        composition.groups,
    )
    for table in (
        *tables,
        composition.shapes,
        composition.movers,
        composition.metrics,
        composition.agent_fields,
    ):
        for name, node in table.items():
            declared.setdefault(name, []).append(node)
    declared["agent"] = declared["index"] = [
        node for node in (composition.number,) if node is not None
    ]
    written = [
        c for checks in composition.checks.values() for c in checks if c.span == check.origin
    ]
    found, waiting = set[str](), list[Node](written)
    while waiting:
        nodes = list(walk(waiting.pop()))
        types = {
            id(node.name) for node in nodes if isinstance(node, ast.NamedType)
        }  # that a field holds an agent says no number
        new = {
            node.text for node in nodes if isinstance(node, ast.Name) and id(node) not in types
        } - found
        found |= new
        waiting += [node for name in new for node in declared.get(name, ())]
    return found
