"""Alpha-equivalence of expressions.

A normal form that two share if they differ only in the names of bound variables.

Alpha-equivalence: positions, types, and the defines and guards an expression has come through do
not matter either. What does: whether numbers are computed and compared exactly, as whole numbers,
or as reals: `n > 16777216` and `n > 16777216.0` are two conditions.
"""

from collections.abc import Mapping
from functools import cache
from typing import Any

from sjdsl.compiler.diagnostics.tree import children
from sjdsl.compiler.ir.expressions import (
    Count,
    Domain,
    Extreme,
    FieldRead,
    Local,
    Member,
    Named,
    Narrowed,
    Number,
    Sum,
    is_expression,
)
from sjdsl.compiler.ir.node import Node

Form = tuple[Any, ...]
# What stands for some variables: for bound ones, how many are bound around them.
Names = Mapping[str, object]
# By the `id` of an expression, which is kept with its form, so that no other gets its `id`.
Memo = dict[int, tuple[Node, Form]]
NONE: Names = {}


def form(e: Node, names: Names = NONE, memo: Memo | None = None) -> Form:
    """Returns what is compared of an expression.

    names: what stands for its free variables instead of their own names. memo: the forms under
    these names that are known, to which new ones are added: for whoever asks for the forms of an
    expression and of its parts.
    """
    if memo is None:
        return _compute_form(e, names, None)
    if id(e) not in memo:
        memo[id(e)] = e, _compute_form(e, names, memo)
    return memo[id(e)][1]


def _compute_form(e: Node, names: Names, memo: Memo | None) -> Form:
    """Returns `form(e, names, memo)`, computed anew."""
    match e:
        case Member() | Local():
            return ("variable", names.get(e.name, e.name))
        case Number():
            return ("number", e.value)
        case FieldRead():
            return ("field", e.name, None if e.owner is None else form(e.owner, names, memo))
        case Named() | Narrowed():
            return form(e.value, names, memo)
        case Count():
            domain, _ = _form_of_domain(e.domain, names)
            return ("count", domain)
        case Sum():
            domain, inner = _form_of_domain(e.domain, names)
            return ("sum", domain, form(e.value, inner))
        case Extreme():
            domain, inner = _form_of_domain(e.domain, names)
            return (
                e.fn,
                e.type.kind,
                domain,
                form(e.value, inner),
                _form_of_part(e.otherwise, names, memo),
            )
        case _:
            parts = (
                _form_of_part(getattr(e, name), names, memo) for name in _compared_fields(type(e))
            )
            return (type(e), is_exact(e), *parts)


def is_exact(e: Node) -> bool:
    """Returns whether no real is computed, and none is compared.

    A whole number beside a real is rounded to float32.
    """
    parts = (e, *children(e))
    return all(part.type.kind != "real" for part in parts if is_expression(part))


def _form_of_part(value: object, names: Names, memo: Memo | None) -> object:
    """Returns the form of a field of a node: of a node, of all nodes of a tuple, or as it is."""
    if isinstance(value, Node):
        return form(value, names, memo)
    if isinstance(value, tuple):
        return tuple(_form_of_part(part, names, memo) for part in value)
    return value


def _form_of_domain(d: Domain, names: Names) -> tuple[Form, Names]:
    """Returns the form of a domain, and what stands for the variables inside it."""
    inner = {**names, d.var.name: len(names)}
    kinds_on = None
    if d.on is not None:
        inner[d.on.name] = len(names) + 1
        kinds_on = d.on.kinds
    restriction = None if d.restriction is None else form(d.restriction, names)
    where = None if d.where is None else form(d.where, inner)
    return (d.var.entity_type, kinds_on, restriction, where), inner


@cache
def _compared_fields(kind: type[Node]) -> tuple[str, ...]:
    return tuple(name for name in kind.model_fields if name not in ("origin", "type"))
