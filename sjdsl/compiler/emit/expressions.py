"""Expressions as Python text on one line: operator precedence and brackets.

An operand gets brackets where Python's precedence asks for them, and where a bit operation meets
another operation: few readers know whether `a + b & c == d` is `((a + b) & c) == d`.
"""

from math import copysign
from typing import assert_never

from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.emit.escaping import quoted
from sjdsl.compiler.program.expressions import (
    DTYPES,
    Arange,
    Attribute,
    Binary,
    Broadcast,
    Call,
    Cast,
    Expression,
    Index,
    Lambda,
    Literal,
    Mapping,
    Name,
    Sequence,
    Slice,
    Unary,
    Where,
    call,
)

LAMBDA = -1
COMPARISON = 0
UNARY = 6
ATOM = 7
PYTHON_PRECEDENCE = {
    **dict.fromkeys(("<", "<=", ">", ">=", "==", "!="), COMPARISON),
    **{
        op: strength
        for strength, ops in enumerate(("| ^", "&", "<< >>", "+ -", "* / // %"), 1)
        for op in ops.split()
    },
}
BITWISE = {"|", "^", "&", "<<", ">>"}


class Bracketed(Record):
    """Items between `open` and `close`, separated by commas.

    comma: whether one follows the last item even on one line.
    """

    open: str
    items: tuple["Piece", ...]
    close: str
    comma: bool = False


class Chain(Record):
    """Pieces one after another without anything between them: `state`, `.position`, `[…]`."""

    pieces: tuple["str | Bracketed", ...]


class Operation(Record):
    """Operands and operators, which may be on lines of their own: `a`, `+ b`, `+ c`."""

    first: "Piece"
    rest: tuple[tuple[str, "Piece"], ...]


Piece = str | Chain | Operation


def text(node: Expression) -> str:
    """Returns an expression on one line."""
    return flat(pieces(node))


def flat(piece: "Piece | Bracketed") -> str:
    """Returns pieces on one line."""
    match piece:
        case str():
            return piece
        case Bracketed():
            return piece.open + ", ".join(map(flat, piece.items)) + "," * piece.comma + piece.close
        case Chain():
            return "".join(map(flat, piece.pieces))
        case Operation():
            rest = [f" {op} {flat(operand)}" for op, operand in piece.rest]
            return flat(piece.first) + "".join(rest)


def pieces(node: Expression | Slice) -> Piece:
    """Returns an expression as pieces that `layout` breaks into lines."""
    match node:
        case Name():
            return node.identifier
        case Literal():
            if node.name:
                return node.name
            if isinstance(node.value, str):
                return quoted(node.value)
            return "..." if node.value is ... else repr(node.value)
        case Slice():
            start = "" if node.start is None else text(node.start)
            stop = "" if node.stop is None else text(node.stop)
            return f"{start}:{stop}"
        case Unary():
            return _after(node.op, _operand(node.operand, UNARY))
        case Binary():
            return _operation(node)
        case Sequence(items=items, is_list=is_list):
            inner = tuple(map(pieces, items))
            if is_list:
                return Chain((Bracketed("[", inner, "]"),))
            return Chain((Bracketed("(", inner, ")", comma=len(items) == 1),))
        case Mapping():
            entries = [_after(f"{quoted(key)}: ", pieces(value)) for key, value in node.entries]
            return Chain((Bracketed("{", tuple(entries), "}"),))
        case Lambda():
            return _after(f"lambda {', '.join(node.parameters)}: ", pieces(node.body))
        case Attribute():
            return Chain((*_base(node.value), f".{node.name}"))
        case Index():
            return Chain((*_base(node.value), Bracketed("[", tuple(map(pieces, node.keys)), "]")))
        case Call():
            named = [_after(f"{name}=", pieces(value)) for name, value in node.keywords]
            arguments = (*map(pieces, node.arguments), *named)
            return Chain((*_base(node.function), Bracketed("(", arguments, ")")))
        case Where():
            return pieces(call("jnp.where", node.condition, node.then, node.otherwise))
        case Cast():
            return pieces(Call(Attribute(node.value, "astype"), (DTYPES[node.dtype],)))
        case Broadcast():
            return pieces(call("jnp.broadcast_to", node.value, Sequence(node.shape)))
        case Arange():
            dtype = {} if node.dtype is None else {"dtype": DTYPES[node.dtype]}
            return pieces(call("jnp.arange", node.size, **dtype))
        case _:
            assert_never(node)


def _base(node: Expression) -> list["str | Bracketed"]:
    """Returns what a trailer follows, in brackets unless it binds as tightly."""
    is_value = isinstance(node, Literal) and not isinstance(node.value, str) and not node.name
    if is_value or _strength(node) < ATOM:
        return [Bracketed("(", (pieces(node),), ")")]
    base = pieces(node)
    return list(base.pieces) if isinstance(base, Chain) else [flat(base)]


def _strength(node: Expression) -> int:
    """Returns how tightly the outermost operation of an expression binds."""
    match node:
        case Binary():
            return PYTHON_PRECEDENCE[node.op]
        case Unary():
            return UNARY
        case Literal(value=bool()):
            return ATOM
        case Literal(value=int() | float() as value, name="") if copysign(1, value) < 0:
            return UNARY
        case Lambda():
            return LAMBDA
        case _:
            return ATOM


def _operand(node: Expression, least: int) -> Piece:
    """Returns an operand, in brackets if it binds less than it must."""
    mixes_bits = least == COMPARISON + 1 and isinstance(node, Binary) and node.op in BITWISE
    if mixes_bits or _strength(node) < least:
        return Chain((Bracketed("(", (pieces(node),), ")"),))
    return pieces(node)


def _operation(node: Binary) -> Operation:
    """Returns an operation; `(a + b) + c` is one of three operands."""
    strength = PYTHON_PRECEDENCE[node.op]
    inner = UNARY if node.op in BITWISE else strength + 1
    right = _operand(node.right, inner)
    left = node.left
    if isinstance(left, Binary) and strength != COMPARISON:
        is_alike = PYTHON_PRECEDENCE[left.op] == strength
        if is_alike and (left.op == node.op or node.op not in BITWISE):
            before = _operation(left)
            return Operation(before.first, (*before.rest, (node.op, right)))
    return Operation(_operand(left, inner), ((node.op, right),))


def _after(prefix: str, piece: Piece) -> Piece:
    """Returns a piece with a text in front of it."""
    match piece:
        case str():
            return prefix + piece
        case Chain():
            return Chain((prefix, *piece.pieces))
        case Operation():
            return Operation(_after(prefix, piece.first), piece.rest)
