"""The English of `define`s: each is explained once, with placeholders for its free variables."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.free_variables import Variable, free_variables, renamed
from sjdsl.doc.phrases import condition, value
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import Line, code, joined, variable

PLACEHOLDERS = "xyzuvw"


def vocabulary(game: ir.Game) -> Vocabulary:
    """Returns the names of a game; a define counts as explained if all its uses say the same of what they are about."""
    bare = Vocabulary(game)
    forms: dict[str, set[str]] = {}
    for node in ir.walk(game):
        if isinstance(node, ir.Named):
            forms.setdefault(node.name, set()).add(_meaning(node, bare).text)
    return Vocabulary(game, frozenset(name for name, found in forms.items() if len(found) == 1))


def explained(v: Vocabulary) -> list[Line]:
    """Returns what each explained define means, in the order in which they are met."""
    found: dict[str, Line] = {}
    for node in ir.walk(v.game):
        if isinstance(node, ir.Named) and node.name in v.defined and node.name not in found:
            found[node.name] = _meaning(node, v)
    return list(found.values())


def _meaning(node: ir.Named, v: Vocabulary) -> Line:
    general, names = generalised(node)
    nouns = ((v.noun(free) if isinstance(free, ir.Member) else "a value", x) for free, x in names)
    about = joined(f"{noun} {variable(x)}" for noun, x in nouns) if names else ""
    name = code(node.name) + (f" of {about}" if about else "")
    if node.type.kind == "condition":
        return Line(f"{name} holds if {condition(general, v)}")
    return Line(f"{name} is {value(general, v)}")


def generalised(node: ir.Named) -> tuple[ir.Expr, list[tuple[Variable, str]]]:
    """Returns a define's value with `x`, `y`, … for what it is about, and which variable stood for which of them."""
    free = free_variables(node.value)
    taken = {n.name for n in ir.walk(node.value) if isinstance(n, ir.Member | ir.Local)}
    letters = [c for c in PLACEHOLDERS if c not in taken]
    names = dict(zip((f.name for f in free), letters, strict=False))
    return renamed(node.value, names), [(f, names.get(f.name, f.name)) for f in free]
