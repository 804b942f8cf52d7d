"""The English of `define`s: each is explained once, with placeholders for its free variables."""

from collections.abc import Iterator
from typing import Any, TypeVar

from sjdsl.compiler import ir
from sjdsl.doc.conditions import condition
from sjdsl.doc.expressions import value
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import Line, code, joined, variable

N = TypeVar("N", bound=ir.Node)
PLACEHOLDERS = "xyzuvw"


def vocabulary(game: ir.Game, values: bool = True) -> Vocabulary:
    """Returns the names of a game; a define counts as explained if all its uses say the same of what they are about."""
    bare = Vocabulary(game)
    forms: dict[str, set[str]] = {}
    for node in ir.walk(game):
        if isinstance(node, ir.Named):
            forms.setdefault(node.name, set()).add(_meaning(node, bare).text)
    return Vocabulary(game, frozenset(name for name, found in forms.items() if len(found) == 1), values)


def explained(v: Vocabulary) -> list[Line]:
    """Returns what each explained define means, in the order in which they are met."""
    found: dict[str, Line] = {}
    for node in ir.walk(v.game):
        if isinstance(node, ir.Named) and node.name in v.defined and node.name not in found:
            found[node.name] = _meaning(node, v)
    return list(found.values())


def _meaning(node: ir.Named, v: Vocabulary) -> Line:
    general, names = generalised(node)
    about = joined(f"{_noun(free, v)} {variable(x)}" for free, x in names) if names else ""
    name = code(node.name) + (f" of {about}" if about else "")
    if node.type.kind == "condition":
        return Line(f"{name} holds if {condition(general, v)}")
    return Line(f"{name} is {value(general, v)}")


def _noun(free: ir.Member | ir.Local, v: Vocabulary) -> str:
    return v.noun(free) if isinstance(free, ir.Member) else "a value"


def free_names(e: ir.Expr, v: Vocabulary) -> list[str]:
    """Returns what an expression is about: the variables that it reads and does not bind, in order of appearance."""
    return [v.refer(free) if isinstance(free, ir.Member) else variable(free.name) for free in free_variables(e)]


def free_variables(e: ir.Node) -> list[ir.Member | ir.Local]:
    found: dict[str, ir.Member | ir.Local] = {}
    for node in _free(e, frozenset()):
        found.setdefault(node.name, node)
    return list(found.values())


def _free(node: ir.Node, bound: frozenset[str]) -> Iterator[ir.Member | ir.Local]:
    if isinstance(node, ir.Count | ir.Sum):
        inner = bound | {m.name for m in (node.domain.var, node.domain.on) if m is not None}
        for child in ir.children(node.domain):
            if child not in (node.domain.var, node.domain.on):
                yield from _free(child, inner)
        if isinstance(node, ir.Sum):
            yield from _free(node.value, inner)
    elif isinstance(node, ir.Member | ir.Local):
        if node.name not in bound:
            yield node
    else:
        for child in ir.children(node):
            yield from _free(child, bound)


def generalised(node: ir.Named) -> tuple[ir.Expr, list[tuple[ir.Member | ir.Local, str]]]:
    """Returns a define's value with `x`, `y`, … for what it is about, and which variable stood for which of them."""
    free = free_variables(node.value)
    taken = {n.name for n in ir.walk(node.value) if isinstance(n, ir.Member | ir.Local)}
    letters = [c for c in PLACEHOLDERS if c not in taken]
    names = dict(zip((f.name for f in free), letters, strict=False))
    return renamed(node.value, names), [(f, names.get(f.name, f.name)) for f in free]


def renamed(node: N, names: dict[str, str]) -> N:
    """Returns a part of the rules with variables called differently."""
    changed: dict[str, Any] = {}
    if isinstance(node, ir.Member | ir.Local) and node.name in names:
        changed["name"] = names[node.name]
    for name in ir.inner_fields(type(node)):
        old = getattr(node, name)
        if isinstance(old, ir.Node):
            changed[name] = renamed(old, names)
        elif isinstance(old, tuple) and any(isinstance(o, ir.Node) for o in old):
            changed[name] = tuple(renamed(o, names) if isinstance(o, ir.Node) else o for o in old)
    return node.model_copy(update=changed) if changed else node
