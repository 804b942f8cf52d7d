"""Breaks expressions into lines of at most 120 columns, as a formatter would."""

from sjdsl.compiler.emit.expressions import Bracketed, Chain, Operation, Piece, flat

WIDTH = 120
INDENT = 4


def layout(piece: Piece, column: int, indent: int, after: int, bracketed: bool = False) -> str:
    """Returns the text of an expression.

    Args:
      column: where its first line begins.
      indent: of the lines that follow it.
      after: columns that what follows needs behind the last line.
      bracketed: whether it stands in brackets, so that a line may end anywhere.
    """
    whole = flat(piece)
    if column + len(whole) + after <= WIDTH or isinstance(piece, str):
        return whole
    if isinstance(piece, Chain):
        return _chain(piece, column, indent, after)
    op, last = piece.rest[-1]
    last_fits = indent + len(f"{op} {flat(last)}") + after <= WIDTH
    if not bracketed or not last_fits:
        broken = _last_broken(piece, column, indent, after)
        if broken is not None:
            return broken
    if not bracketed:
        inside = layout(piece, indent + INDENT, indent + INDENT, 0, bracketed=True)
        return f"(\n{' ' * (indent + INDENT)}{inside}\n{' ' * indent})"
    lines = [layout(piece.first, column, indent, 0, bracketed=True)]
    for number, (op, operand) in enumerate(piece.rest, 1):
        tail = after if number == len(piece.rest) else 0
        lines.append(f"{op} {layout(operand, indent + len(op) + 1, indent, tail, bracketed=True)}")
    return f"\n{' ' * indent}".join(lines)


def _last_broken(piece: Operation, column: int, indent: int, after: int) -> str | None:
    """Returns `a + f(` … `)`, where only the last operand is broken.

    None if what is before it doesn't fit on the first line.
    """
    *before, (op, last) = piece.rest
    head = f"{flat(Operation(piece.first, tuple(before)))} {op} "
    if not isinstance(last, Chain) or column + len(head) > WIDTH // 2:
        return None
    broken = _chain(last, column + len(head), indent, after)
    first_line = head + broken.split("\n")[0]
    return head + broken if column + len(first_line) <= WIDTH else None


def _chain(chain: Chain, column: int, indent: int, after: int) -> str:
    """Breaks the longest brackets of a chain, and others as far as the lines are still too long."""
    brackets = [part for part in chain.pieces if isinstance(part, Bracketed) and part.items]
    if not brackets:
        return flat(chain)
    longest = max(brackets, key=lambda bracket: len(flat(bracket)))
    place = chain.pieces.index(longest)
    before = Chain(chain.pieces[:place])
    behind = Chain(chain.pieces[place + 1 :])
    head = layout(before, column, indent, len(longest.open))
    items = _items(longest, indent + INDENT)
    tail = layout(behind, indent + len(longest.close), indent, after)
    return f"{head}{longest.open}\n{items}\n{' ' * indent}{longest.close}{tail}"


def _items(bracket: Bracketed, indent: int) -> str:
    """Returns what is in brackets, on one line if it fits, else on a line for each item."""
    together = ", ".join(map(flat, bracket.items))
    if bracket.comma:
        together += ","
    chains = [item for item in bracket.items if isinstance(item, Chain)]
    has_rows = any(isinstance(chain.pieces[0], Bracketed) for chain in chains)
    if indent + len(together) <= WIDTH and not has_rows and bracket.open != "{":
        return " " * indent + together
    comma = "," if len(bracket.items) > 1 or bracket.comma else ""
    lines = [layout(item, indent, indent, len(comma), bracketed=True) for item in bracket.items]
    return "\n".join(f"{' ' * indent}{line}{comma}" for line in lines)
