"""Prints the IR as stable text: expressions as an author would write them, whole games for `dump`."""

from collections.abc import Iterator
from typing import assert_never

from sjdsl.compiler import ir
from sjdsl.compiler.ir.operations import CALCULATIONS


def number_text(value: float) -> str:
    """Returns the shortest text that reads back as the same number; integers without a point."""
    return (
        str(int(value))
        if isinstance(value, int) or (value == int(value) and abs(value) < 1e15)
        else repr(float(value))
    )


def expression(e: ir.Expr) -> str:
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
            return e.name if e.owner is None else f"{expression(e.owner)}.{e.name}"
        case ir.Distance():
            return f"distance({expression(e.left)}, {expression(e.right)})"
        case ir.At():
            return f"{expression(e.row)}[{expression(e.key)}]"
        case ir.Step():
            return "step"
        case ir.Arithmetic():
            row, args = CALCULATIONS[e.fn], [expression(a) for a in e.args]
            if not row.sign:
                return f"{row.name}({', '.join(args)})"
            return (
                f"({row.sign}{args[0]})" if len(args) == 1 else f"({args[0]} {row.sign} {args[1]})"
            )
        case ir.Compare():
            return f"({expression(e.left)} {e.fn} {expression(e.right)})"
        case ir.Same():
            return f"({expression(e.left)} is {expression(e.right)})"
        case ir.InRange():
            return f"({expression(e.value)} in {expression(e.low)} .. {expression(e.high)})"
        case ir.InWords():
            return f"({expression(e.value)} in {{ {', '.join(e.words)} }})"
        case ir.InSet():
            return f"({expression(e.value)} in {expression(e.container)})"
        case ir.IsEmpty():
            return f"({expression(e.container)} is nobody)"
        case ir.Chose():
            return f"({expression(e.agent)} chose #{e.action})"
        case ir.ChoseWith():
            given = f"({', '.join(expression(g.value) for g in e.given)})" if e.given else ""
            return f"({expression(e.agent)} chose {e.action}{given})"
        case ir.ArgumentOf():
            return f"{expression(e.agent)}.{e.action}" + (f".{e.name}" if e.name else "")
        case ir.Unoccupied():
            return f"(nobody on {expression(e.cell)})"
        case ir.StandsOn():
            return f"({expression(e.agent)} on {' | '.join(e.kinds)})"
        case ir.StandsAt():
            return f"({expression(e.agent)} on {expression(e.cell)})"
        case ir.Not():
            return f"(not {expression(e.value)})"
        case ir.Logic():
            return "(" + f" {e.fn} ".join(expression(a) for a in e.args) + ")"
        case ir.Count():
            return f"count({domain(e.domain)})"
        case ir.Sum():
            return f"sum({expression(e.value)} over {domain(e.domain)})"
        case ir.SumRow():
            return f"{e.fn}({expression(e.row)})"
        case ir.ShiftRow():
            return f"shift({expression(e.row)}, {e.by}, {expression(e.filler)})"
        case ir.Lowest():
            return f"{'highest' if e.last else 'lowest'}({expression(e.row)})"
        case ir.Mix():
            return f"mix({expression(e.row)})"
        case ir.Extreme():
            otherwise = "" if e.otherwise is None else f" otherwise {expression(e.otherwise)}"
            return f"{e.fn}({expression(e.value)} over {domain(e.domain)}{otherwise})"
        case ir.Case():
            return f"case {expression(e.subject)} {{ {', '.join(_arm(a) for a in e.arms)} }}"
        case ir.Named() | ir.Narrowed():
            return expression(e.value)
        case ir.Before():
            return f"before({expression(e.value)})"
        case ir.EventTotal():
            return e.name if e.word is None else f"{e.name}[{e.word}]"
        case ir.MatrixClass():
            return f"{e.name}({expression(e.table)})"
        case _:
            assert_never(e)


def _arm(arm: ir.Arm) -> str:
    if arm.words:
        key = " | ".join(arm.words)
    elif arm.low == arm.high:
        key = str(arm.low)
    else:
        key = f"{'' if arm.low is None else arm.low}..{'' if arm.high is None else arm.high}"
    return f"{key}: {expression(arm.value)}"


def domain(d: ir.Domain) -> str:
    """Returns a domain in the syntax of the language; a group shows as its kinds."""
    parts = [d.var.sort.name, f"as {d.var.name}"]
    if d.on is not None:
        parts.append(f"on {' | '.join(d.on.kinds)} as {d.on.name}")
    match d.restriction:
        case ir.Near():
            parts.append(f"in {d.restriction.shape} of {d.restriction.anchor.name}")
        case ir.InAgents() | ir.InCell():
            parts.append(f"in {expression(d.restriction.value)}")
        case ir.Among():
            parts.append(f"in {{ {', '.join(m.name for m in d.restriction.members)} }}")
        case None:
            pass
    if d.where is not None:
        parts.append(f"where {expression(d.where)}")
    return " ".join(parts)


def game(g: ir.Game, positions: bool = False) -> str:
    """Returns the whole IR as indented text, one node or value a line; two games are equal if and only if their texts are."""
    return "\n".join(_lines(g, "game", 0, positions)) + "\n"


def _lines(value: object, label: str, depth: int, positions: bool) -> Iterator[str]:
    pad = "  " * depth
    match value:
        case ir.Node() if ir.is_expression(value):
            yield f"{pad}{label}: {expression(value)}  : {_type(value.type)}{_at(value, positions)}"
        case ir.Domain():
            yield f"{pad}{label}: {domain(value)}{_at(value, positions)}"
        case ir.Node():
            yield (
                f"{pad}{label}"
                if isinstance(value, ir.Game)
                else f"{pad}{label}: {type(value).__name__.lower()}{_at(value, positions)}"
            )
            for name in type(value).model_fields:
                if name != "origin":
                    yield from _lines(getattr(value, name), name, depth + 1, positions)
        case ir.Type():
            yield f"{pad}{label}: {_type(value)}"
        case ir.Entry():
            yield f"{pad}{label}: {value.name!r}"
        case ir.Level():
            yield f"{pad}{label}: {value.names!r}"
        case ir.Sort():
            yield f"{pad}{label}: {value.what!r}"
            yield from (f"{pad}kind: {name!r}" for name in value.names)
        case tuple() if any(isinstance(v, ir.Node) for v in value):
            for index, item in enumerate(value):
                yield from _lines(item, f"{label}[{index}]", depth, positions)
        case None | () | "":
            return
        case _:
            yield f"{pad}{label}: {value!r}"


def _type(type_: ir.Type) -> str:
    by = "".join(f" by {level}" for level in type_.by)
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


def _at(node: ir.Node, positions: bool) -> str:
    return (
        f"  @{node.origin.file}:{node.origin.line}:{node.origin.column}"
        if positions and node.origin
        else ""
    )
