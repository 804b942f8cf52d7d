"""Names masks and compared values after their rules: `rock.ore is iron` is `is_iron`."""

import re

from sjdsl.compiler import ir
from sjdsl.compiler.ir.operations import COMPARISONS
from sjdsl.compiler.ir.queries import action_named

LONGEST = 28  # characters of a name that is put together


def condition_name(e: ir.Expr | None, game: ir.Game) -> str:
    """Returns a name for where a condition holds: `is_iron` for `rock.ore is iron`.

    It is empty if there is no short one. A name of conditions that `and` joins has as many of them
    as fit.
    """
    match e:
        case ir.Named():
            return _fitting(e.name)
        case ir.Logic():
            return _joined(e.fn, [condition_name(part, game) for part in e.args])
        case ir.Not(value=ir.IsEmpty(container=container)):
            return _fitting("has", value_name(container))
        case ir.Not(value=ir.Same(left=left, right=ir.Nobody())):
            return _fitting("has", value_name(left))
        case ir.Not(value=ir.Same(left=left, right=right)) if not isinstance(right, ir.Word):
            return _fitting(value_name(left), "is_not", value_name(right))
        case ir.Not(value=ir.Unoccupied()):
            return "covered"
        case ir.Not(value=value):
            positive = condition_name(value, game)
            return _fitting("not", positive.removeprefix("is_"))
        case ir.IsEmpty(container=container):
            return _fitting("no", value_name(container))
        case ir.Unoccupied():
            return "uncovered"
        case ir.StandsOn(kinds=kinds):
            return _fitting("on", "_or_".join(kinds))
        case ir.StandsAt(cell=cell):
            return _fitting("on", cell.name)
        case ir.Chose():
            return _fitting("chose", game.agents.actions[e.action])
        case ir.ChoseWith():
            return _fitting("chose", action_named(game, e.action).name)
        case ir.Same(right=ir.Word(value=word)):
            return _fitting("is", word)
        case ir.Same(left=left, right=ir.Nobody()):
            return _fitting("no", value_name(left))
        case ir.Same(left=left, right=right):
            return _fitting(value_name(left), "is", value_name(right))
        case ir.Compare(fn=fn, left=left, right=right):
            return _fitting(value_name(left), COMPARISONS[fn].named, value_name(right))
        case ir.InWords(words=words):
            return _fitting("is", "_or_".join(words))
        case ir.InSet(container=container):
            return _fitting("in", value_name(container))
        case None:
            return ""
        case _:
            return value_name(e)


def domain_name(d: ir.Domain, game: ir.Game) -> str:
    """Returns a name for a domain's mask: `on_orchard_and_is_ripe`; empty without a short one."""
    parts = [] if d.on is None else [_fitting("on", "_or_".join(d.on.kinds))]
    match d.restriction:
        case ir.Near(shape=shape):
            parts.append(_fitting(d.var.name, "in", shape.partition("(")[0]))
        case ir.InAgents(value=value):
            parts.append(_fitting("in", value_name(value)))
        case _:
            pass
    return _joined("and", [*parts, condition_name(d.where, game)])


def value_name(e: ir.Expr) -> str:
    """Returns a name for a value; nothing if it has no short one."""
    match e:
        case (
            ir.Member() | ir.Local() | ir.ParamRef() | ir.Named() | ir.FieldRead() | ir.Attribute()
        ):
            return _fitting(e.name)
        case ir.Word():
            return _fitting(e.value)
        case ir.Number(value=int(number)) if number >= 0:
            return str(number)
        case ir.Nobody() | ir.Nowhere():
            return type(e).__name__.lower()
        case ir.Step():
            return "step"
        case ir.At(row=row, key=key):
            return _fitting(value_name(row), value_name(key))
        case ir.Narrowed(value=value):
            return value_name(value)
        case _:
            return ""


def _fitting(*parts: str) -> str:
    """Returns parts of a name joined by `_`; empty if a part is, or the name is too long."""
    name = "_".join(parts).lower()
    is_short_name = len(name) <= LONGEST and re.fullmatch(r"[a-z][a-z0-9_]*", name)
    return name if all(parts) and is_short_name else ""


def _joined(conjunction: str, names: list[str]) -> str:
    """Returns the names of all conditions joined by `or`, or those that fit joined by `and`.

    A name that is empty is of a condition without a short one.
    """
    joined = ""
    for name in names:
        longer = f"{joined}_{conjunction}_{name}" if joined else name
        if name and len(longer) <= LONGEST:
            joined = longer
        elif conjunction == "or":
            return ""
    return joined
