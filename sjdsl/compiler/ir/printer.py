"""Prints the IR as stable text.

Expressions as an author would write them, whole games for `sjdsl dump`.
"""

from collections.abc import Iterator
from typing import assert_never

from sjdsl.compiler import ir
from sjdsl.compiler.ir.operations import CALCULATIONS


def number_text(value: float) -> str:
    """Returns the shortest text that reads back as the same number; integers without a point."""
    if isinstance(value, int) or (value == int(value) and abs(value) < 1e15):
        return str(int(value))
    return repr(float(value))


def expression_text(e: ir.Expr) -> str:
    """Returns an expression in the syntax of the language, without positions, fully bracketed."""
    match e:
        case ir.Number():
            return number_text(e.value)
        case ir.Word():
            return e.value
        case ir.Truth():
            return "yes" if e.value else "no"
        case ir.Nobody():
            return "nobody"
        case ir.Nowhere():
            return "nowhere"
        case ir.ParamRef() | ir.Member() | ir.Local():
            return e.name
        case ir.FieldRead() | ir.Attribute():
            return e.name if e.owner is None else f"{expression_text(e.owner)}.{e.name}"
        case ir.Distance():
            return f"distance({expression_text(e.left)}, {expression_text(e.right)})"
        case ir.Bearing():
            return f"{e.fn}({expression_text(e.left)}, {expression_text(e.right)})"
        case ir.At():
            return f"{expression_text(e.row)}[{expression_text(e.key)}]"
        case ir.Step():
            return "step"
        case ir.Arithmetic():
            operation = CALCULATIONS[e.fn]
            args = [expression_text(arg) for arg in e.args]
            if not operation.sign:
                return f"{operation.name}({', '.join(args)})"
            if len(args) == 1:
                return f"({operation.sign}{args[0]})"
            return f"({args[0]} {operation.sign} {args[1]})"
        case ir.Compare():
            return f"({expression_text(e.left)} {e.fn} {expression_text(e.right)})"
        case ir.Same():
            return f"({expression_text(e.left)} is {expression_text(e.right)})"
        case ir.InRange():
            interval = f"{expression_text(e.low)} .. {expression_text(e.high)}"
            return f"({expression_text(e.value)} in {interval})"
        case ir.InWords():
            return f"({expression_text(e.value)} in {{ {', '.join(e.words)} }})"
        case ir.InSet():
            return f"({expression_text(e.value)} in {expression_text(e.container)})"
        case ir.IsEmpty():
            return f"({expression_text(e.container)} is nobody)"
        case ir.Chose():
            return f"({expression_text(e.agent)} chose #{e.action})"
        case ir.ChoseWith():
            arguments = ", ".join(expression_text(given.value) for given in e.given)
            action = f"{e.action}({arguments})" if e.given else e.action
            return f"({expression_text(e.agent)} chose {action})"
        case ir.ArgumentOf():
            action = f"{expression_text(e.agent)}.{e.action}"
            return f"{action}.{e.name}" if e.name else action
        case ir.Unoccupied():
            return f"(nobody on {expression_text(e.cell)})"
        case ir.StandsOn():
            return f"({expression_text(e.agent)} on {' | '.join(e.kinds)})"
        case ir.StandsAt():
            return f"({expression_text(e.agent)} on {expression_text(e.cell)})"
        case ir.Not():
            return f"(not {expression_text(e.value)})"
        case ir.Logic():
            return f"({f' {e.fn} '.join(map(expression_text, e.args))})"
        case ir.Count():
            return f"count({domain_text(e.domain)})"
        case ir.Sum():
            return f"sum({expression_text(e.value)} over {domain_text(e.domain)})"
        case ir.SumRow():
            return f"{e.fn}({expression_text(e.row)})"
        case ir.ShiftRow():
            return f"shift({expression_text(e.row)}, {e.by}, {expression_text(e.filler)})"
        case ir.Lowest():
            return f"{'highest' if e.last else 'lowest'}({expression_text(e.row)})"
        case ir.Mix():
            return f"mix({expression_text(e.row)})"
        case ir.Extreme():
            otherwise = "" if e.otherwise is None else f" otherwise {expression_text(e.otherwise)}"
            return f"{e.fn}({expression_text(e.value)} over {domain_text(e.domain)}{otherwise})"
        case ir.Case():
            return (
                f"case {expression_text(e.subject)} {{ {', '.join(_arm_text(a) for a in e.arms)} }}"
            )
        case ir.Named() | ir.Narrowed():
            return expression_text(e.value)
        case ir.Before():
            return f"before({expression_text(e.value)})"
        case ir.EventTotal():
            return e.name if e.word is None else f"{e.name}[{e.word}]"
        case ir.MatrixClass():
            return f"{e.name}({expression_text(e.table)})"
        case _:
            assert_never(e)


def _arm_text(arm: ir.Arm) -> str:
    """Returns an arm of a `case`: `1..3: 0.5`, `ripe | rotten: 0`."""
    if arm.words:
        key = " | ".join(arm.words)
    elif arm.low == arm.high:
        key = str(arm.low)
    else:
        low = "" if arm.low is None else arm.low
        high = "" if arm.high is None else arm.high
        key = f"{low}..{high}"
    return f"{key}: {expression_text(arm.value)}"


def domain_text(d: ir.Domain) -> str:
    """Returns a domain in the syntax of the language; a group shows as its kinds."""
    parts = [d.var.entity_type.name, f"as {d.var.name}"]
    if d.on is not None:
        parts.append(f"on {' | '.join(d.on.kinds)} as {d.on.name}")
    match d.restriction:
        case ir.Near():
            parts.append(f"in {d.restriction.shape} of {d.restriction.anchor.name}")
        case ir.InAgents() | ir.InCell():
            parts.append(f"in {expression_text(d.restriction.value)}")
        case ir.Among():
            parts.append(f"in {{ {', '.join(m.name for m in d.restriction.members)} }}")
        case None:
            pass
    if d.where is not None:
        parts.append(f"where {expression_text(d.where)}")
    return " ".join(parts)


def game_text(g: ir.Game, positions: bool = False) -> str:
    """Returns the whole IR as indented text, one node or value a line.

    Two games are equal if and only if their texts are.
    """
    return "\n".join(_node_lines(g, "game", 0, positions)) + "\n"


def _node_lines(value: object, label: str, depth: int, positions: bool) -> Iterator[str]:
    """Yields the lines of a node, or of another value of a field, which `label` names."""
    pad = "  " * depth
    match value:
        case ir.Node() if ir.is_expression(value):
            position = _position_text(value, positions)
            yield f"{pad}{label}: {expression_text(value)}  : {_type_text(value.type)}{position}"
        case ir.Domain():
            yield f"{pad}{label}: {domain_text(value)}{_position_text(value, positions)}"
        case ir.Node():
            if isinstance(value, ir.Game):
                yield f"{pad}{label}"
            else:
                kind = type(value).__name__.lower()
                yield f"{pad}{label}: {kind}{_position_text(value, positions)}"
            for name in type(value).model_fields:
                if name != "origin":
                    yield from _node_lines(getattr(value, name), name, depth + 1, positions)
        case ir.Type():
            yield f"{pad}{label}: {_type_text(value)}"
        case ir.Entry():
            yield f"{pad}{label}: {value.name!r}"
        case ir.IndexSet():
            yield f"{pad}{label}: {value.names!r}"
        case ir.EntityType():
            yield f"{pad}{label}: {value.what!r}"
            yield from (f"{pad}kind: {name!r}" for name in value.names)
        case tuple() if any(isinstance(v, ir.Node) for v in value):
            for index, item in enumerate(value):
                yield from _node_lines(item, f"{label}[{index}]", depth, positions)
        case None | () | "":
            return
        case _:
            yield f"{pad}{label}: {value!r}"


def _type_text(type_: ir.Type) -> str:
    """Returns a type with all that is known of it: `int count 0 .. 9 by { raw, cut }`."""
    by = "".join(f" by {index_set}" for index_set in type_.indexed_by)
    match type_.kind:
        case "word" | "mix":
            return f"{type_.kind} {{ {', '.join(type_.words)} }}{by}"
        case "int" | "real":
            digits = ".17g" if type_.kind == "int" else "g"  # 1000000 and 1000001 are not one range
            return f"{type_.kind} {type_.unit} {type_.low:{digits}} .. {type_.high:{digits}}{by}"
        case "cell":
            return f"cell of {' | '.join(type_.kinds)}{by}"
        case _:
            return type_.kind + by


def _position_text(node: ir.Node, positions: bool) -> str:
    """Returns where a node is written; "" if it is nowhere, or positions aren't printed."""
    if not positions or node.origin is None:
        return ""
    return f"  @{node.origin.file}:{node.origin.line}:{node.origin.column}"
